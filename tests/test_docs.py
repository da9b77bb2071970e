"""What the pages say is so: scenes compile, commands answer as shown, tables are up to date.

Every fenced block of a page is taken in order, in a folder of the page's own:

- ``tis NAME`` is a file of that name, ``tis + NAME`` more lines of it, ``tis`` a file without a
  name; all are checked. A ``tis`` block that does not begin with "language" is a part of the
  scene ``examples.tis`` of the language reference, which has what it leaves out.
- ``tis runs`` is a scene that is run as well: it ends as planned, and its expectations hold.
- ``wrong NAME`` is a file with mistakes, ``csv NAME`` a table, ``obj NAME`` a mesh.
- ``console`` holds commands behind "$ " and what they answer. "…" stands for anything within a
  line, and for any lines where it stands alone. ``VARYING`` parts need to agree about or not at
  all, such as what the clock, or the last digits of the processor, decide. ``console long``
  is only run with ``-m slow``.
- ``python`` is run, one namespace for all of a page; ``python FILE`` as that module of the
  package. ``output`` is what the last one printed. Where a library is missing that a block
  needs, the rest of the page is skipped.

Other blocks are for reading only.
"""

import io
import re
import shlex
import sys
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from msgspec import Struct, field

from docs.reference.pages import outdated, unused
from tests.whole_runs import carried_out
from tissuec.compiler.checks import CHECKS
from tissuec.core.errors import CompileError, render
from tissuec.core.source import Source
from tissuec.engine.integrators import INTEGRATORS
from tissuec.forces.acting import FORCES
from tissuec.geometry.surfaces import SURFACES
from tissuec.laws import SPRING_LAWS
from tissuec.laws.solid import SOLID_LAWS
from tissuec.meshes.formats import FORMATS
from tissuec.meshes.generators import MESHES
from tissuec.pipeline import check_request, compile_request
from tissuec.results.fields import FIELDS
from tissuec.scene.reading.parts import PARTS, forget
from tissuec.scene.request import Request
from tissuec.script.measures import MEASURES
from tissuec.script.tools import TOOLS
from tissuec.script.verbs import VERBS
from tissuec.validate.forces import FORMULAS
from tissuec.view.plots import PLOTS

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
PAGES = sorted([*DOCS.rglob("*.md"), ROOT / "README.md"])
RUN = [page for page in PAGES if page.name != "errors.md"]  # its pairs have tests of their own
FENCE = re.compile(
    r"^```(?P<kind>\w+)(?: (?P<name>[^\n]*))?\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL
)
LINK = re.compile(r"\]\((?!https?:)(?P<path>[^)#\s]*)(?:#(?P<anchor>[^)\s]*))?\)")

#: What may differ: patterns, and the largest ratio of a number to that on the page, if any.
VARYING = {
    r"\d+ steps": 1.05,
    r"\d(?:\.\d+)?e[-+]\d+": 5.0,
    r"\((?:interpreted|compiled)\)": None,
    r"\d+\.\d\d s\b": None,
    r"/\w+\.tis:\d+": None,  # lines of the library move
    r"(?<=  )[\d.]+ m?s(?:, node \d+ of \w+)?$": None,  # where an error is largest
}
LONG, RUNS = "long", "runs"
PART = re.compile("|".join(VARYING), re.MULTILINE)
ROUNDING = 1e-10  # what is less differs between processors


def name_of(page: Path) -> str:
    """Return the name of a page, with its folder if that is not the one of all pages."""
    return page.stem if page.parent in (DOCS, ROOT) else f"{page.parent.name}-{page.stem}"


class Block(Struct, frozen=True):
    """One fenced block; ``place`` is where it stands, for messages."""

    kind: str
    name: str
    text: str
    place: str


def blocks(page: Path) -> Iterator[Block]:
    """Yield the fenced blocks of a page."""
    return blocks_of(page.read_text(encoding="utf-8"), page.name)


def blocks_of(text: str, name: str) -> Iterator[Block]:
    """Yield the fenced blocks of a text that is called by a name in messages."""
    for found in FENCE.finditer(text):
        line = text.count("\n", 0, found.start()) + 1
        yield Block(found["kind"], found["name"] or "", found["text"], f"{name}:{line}")


class Reader(Struct):
    """Does what the blocks of one page say, in the present folder."""

    namespace: dict[str, Any] = field(default_factory=dict)
    said: str = ""
    code: int = 0

    def tis(self, block: Block) -> None:
        runs = block.name == RUNS
        name, text = "" if runs else block.name.removeprefix("+ "), block.text
        path = Path(name) if name else None
        if name != block.name and not runs:
            text = Path(name).read_text(encoding="utf-8") + text
        elif not text.startswith("language"):
            text = with_scaffold(text)
        if path is not None:
            self.wrong(Block("wrong", name, text, block.place))
        beside = Path("runs.tis") if runs else path  # of tables and meshes that it names
        request = Request(Source(name or block.place, text, beside))
        try:
            if runs:
                assert_runs(request)
            else:
                check_request(request)
        except CompileError as error:
            pytest.fail("\n".join([block.place, *map(render, error.diagnostics)]))

    def wrong(self, block: Block) -> None:
        path = Path(block.name)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(block.text, encoding="utf-8")

    csv = obj = wrong

    def console(self, block: Block) -> None:
        commands = re.split(r"^\$ ", block.text, flags=re.MULTILINE)
        assert not commands[0].strip(), f'{block.place}: a command begins with "$ "'
        for part in commands[1:]:
            line, _, expected = part.partition("\n")
            assert_alike(self.command(line), expected, f"{block.place}: $ {line}")

    def command(self, line: str) -> str:
        """Return what a command line says."""
        if line == "echo $?":
            return f"{self.code}\n"
        words, target = shlex.split(line, comments=True), None
        if words[-2] == ">":
            words, target = words[:-2], words[-1]
        assert words[0] == "tissuec", f"{line}: only tissuec is run here"
        if words[1] == "plot":
            pytest.importorskip("matplotlib")
        out, both = io.StringIO(), io.StringIO()
        with redirect_stdout(out if target else both), redirect_stderr(both):
            self.code = tissuec(words)
        if target:
            Path(target).write_text(out.getvalue(), encoding="utf-8")
        return both.getvalue()

    def python(self, block: Block) -> None:
        if "matplotlib" in block.text or "tissuec.view.plots" in block.text:
            pytest.importorskip("matplotlib").use("Agg")
        for package in ("pandas", "xarray", "pyvista"):
            if f"to_{package}" in block.text:
                pytest.importorskip(package)
        if "import nrrd" in block.text:
            pytest.importorskip("skimage.measure", reason="needs the images extra")
            pytest.importorskip("nrrd", reason="needs the images extra")
        said = io.StringIO()
        module = block.name.removesuffix(".py").replace("/", ".")
        space = {"__name__": module} if module else self.namespace
        with redirect_stdout(said):
            exec(compile(block.text, block.place, "exec"), space)
        self.said = said.getvalue()

    def output(self, block: Block) -> None:
        assert_alike(self.said, block.text, block.place)


def assert_runs(request: Request) -> None:
    """Run a scene, which ends as planned, and whose expectations hold."""
    compiled, _ = compile_request(request)
    outcome, _ = carried_out(compiled)
    failures = [failure.measured for failure in outcome.failures]
    assert (outcome.kind, failures) == ("done", []), f"{request.source.name}: {outcome.message}"


def tissuec(words: list[str]) -> int:
    """Run the command line in this process; return its exit code."""
    from tissuec.cli import main

    before, sys.argv = sys.argv, words
    try:
        main()
    except SystemExit as end:
        return int(end.code or 0)
    finally:
        sys.argv = before
    raise AssertionError("the command line always exits")


def with_scaffold(part: str) -> str:
    """Return the scene of the examples with a part in place of what says the same there."""
    rest = [text for head, text in scaffold().items() if not re.search(f"^{head}", part, re.M)]
    return "\n".join(["language 1", *rest, part])


@cache
def scaffold() -> dict[str, str]:
    """Return the statements of the scene of the examples, by patterns of how they begin."""
    (scene,) = (b for b in blocks(DOCS / "language" / "index.md") if b.name == "examples.tis")
    _, *statements = re.split(r"^(?=\w)", scene.text.removeprefix("language 1\n"), flags=re.M)
    return {
        re.escape(re.split(r" [={]", text)[0].strip()) + r"(\W|$)": text for text in statements
    }


def assert_alike(said: str, expected: str, where: str) -> None:
    """Compare lines, with "…" for what may differ."""
    if not expected.strip():
        assert not said.strip(), f"{where}\nsaid, unexpectedly:\n{said}"
        return
    lines = expected.rstrip().split("\n")
    pattern = "".join(
        r"(?:.*\n)*?" if line.strip() == "…" else pattern_of(line) + r"[ \t]*\n"
        for line in lines
    )
    found = re.fullmatch(pattern, said.rstrip() + "\n", re.MULTILINE)
    if not found:
        pytest.fail(f"{where}\nsaid:\n{said}\nbut the page shows:\n{expected}", pytrace=False)
    shown = (part for line in lines for part in PART.findall(line.rstrip()))
    for part, came in zip(shown, found.groups(), strict=True):
        assert similar(part, came), f"{where}: {came}, but the page shows {part}"


def pattern_of(line: str) -> str:
    """Return a regular expression for a line in which "…" is anything."""
    line, pattern, done = line.rstrip(), "", 0
    for found in PART.finditer(line):
        pattern += anything(line[done : found.start()]) + f"({kind_of(found[0])})"
        done = found.end()
    return pattern + anything(line[done:])


def anything(text: str) -> str:
    return ".*".join(map(re.escape, text.split("…")))


def kind_of(part: str) -> str:
    """Return the pattern of ``VARYING`` that a part of a line is of."""
    return next(kind for kind in VARYING if re.fullmatch(kind.removeprefix("(?<=  )"), part))


def similar(shown: str, came: str) -> bool:
    """Tell whether a varying part is about what the page shows."""
    ratio = VARYING[kind_of(shown)]
    if ratio is None:
        return True
    one, other = (max(float(part.split()[0]), ROUNDING) for part in (shown, came))
    return max(one, other) <= ratio * min(one, other)


@pytest.fixture
def families_stay():
    """Undo what a page adds to the families."""
    families = (
        MESHES, FORMATS, TOOLS, VERBS, MEASURES, SPRING_LAWS, INTEGRATORS, SURFACES,
        PLOTS, FORCES, FORMULAS, FIELDS, PARTS, SOLID_LAWS, CHECKS,
    )  # fmt: skip
    # Listed first, so that each has all of its own members.
    before = [(family, list(family), dict(family._members)) for family in families]
    yield
    for family, _, members in before:
        family._members.clear()
        family._members.update(members)
    forget()


@pytest.fixture
def read(tmp_path, monkeypatch, families_stay):
    """Return a function that does what a page says, with its long commands or without."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("NO_COLOR", "1")
    monkeypatch.setattr(
        "tissuec.engine.execution.companion.STARTING", 1e9
    )  # what is shown is the same
    # Pictures are not looked at, and to lay out their axes takes half of their time.
    monkeypatch.setattr("tissuec.view.plots.page._lay_out", lambda figure: None)

    def read(page, *, whole):
        reader = Reader()
        for block in blocks(page):
            take = getattr(reader, block.kind, None)
            if take is not None and (whole or block.name != LONG):
                take(block)

    return read


@pytest.mark.parametrize("page", RUN, ids=name_of)
def test_a_page_is_true(page, read):
    read(page, whole=False)


@pytest.mark.slow
@pytest.mark.parametrize(
    "page",
    [page for page in RUN if any(block.name == LONG for block in blocks(page))],
    ids=name_of,
)
def test_a_page_is_true_with_its_long_commands(page, read):
    read(page, whole=True)


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_links_lead_somewhere(page):
    text = page.read_text(encoding="utf-8")
    for found in LINK.finditer(FENCE.sub("", text)):
        target = page.parent / found["path"] if found["path"] else page
        assert target.exists(), f"{page.name}: {found[0]}"
        if found["anchor"]:
            assert found["anchor"] in anchors(target), f"{page.name}: {found[0]}"


def anchors(page: Path) -> set[str]:
    """Return the anchors of the headings of a page, as GitHub makes them."""
    heads = re.findall(
        r"^#+ (.*)$", FENCE.sub("", page.read_text(encoding="utf-8")), re.MULTILINE
    )
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


def test_generated_tables_are_up_to_date():
    stale = [page.name for page in outdated(DOCS)]
    assert not stale, f"run python -m docs.reference: {stale} are out of date"


def test_everything_generated_is_shown_somewhere():
    assert not unused(DOCS)


def test_each_member_with_a_place_is_followed_by_a_scene_that_uses_it():
    without = []
    for page in (DOCS / "language").glob("*.md"):
        text = page.read_text(encoding="utf-8")
        for place in re.findall("<!-- end of ((?:mesh|tool|verb) .*) -->", text):
            rest = text.partition(f"<!-- end of {place} -->")[2]
            scenes = [block.text for block in blocks_of(rest, place) if block.name == RUNS]
            kind, _, name = place.partition(" ")
            word = {"mesh": f"mesh is {name}", "tool": f"kind is {name}", "verb": name}[kind]
            if not scenes or not re.search(rf"\b{word}\b", scenes[0]):
                without.append(place)
    assert not without


def test_each_measure_is_used_by_a_scene_that_runs():
    page = DOCS / "language" / "measures.md"
    scenes = "".join(block.text for block in blocks(page) if block.name == RUNS)
    used = [line for line in scenes.splitlines() if line.startswith("expect")]
    forms = {name: measure.form.partition("A")[0] for name, measure in MEASURES.items()}
    assert not [name for name, form in forms.items() if form not in "".join(used)]


def test_pages_are_linked_from_the_index():
    for index, folder in ((ROOT / "README.md", "docs/"), (DOCS / "language" / "index.md", "")):
        text = index.read_text(encoding="utf-8")
        pages = {page.name for page in (index.parent / folder).glob("*.md")} - {index.name}
        assert not {name for name in pages if f"({folder}{name}" not in text}


def test_pages_of_the_language_are_short():
    lengths = {
        page.name: page.read_text(encoding="utf-8").count("\n")
        for page in (DOCS / "language").glob("*.md")
    }
    assert not {name: length for name, length in lengths.items() if length > 400}
