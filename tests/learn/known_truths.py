"""Learning problems of known truth, with outliers and starts that are up to ten times off.

Each problem is a scene with numbers in its text. The data are a run with other numbers, with
noise of 1 % of what is measured and outliers of up to its whole range. A learning is right if
every truth lies within ``FAR`` times the half width of its interval. It may fail and say so;
it must not end as done and be wrong. ``python -m tests.learn.known_truths`` tries all of them.
"""

import sys
import time
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from msgspec import Struct

import tissuec
from tissuec.learn.fit.learning import Unlearnable, learn
from tissuec.learn.fit.outcome import Learnt
from tissuec.learn.report import is_identified
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

FAR = 2.5  # half widths of the interval: 5 standard deviations
NOISE = 0.01  # of the standard deviation of what is measured
SHARES = (0.0, 0.03, 0.1)  # of outliers
WRONGEST = 10.0  # factor between a start and the truth
SEEDS = (1, 2, 3, 4)

CHAIN = """language 1
tissue gum {{ spring constant = {c} N/m; viscosity = {d} mN*s/m; mass = {m} g }}
body net {{ mesh is explicit; tissue is gum }}
table nodes of net in mm with columns "id x" {{ 1 0; 2 100; 3 200 }}
table springs of net with columns "a b" {{ 1 2; 2 3 }}
set wall = nodes of net in [1]
set tip = nodes of net in [3]
environment {{ gravity = (0, 0, 0) m/s^2 }}
"""
KICKED = (
    CHAIN
    + """param kick = 0.5 m/s
script {{ at 0 s: fix wall; at 0 s: change velocity of tip to (kick, 0, 0) }}
simulate {{ duration = 1 s; tolerance = 1e-9 }}
output {{ force of wall every 10 ms; position of tip every 10 ms }}
learn gum {{
  data = "data.csv"
  fit = force(wall along (1, 0, 0)) using column "force of wall" in N
  fit = position(tip along (1, 0, 0)) using column "position of tip" in m with free zero
  adjust = [spring constant, viscosity, mass]
}}
"""
)
THROWN = (
    CHAIN
    + """script {{ at 0 s: fix wall }}
simulate {{ duration = 1 s; tolerance = 1e-9 }}
output {{ position of tip every 10 ms }}
learn gum {{
  data = "data.csv"
  fit = position(tip along (1, 0, 0)) using column "position of tip" in m
  adjust = [spring constant, viscosity]
  adjust start velocity of tip along (1, 0, 0)
}}
"""
).replace('"id x" {{ 1 0; 2 100; 3 200 }}', '"id x vx in m/s" {{ 1 0 0; 2 100 0; 3 200 {v} }}')
SHAKEN = """language 1
tissue gum {{ spring constant = {c} N/m; viscosity = {d} mN*s/m; mass = {m} g
  viscosity law is power {{ exponent = {n}; speed = 50 mm/s }} }}
body net {{ mesh is explicit; tissue is gum }}
table nodes of net in mm with columns "id x" {{ 1 0; 2 100 }}
table springs of net with columns "a b" {{ 1 2 }}
set hand = nodes of net in [1]
set tip = nodes of net in [2]
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{ from 0 s to 1 s: move hand by (4, 0, 0) mm using sine of 3 Hz }}
simulate {{ duration = 1 s; tolerance = 1e-9 }}
output {{ force of hand every 10 ms; position of tip every 10 ms }}
learn gum {{
  data = "data.csv"
  fit = force(hand along (1, 0, 0)) using column "force of hand" in N
  fit = position(tip along (1, 0, 0)) using column "position of tip" in m
  adjust = [spring constant, viscosity, exponent, mass]
}}
"""
SAGGING = """language 1
tissue left gum {{ spring constant = {c} N/m; viscosity = {d} mN*s/m; mass = 1 g }}
tissue right gum {{ spring constant = {k} N/m; viscosity = 60 mN*s/m; mass = 1 g }}
body net {{ mesh is sheet {{ corner = (0, 0, 0) mm; first edge = (40, 0, 0) mm
  second edge = (0, 20, 0) mm; columns = 5; rows = 3; diagonals is both }}
  tissue is left gum
  region right where x > 20 mm {{ tissue is right gum }}
  interface is mean }}
set pins = nodes of net where x < 1 mm
set tip = nodes of net where x > 39 mm
set middle = nodes of net where x == 20 mm
environment {{ gravity = (9.81, 0, 0) m/s^2 }}
script {{ at 0 s: fix pins }}
simulate {{ duration = 0.4 s; tolerance = 1e-9 }}
output {{ position of tip every 5 ms; position of middle every 5 ms }}
learn gum {{
  data = "data.csv"
  fit = position(tip along (1, 0, 0)) using column "position of tip" in m
  fit = position(middle along (1, 0, 0)) using column "position of middle" in m
  adjust spring constant of left gum
  adjust spring constant of right gum
  adjust viscosity of left gum
}}
"""
DRAWN = """language 1
tissue tendon {{ {law}; spring constant = {c} N/m; viscosity = 10 mN*s/m; mass = 20 mg }}
body strand {{ mesh is explicit; tissue is tendon }}
table nodes of strand in mm with columns "id x" {{ 0 0; 1 10; 2 20; 3 30; 4 40 }}
table springs of strand with columns "a b" {{ 0 1; 1 2; 2 3; 3 4 }}
set root = nodes of strand in [0]
set tip = nodes of strand in [4]
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{ at 0 s: fix root; from 0 s to 1 s: move tip by (10, 0, 0) mm using constant speed }}
simulate {{ duration = 1 s }}
learn tendon {{
  data = "data.csv"
  displacement of tip using column "u" in m
  fit = force(tip along (1, 0, 0)) using column "F" in N
  adjust = [spring constant, {constants}]
}}
"""
STIFFENING = "spring law is exponential {{ stiffening = {s} }}"
CUBIC = "spring law is polynomial {{ square = {a} kN/m^2; cube = {b} kN/m^3 }}"


class Family(Struct, frozen=True):
    """Problems of one kind: a text, what is usual in it, and what a start does not know.

    Attributes:
        usual: Numbers around which truths are drawn, by their names in the text.
        blank: Numbers that a start has instead.
        learnt: Names of the numbers in the order of the estimates.
        known: Names of numbers that a start has right.
    """

    text: str
    usual: dict[str, float]
    learnt: str
    blank: dict[str, float] | None = None
    known: str = ""


FAMILIES = {
    "kicked": Family(KICKED, {"c": 20.0, "d": 80.0, "m": 30.0}, "cdm"),
    "thrown": Family(
        THROWN, {"c": 20.0, "d": 80.0, "m": 30.0, "v": 0.5}, "cdv", {"v": 0.0}, "m"
    ),
    "shaken": Family(SHAKEN, {"c": 40.0, "d": 200.0, "m": 50.0, "n": 1.0}, "cdnm", {"n": 1.0}),
    "sagging": Family(SAGGING, {"c": 60.0, "k": 60.0, "d": 100.0}, "ckd"),
    "drawn": Family(
        DRAWN.replace("{law}", STIFFENING).replace("{constants}", "stiffening"),
        {"c": 40.0, "s": 6.0},
        "cs",
    ),
    "cubic": Family(
        DRAWN.replace("{law}", CUBIC).replace("{constants}", "square, cube"),
        {"c": 40.0, "a": 8.0, "b": 800.0},
        "cab",
        {"a": 0.0, "b": 0.0},
    ),
}
NAMES = [f"{name} {seed}" for seed in SEEDS for name in FAMILIES][:20]


class Result(Struct, frozen=True):
    """How a learning ended.

    Attributes:
        ended: "right", "wrong" or "failed".
        said: Why it failed.
        off: How far each truth is from its estimate, in half widths of the interval.
        seconds: That it took.
    """

    name: str
    share: float
    ended: str
    said: str
    off: np.ndarray
    seconds: float

    def __str__(self) -> str:
        worst = f"{self.off.max(initial=0.0):6.2f}" if self.ended != "failed" else "      "
        return (
            f"{self.name:12} {100 * self.share:3.0f} % outliers  {self.ended:6} {worst} "
            f"{self.seconds:6.1f} s  {self.said}"
        )


def tried(name: str, share: float, folder: Path) -> Result:
    """Return how the learning of a problem ends.

    Args:
        share: Of outliers.
        folder: Where texts and data go.
    """
    kind, seed = name.split()
    family, random = FAMILIES[kind], np.random.default_rng(int(seed))
    truth = {k: v * 2.0 ** random.uniform(-1, 1) for k, v in family.usual.items()}
    far = np.log(WRONGEST)
    start = {
        k: v if k in family.known else v * np.exp(random.uniform(-far, far))
        for k, v in truth.items()
    } | (family.blank or {})
    write_measured(family, truth, share, folder, random)
    (folder / "scene.tis").write_text(family.text.format(**start))
    request = Request.file(folder / "scene.tis")
    compiled, _ = compile_request(request)
    began = time.process_time()
    try:
        learnt = learn(compiled, compiled.fit_problems[0], request)
        said = _complaint(learnt)
        off = _off(learnt, [_in_si(family, k, truth[k]) for k in family.learnt])
    except Unlearnable as failure:
        said, off = str(failure), np.zeros(0)
    ended = "failed" if said else "right" if off.max() <= FAR else "wrong"
    return Result(name, share, ended, said, off, time.process_time() - began)


def _complaint(learnt: Learnt) -> str:
    """Return why a learning fails; empty if it is done."""
    if learnt.failure or not learnt.converged:
        return learnt.failure or learnt.reason
    return "" if is_identified(learnt) else "; ".join(one.sentence for one in learnt.blind)


def _off(learnt: Learnt, truths: list[float]) -> np.ndarray:
    """Return how far truths are from estimates, in half widths of the intervals."""
    value, low, high = (
        np.concatenate([getattr(one, name) for one in learnt.estimates])
        for name in ("value", "low", "high")
    )
    truth = np.array(truths)
    half = np.where(truth > value, high - value, value - low)
    return np.abs(truth - value) / half


def _in_si(family: Family, name: str, value: float) -> float:
    units = {"d": 1e-3, "m": 1e-3, "a": 1e3, "b": 1e6 / 1e3}
    return value * units.get(name, 1.0)


def write_measured(
    family: Family, truth: dict[str, float], share: float, folder: Path, random
) -> None:
    """Write a table of what is measured of the truth."""
    text = family.text.format(**truth)
    text = text[: text.index("learn ")]
    (folder / "true.tis").write_text(text)
    columns = dict(_curve(family, truth) if "output" not in text else _motion(folder))
    rows = {}
    for name, values in columns.items():
        if name not in ("t_s", "u"):
            size = values.std()
            values = values + NOISE * size * random.standard_normal(len(values))
            wild = random.random(len(values)) < share
            values[wild] += size * random.uniform(-3, 3, int(wild.sum()))
        rows[name] = values
    lines = [
        ",".join(rows),
        *(",".join(map(repr, map(float, r))) for r in zip(*rows.values(), strict=True)),
    ]
    (folder / "data.csv").write_text("\n".join(lines) + "\n")


def _motion(folder: Path) -> Iterator[tuple[str, np.ndarray]]:
    run = tissuec.run(folder / "true.tis")
    for number, (name, log) in enumerate(run.logs.items()):
        if not number:
            yield "t_s", np.array(log.time)
        yield name, np.array(log.value[:, 0])


def _curve(family: Family, truth: dict[str, float]) -> Iterator[tuple[str, np.ndarray]]:
    """Yield the force of a strand of four springs against its elongation, in closed form."""
    u = np.linspace(0.0, 10e-3, 20)
    yield "u", u
    e, c = u / 4, truth["c"]
    if "s" in truth:
        yield "F", c * 0.01 / truth["s"] * np.expm1(truth["s"] * e / 0.01)
    else:
        a, b = (_in_si(family, k, truth[k]) for k in "ab")
        yield "F", c * e + a * e**2 + b * e**3


def main() -> None:
    """Try the problems that are named, or all of them, and print how each ends."""
    results = []
    for name in sys.argv[1:] or NAMES:
        for share in SHARES:
            with TemporaryDirectory() as folder:
                results.append(tried(name, share, Path(folder)))
            print(results[-1], flush=True)
    inside = np.concatenate([one.off for one in results if one.ended != "failed"]) <= 1.0
    counts = {
        end: sum(one.ended == end for one in results) for end in ("right", "failed", "wrong")
    }
    print(f"{counts}; {100 * inside.mean():.0f} % of {len(inside)} intervals hold the truth")


if __name__ == "__main__":
    main()
