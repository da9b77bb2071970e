"""Whatever the text: it compiles, or is refused in words that point into it, and soon.

Good scenes are damaged as hands and programs damage them; other texts are hostile on purpose.
Examples are the same in each run.
"""

import re
import tracemalloc
from collections.abc import Sequence
from functools import cache
from itertools import pairwise
from pathlib import Path
from time import process_time

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.examples import examples
from tissuec.core.errors import CompileError, Diagnostic, as_dict, render
from tissuec.core.source import Source, Span
from tissuec.lang.characters import normalise
from tissuec.lang.parser import parse
from tissuec.pipeline import check_request
from tissuec.scene.request import Request

GOOD = sorted((Path(__file__).parent / "scenes" / "good").glob("*.tis"))
SCENES = {path.stem: path.read_text(encoding="utf-8") for path in GOOD}
SOON = 50  # as long as all good scenes are parsed: an answer within seconds
TOKEN = re.compile(r'"[^"\n]*"|#[^\n]*|\d+(?:\.\d+)?(?:[eE][+-]?\d+)?|\w+|\s+|.', re.DOTALL)
NUMBERS = ("0", "-1", "0.5", "1e9", "1e308", "1e-308", "nan", "inf", "1e400")
UNITS = ("m", "km", "um", "nm", "kg", "N", "s", "Hz", "%", "deg", "m/s^2", "mm^99", "")
WORDS = (
    "is",
    "=",
    "and",
    "{",
    "}",
    "(",
    ")",
    "[",
    "]",
    ",",
    ";",
    "\n",
    "of",
    "vessel",
    "x",
    "0 mm",
)


def many(count: int) -> settings:
    """Return settings for a number of examples, the same ones in each run."""
    return settings(
        max_examples=examples(count),
        derandomize=True,
        database=None,
        suppress_health_check=list(HealthCheck),
    )


def parsing() -> float:
    """Return how much processor time it takes at the moment to parse all good scenes [s].

    All of them are short: a parser whose effort grows as the square of a text takes hardly
    longer here, but for long texts.
    """
    begin = process_time()
    for text in SCENES.values():
        parse(normalise(text, "good.tis"))
    return process_time() - begin


parsing_once = cache(parsing)


def answer(source: Source | str | bytes, overrides: Sequence[str] = ()) -> Sequence[Diagnostic]:
    """Compile a text; return what was said after checking that it can be shown."""
    begin = process_time()
    try:
        if not isinstance(source, Source):
            source = normalise(source, "fuzz.tis")
        _, said = check_request(Request(source, overrides=tuple(overrides)))
    except CompileError as error:
        said = error.diagnostics
        assert said
    spent = process_time() - begin
    assert spent < SOON * parsing_once() or spent < SOON * parsing()
    for diagnostic in said:
        assert re.fullmatch(r"(TIS|W)\d{3}", diagnostic.code)
        assert diagnostic.message
        for span in (diagnostic.span, *(note.span for note in diagnostic.notes)):
            assert span is None or is_inside(span)
        assert render(diagnostic, color=True)
        assert as_dict(diagnostic)["code"] == diagnostic.code
    return said


def is_inside(span: Span) -> bool:
    """Return whether a span lies within its text."""
    return 0 <= span.start <= span.end <= len(span.source.text) and span.line >= 1


@st.composite
def damaged(draw: st.DrawFn) -> Source:
    """Return a good scene with one to four tokens deleted, doubled, swapped or replaced."""
    path = GOOD[draw(st.integers(0, len(GOOD) - 1))]
    tokens = TOKEN.findall(SCENES[path.stem])
    for _ in range(draw(st.integers(1, 4))):
        place = draw(st.integers(0, len(tokens) - 1))
        match draw(st.sampled_from(("delete", "double", "swap", "number", "unit", "word"))):
            case "delete":
                tokens[place] = ""
            case "double":
                tokens.insert(place, tokens[place])
            case "swap":
                other = draw(st.integers(0, len(tokens) - 1))
                tokens[place], tokens[other] = tokens[other], tokens[place]
            case "number":
                numbers = [i for i, token in enumerate(tokens) if token[:1].isdigit()]
                tokens[numbers[place % len(numbers)]] = draw(st.sampled_from(NUMBERS))
            case "unit":
                units = [
                    i for i, token in enumerate(tokens) if token in ("mm", "m", "s", "ms", "N")
                ]
                tokens[(units or [place])[place % max(len(units), 1)]] = draw(
                    st.sampled_from(UNITS)
                )
            case "word":
                tokens[place] = draw(st.sampled_from(WORDS))
    return Source(path.name, "".join(tokens), path)


@many(1500)
@given(damaged())
def test_a_damaged_scene_is_answered(source: Source) -> None:
    answer(source)


@many(100)
@given(st.binary(max_size=200))
def test_bytes_are_answered(raw: bytes) -> None:
    answer(raw)


@many(100)
@given(st.text(max_size=100))
def test_text_behind_a_heading_is_answered(text: str) -> None:
    answer(f"language 1\n{text}")


VOCABULARY = (
    "param let set use about hedge property quantity rules tissue body tool environment script "
    "simulate output expect table nodes springs of where in at from to every when if then is = "
    "( ) [ ] { } , ; : \n 1 0 2 mm N s % x y z gum vessel mesh tube like with columns by using "
    "along not and or between within < > == + - * / ^ sqrt min force speed count fix move"
)


@many(150)
@given(st.lists(st.sampled_from(VOCABULARY.split(" ")), max_size=40))
def test_words_in_any_order_are_answered(words: list[str]) -> None:
    answer("language 1\n" + " ".join(words))


FRAME = """language 1
param lift = 3 mm between 0 mm and 9 mm
param side = (0, 1, 0)
tissue gum {{ spring constant = 40 N/m; viscosity = 0.01 N*s/m; mass = 10 mg }}
body vessel {{
  mesh is tube {{
    axis from (0, 0, 0) mm to (20, 0, 0) mm; radius = {radius}; rings = {rings}; sides = {sides}
  }}
  tissue is gum
}}
environment {{ gravity = (0, 0, 0) m/s^2 }}
simulate {{ duration = {duration} }}
{rest}
"""


def scene(
    radius: str = "lift",
    rings: str = "3",
    sides: str = "5",
    duration: str = "1 s",
    rest: str = "",
) -> str:
    """Return a small scene with some of its parts replaced."""
    return FRAME.format(radius=radius, rings=rings, sides=sides, duration=duration, rest=rest)


@many(60)
@given(
    st.text(max_size=30) | st.sampled_from(("lift", "lift = ", "= 3 mm", "lift = 3 mm; x = 1"))
)
def test_any_text_behind_set_is_answered(text: str) -> None:
    answer(scene(), [text])
    answer(scene(), [f"lift = {text}"])


@many(60)
@given(
    st.sampled_from(("lift", "side")),
    st.sampled_from(
        ("1e308 km", "0 mm", "-3 mm", "(1, 2, 3)", "3", "lift", "1 / 0", "(-8)^0.5 * 1 mm")
    ),
)
def test_overrides_of_any_kind_are_answered(name: str, value: str) -> None:
    answer(scene(rest="expect speed(vessel along side) < 1 m/s at 1 s"), [f"{name} = {value}"])


@pytest.mark.parametrize(
    "rings", ["1e9", "100000000", "1e308", "-1", "0", "2.5", "2^40", "1e8"]
)
@pytest.mark.parametrize("sides", ["5", "1e9", "100000000"])
def test_absurd_counts_are_refused_before_anything_is_built(rings: str, sides: str) -> None:
    assert answer(scene(rings=rings, sides=sides))


ABSURD_LATTICES = [
    ("1 nm", "(1, 1, 1) m"),
    ("1e-308 m", "(1e308, 1, 1) m"),
    ("1e308 m", "(1, 1, 1) m"),
    ("1e-300 m", "(1e-300, 1e300, 1) m"),
    ("1 mm", "(0, 0, 0) m"),
]


@pytest.mark.parametrize(("cell", "box"), ABSURD_LATTICES)
def test_absurd_lattices_are_refused(cell: str, box: str) -> None:
    body = (
        f"body block {{ mesh is lattice {{ kind is diamond; cell = {cell}; "
        f"box from (0, 0, 0) m to {box} }}; tissue is gum }}"
    )
    assert answer(scene(rest=body))


REPEATING = [
    "from 0 s to 1 s every 1e-300 s: push vessel with (0, 0, 1) N",
    "from 0 s to 1 s every 0 s: push vessel with (0, 0, 1) N",
    "from 0 s to 1 s every 1 ms: { from 0 s to 1 ms every 1 us: push vessel with (0, 0, 1) N }",
    "from 0 s to 1 s every 20 us: fasten vessel",
    "from 0 s to 1e99 s every 1e-99 s: fix vessel",
]

#: As many repetitions as are allowed, of what takes most work to check.
BUSY = [
    "from 0 s to 1 s every 20 us: hold vessel",
    "from 0 s to 1 s every 20 us: { from 0 s to 5 us: move vessel by (0, 0, 1) mm using ramp }",
    "from 0 s to 1 s every 20 us: { from 0 s to 1 s: turn vessel by 1 around side using ramp }",
    "from 0 s to 1 s every 20 us: release vessel",
    "from 0 s to 1 s every 20 us: push vessel with 1 N along side",
    "from 0 s to 2 s every 20 us: cut vessel along plane through side * 1 m facing side",
]


@pytest.mark.parametrize("order", REPEATING)
def test_absurd_repetitions_are_refused(order: str) -> None:
    assert answer(scene(rest=f"script {{ {order} }}"))


@pytest.mark.parametrize(
    "order",
    # "hold" is checked as "release" is, and "turn" as "move" is.
    [
        pytest.param(
            order, marks=pytest.mark.slow if "hold" in order or "turn" in order else ()
        )
        for order in BUSY
    ],
)
def test_busy_scripts_are_answered(order: str) -> None:
    answer(scene(rest=f"script {{ {order} }}"))


@pytest.mark.parametrize("every", ["1e-300 s", "0 s", "-1 s", "1e308 s", "1 mm"])
def test_absurd_rates_are_answered(every: str) -> None:
    answer(scene(rest=f"output {{ trajectory every {every}; force of vessel every {every} }}"))


DEEP = 20_000
DEPTHS = [40, DEEP // 4, pytest.param(DEEP, marks=pytest.mark.slow)]
NESTED = {
    "round": ("(", "1 mm", ")"),
    "square": ("[", "1 mm", "]"),
    "signs": ("-", "1 mm", ""),
    "sums": ("1 mm + ", "1 mm", ""),
    "powers": ("2^(", "2", ")"),
    "calls": ("sqrt(", "2", ")"),
    "tests": ("not ", "x", ""),
}


@pytest.mark.parametrize("kind", NESTED)
@pytest.mark.parametrize("count", DEPTHS)
def test_deep_expressions_are_answered(kind: str, count: int) -> None:
    opening, inner, closing = NESTED[kind]
    text = opening * count + inner + closing * count
    answer(scene(rest=f"let deep = {text}"))
    answer(scene(rest=f"set deep = nodes of vessel where {text} < x"))


@pytest.mark.parametrize("count", DEPTHS)
def test_deep_blocks_are_answered(count: int) -> None:
    answer(scene(rest="script " + "{ at 0 s: " * count + "fix vessel" + "}" * count))
    answer(scene(rest="from 0 s to 1 s: { " * count + "}" * count))


@pytest.mark.parametrize("count", [60, 500, pytest.param(2000, marks=pytest.mark.slow)])
def test_long_chains_of_definitions_are_answered(count: int) -> None:
    lets = [f"let a{'b' * (i % 7)}{chr(97 + i % 26)} = {i}" for i in range(count)]
    answer(scene(rest="\n".join(lets)))
    names = ["v" + "".join(chr(97 + int(digit)) for digit in str(i)) for i in range(count)]
    chain = [f"let {name} = 1 + {after}" for name, after in pairwise(names)]
    answer(scene(rest="\n".join([*chain, f"let {names[-1]} = 1"])))
    tissues = [f"tissue {a} like {b} {{ }}" for a, b in pairwise(names)]
    answer(scene(rest="\n".join([*tissues, f"tissue {names[-1]} like gum {{ }}"])))
    sets = [f"set {a} = [{b}]" for a, b in pairwise(names)]
    answer(scene(rest="\n".join([*sets, f"set {names[-1]} = [vessel]"])))


CELLS = st.sampled_from(
    (
        "1",
        "2",
        "3",
        "-",
        "0",
        "-1",
        "1e308",
        "1e400",
        "nan",
        "inf",
        "1e20",
        "x",
        '"1"',
        "1,5",
        "1_0",
        "²",
    )
)
SEPARATORS = st.sampled_from((" ", " ", " ", "\n", "\n", ";", "\t", "  ", " # ", ""))
NET = """language 1
tissue gum {{ spring constant = 40 N/m; viscosity = 0.01 N*s/m; mass = 10 mg }}
body net {{ mesh is explicit; tissue is gum }}
environment {{ gravity = (0, 0, 0) m/s^2 }}
simulate {{ duration = 1 s }}
table nodes of net in {unit} with columns "{nodes}" {{ {rows} }}
table springs of net with columns "{springs}" {{ {ends} }}
"""


@many(150)
@given(
    st.sampled_from(("mm", "km", "N", "mm^9", "x")),
    st.sampled_from(
        ("id x y z", "x", "id x mass in Mg", "x x", "", "id", "x in", "x in in", "y")
    ),
    st.sampled_from(
        ("a b", "id a b", "a b rest length in km", "a", "b a spring constant", "a b a")
    ),
    st.lists(st.tuples(CELLS, SEPARATORS), max_size=24),
    st.lists(st.tuples(CELLS, SEPARATORS), max_size=12),
)
def test_hostile_tables_are_answered(
    unit: str,
    nodes: str,
    springs: str,
    rows: list[tuple[str, str]],
    ends: list[tuple[str, str]],
) -> None:
    text = NET.format(
        unit=unit,
        nodes=nodes,
        springs=springs,
        rows="".join(map("".join, rows)),
        ends="".join(map("".join, ends)),
    )
    answer(text)


PATHS = [
    "time,x,y,z\n",
    "0,0,0,0",
    "0,0,0,0\n1e-308,1e308,0,0\n1,-1e308,0,0",
    "0,0,0,0\n0,1,1,1",
    "-1,0,0,0\n1,1,1,1",
    "0,nan,0,0\n1,0,0,inf",
    'a,"b\nc',
    "0;0;0\n1;1;1",
    "\n\n\n",
    "x" * 300_000,
    "0,1,2,3\n1,0,0,0",
]


@pytest.mark.parametrize("content", PATHS, ids=range(len(PATHS)))
def test_hostile_paths_are_answered(content: str, tmp_path: Path) -> None:
    (tmp_path / "path.csv").write_text(content, encoding="utf-8")
    order = 'from 0 s to 1 s: move vessel along table "path.csv" in km'
    text = scene(rest=f"script {{ {order} }}")
    assert answer(Source("scene.tis", text, tmp_path / "scene.tis"))


@pytest.mark.parametrize(
    "used", ["a", "b", "./a", "./scene", "", "..", "/etc/passwd", "a" * 5000, "./.", "~"]
)
def test_hostile_imports_are_answered(used: str, tmp_path: Path) -> None:
    (tmp_path / "library").mkdir()
    for folder in (tmp_path, tmp_path / "library"):
        (folder / "a.tis").write_text('language 1\nuse "b"\nuse "./b"\n', encoding="utf-8")
        (folder / "b.tis").write_text('language 1\nuse "a"\nuse "./a"\n', encoding="utf-8")
    path = tmp_path / "scene.tis"
    path.write_text(f'language 1\nuse "{used}"\n', encoding="utf-8")
    assert answer(Source("scene.tis", scene(rest=f'use "{used}"'), path))


def test_long_chains_of_imports_are_answered(tmp_path: Path) -> None:
    for i in range(300):
        text = f'language 1\nuse "./f{i + 1}"\n'
        (tmp_path / f"f{i}.tis").write_text(text, encoding="utf-8")
    said = answer(Source("f.tis", scene(rest='use "./f0"'), tmp_path / "f.tis"))
    assert [diagnostic.code for diagnostic in said] == ["TIS116"]


@pytest.mark.parametrize("rings", ["100000000", "1e9"])
def test_what_is_absurd_is_refused_before_it_takes_memory(rings: str) -> None:
    answer(scene())  # what is loaded once does not count
    tracemalloc.start()
    try:
        answer(scene(rings=rings, sides="100000000"))
        assert tracemalloc.get_traced_memory()[1] < 10_000_000  # bytes; the net would take 1e18
    finally:
        tracemalloc.stop()
