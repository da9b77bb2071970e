"""Comments of a preset about its origin, and the first one, which identifies its file."""

import textwrap
from collections.abc import Iterator
from pathlib import Path

from tissuec.core.version import __version__
from tissuec.learn.fit.outcome import Estimates, Learnt, interval, judged, percent, shown
from tissuec.scene.request import Request

WIDTH = 96
_LABEL = 13
#: Of these, each number is in a table beside the preset.
ONE_BY_ONE = ("spring", "node")


def origin(learnt: Learnt, request: Request) -> list[str]:
    """Return the comments below the mark: data, noise, method, errors, expectations.

    They name files without their folders, and no time of day, so that the same learning gives
    the same text.
    """
    lines: list[str] = []
    for fitted in learnt.fitted:
        seen = ", held out" if fitted.held_out else ""
        lines += entry("data", f"{fitted.file}{seen}: error {percent(fitted.error)}")
        lines += entry("", f"sha256 {fitted.digest}")
    for text in request.overrides:
        lines += entry("set", text)
    lines += entry("fit", "; ".join(dict.fromkeys(f.text for f in learnt.fit_problem.fits)))
    for text, noise in learnt.noise.items():
        lines += entry("noise", f"{text}: {_of_fit(learnt, text, noise)}")
    for text, zero in learnt.zeros.items():
        lines += entry("zero", f"{text}: {_of_fit(learnt, text, zero)}")
    lines += entry("method", "; ".join(filter(None, (learnt.method, learnt.stepping))))
    lines += entry("error", f"{learnt.first_error:.6g} before, {learnt.error:.6g} after")
    ended = "" if learnt.converged else "NOT CONVERGED: "
    lines += entry("end", f"{ended}{learnt.reason}")
    if learnt.failure:
        lines += entry("", f"FAILED: {learnt.failure}")
    for verdict in judged(learnt):
        holds = "holds" if verdict.holds else "FAILS"
        lines += entry("expected", f"{holds}: {verdict.measured}")
    for blind in learnt.blind:
        lines += entry("not known", f"{blind.sentence} ({blind.advice})")
    for note in learnt.notes:
        lines += entry("note", note)
    return ["#", *lines]


def of_nodes_and_springs(learnt: Learnt, tables: dict[int, str]) -> list[str]:
    """Return comments on what the language says of no tissue.

    Args:
        tables: Names of the tables beside the preset, by the places of estimates.
    """
    lines: list[str] = []
    for place, estimates in enumerate(learnt.estimates):
        adjust = estimates.adjust
        if place in tables:
            text = f"{adjust.what} per {adjust.per} of {adjust.of}: {tables[place]}"
            lines += entry("numbers", text)
        elif adjust.per == "set":
            for number in range(len(estimates.names)):
                lines += entry("number", _of_set(estimates, number))
    return ["#", *lines] if lines else []


def _of_set(estimates: Estimates, number: int) -> str:
    """Return a number that a set has as a whole, with the factor by which it changed."""
    adjust = estimates.adjust
    value, start = float(estimates.value[number]), float(estimates.start[number])
    dimension = adjust.dimension
    known = interval(float(estimates.low[number]), float(estimates.high[number]), dimension)
    if not estimates.identified[number]:
        known = "not identified by the data"
    text = f"{estimates.names[number]}: {shown(value, dimension, digits=6)} (95 %: {known})"
    if start > 0.0 and not adjust.what.startswith("start"):
        text += f", {value / start:.6g} times what it was"
    return f"{text}; before: {shown(start, dimension)}"


def _of_fit(learnt: Learnt, text: str, value: float) -> str:
    dimensions = {fit.text: fit.dimension for fit in learnt.fit_problem.fits}
    return shown(value, dimensions[text]) if text in dimensions else f"{value:.4g}"


def entry(label: str, text: str) -> Iterator[str]:
    """Yield the lines of a comment with a label, all but the first one indented."""
    lines = textwrap.wrap(text, WIDTH - _LABEL, break_long_words=False, break_on_hyphens=False)
    for number, line in enumerate(lines or [""]):
        head = label if number == 0 else ""
        yield f"# {head:<{_LABEL - 3}} {line}".rstrip()


_BEGIN = "# Learned by tissuec"
_LOOKED_AT = 4096  # bytes


def mark(scene: str, fit_problem: str, seed: int) -> str:
    """Return the first comment: by what, of which scene and fit problem, with which seed."""
    return f"{_BEGIN} {__version__} from {scene}, learn {fit_problem}, seed {seed}"


def is_ours(path: Path) -> bool:
    """Return whether learning wrote a file: whether its first comment says so.

    Raises:
        OSError: The file cannot be read.
    """
    with path.open("rb") as file:
        head = file.read(_LOOKED_AT).decode("utf-8", errors="replace")
    comments = (line for line in head.splitlines() if line.startswith("#"))
    return next(comments, "").startswith(f"{_BEGIN} ")
