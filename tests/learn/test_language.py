"""What a learn block says is what a fit problem asks for."""

from math import inf
from pathlib import Path

import numpy as np
import pytest

from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.core.units import FORCE, LENGTH, NUMBER, STIFFNESS, VELOCITY
from tissuec.lang.printer import format_source
from tissuec.learn.parameters.parametrisation import Parametrisation
from tissuec.pipeline import compile_request
from tissuec.scene.learning.sentences import SENTENCES
from tissuec.scene.program.imports import StoredTexts, read_source
from tissuec.scene.request import Request
from tissuec.script.measures import MEASURES

SCENE = """language 1
use "fuzzy/soft_tissue"
param depth = 3 mm between 0 mm and 8 mm
param bend = 4 kN/m^3 between 1 kN/m^3 and 9 kN/m^3
tissue fat {
  described in soft tissue
  hardness is soft; elasticity is medium; weight is low; shiftability is high
  consistency is smooth
}
tissue gum {
  spring constant = 40 N/m; viscosity = 10 mN*s/m; mass = 10 mg; prestress = 1 %
  relaxing constant = 5 N/m; relaxation time = 0.1 s
  yield force = 1 N; yield viscosity = 9 N*s/m
  spring law is exponential { stiffening = 3 }
  viscosity law is power { exponent = 0.5; speed = 1 mm/s }
}
tissue scarred like gum { spring force of e = c * e + bend * e^3 }
body liver {
  mesh is tube {
    axis from (0, 0, 0) mm to (20, 0, 0) mm; radius = 3 mm; rings = 5; sides = 10
    diagonals is both; interior is crossed
  }
  tissue is gum
  region scar where x > 12 mm { tissue is scarred }
  interface is softer
}
body cart { mesh is explicit; tissue is fat }
table nodes of cart in mm with columns "id x" { 7 0; 9 11; 11 13 }
table springs of cart with columns "a b" { 7 9; 9 11 }
body gum { mesh is explicit; tissue is gum }
table nodes of gum in mm with columns "id x" { 1 50; 2 60 }
table springs of gum with columns "a b" { 1 2 }
set pressed = nodes of liver where x < 1 mm
set front = nodes of cart in [11]
tool forceps A { kind is forceps }
force bed { kind is foundation; acts on liver; stiffness = 10 kPa/m }
environment { gravity = (0, 0, 0) m/s^2 }
script { from 0 s to 0.5 s: move pressed by (-depth, 0 mm, 0 mm) using smooth profile }
simulate { duration = 0.5 s }
"""
DATA = 'data = ["bench_01.csv", "bench_02.csv"]'
FIT = 'fit = force(pressed) using column "force_N" in N'
ADJUST = "adjust = [spring constant, viscosity]"
WHOLE = """learn fat {
  data = ["bench_01.csv", "bench_02.csv"]
  data "bench_03.csv" { depth = 2 mm }
  time using column "t_s" in s
  fit = force(pressed) using column "force_N" in N every 10 ms to 2 mN weighing 0.5
  fit = force(front)
  against column "force_N" in N every 10 ms
  fit = position(cart) along (1, 0, 0) using column "x_px" in mm with free zero
  fit = positions(liver) using columns "node x y z" in mm
  adjust = [spring constant, viscosity]
  adjust spring constant of gum from 1 N/m to 1 kN/m around 20 N/m by 30 %
  adjust stiffening of gum
  adjust bend of scarred
  adjust viscosity of liver per region
  adjust spring constant of cart per spring
  adjust mass of cart per node
  adjust rest length of cart per spring; adjust prestress of scarred
  adjust start position of cart along (1, 0, 0)
  adjust start velocity of cart
  adjust words of hardness
  revise rules of soft tissue
  hold out "bench_03.csv"
  hold out = 20 %
  passes = 200; seed = 7; tolerance = 1e-9
  step = 50 us; integrator is velocity verlet
  method is least squares
  error is absolute
  write "learned/fat.tis"
}
expect error(held out) < 8 % over run
"""
#: Without what the tissue has as well.
GOOD = WHOLE.replace("  adjust spring constant of cart per spring\n", "")


@pytest.fixture
def compiled(tmp_path):
    """Return a function that compiles the scene with more text behind it, beside its data."""
    for name in ("bench_01.csv", "bench_02.csv", "bench_03.csv", "run.h5", "old.VTKHDF"):
        (tmp_path / name).write_text("t_s,force_N\n0,0\n", encoding="utf-8")

    def compile_(text):
        path = tmp_path / "scene.tis"
        path.write_text(SCENE + text, encoding="utf-8")
        return compile_request(Request(read_source(path, "scene.tis")))[0]

    return compile_


@pytest.fixture
def fit_problem(compiled):
    """Return a function that reads one learn block of some entries."""

    def read(*entries, name="fat", data=DATA, fit=FIT, adjust=ADJUST, expects=""):
        body = "\n".join([data, fit, adjust, *entries])
        (found,) = compiled(f"learn {name} {{\n{body}\n}}\n{expects}").fit_problems
        return found

    return read


def refused(read, *args, **entries):
    """Return the codes of what is wrong."""
    with pytest.raises(CompileError) as error:
        read(*args, **entries)
    return [one.code for one in error.value.diagnostics if one.severity == "error"]


# --- as a whole -------------------------------------------------------------------------------


def test_the_whole_of_the_language_is_read(compiled, tmp_path):
    (fit_problem,) = compiled(GOOD).fit_problems
    assert fit_problem.name == "fat"
    assert [data.path.name for data in fit_problem.data] == [
        f"bench_0{n}.csv" for n in (1, 2, 3)
    ]
    assert [data.held_out for data in fit_problem.data] == [False, False, True]
    assert fit_problem.data[2].overrides == ("depth = 2 mm",)
    assert len(fit_problem.fits) == 4
    assert [(a.what, a.of, a.per) for a in fit_problem.adjusts] == [
        ("spring constant", "fat", "tissue"), ("viscosity", "fat", "tissue"),
        ("spring constant", "gum", "tissue"), ("stiffening", "gum", "tissue"),
        ("bend", "scarred", "tissue"), ("viscosity", "liver", "region"),
        ("mass", "cart", "node"), ("rest length", "cart", "spring"),
        ("prestress", "scarred", "tissue"),
        ("start position", "cart", "set"), ("start velocity", "cart", "set"),
        ("words", "hardness", "word"),
    ]  # fmt: skip
    assert fit_problem.revise == ("soft tissue",)
    assert (fit_problem.last_part, fit_problem.passes, fit_problem.seed) == (0.2, 200, 7)
    assert (fit_problem.tolerance, fit_problem.step) == (1e-9, pytest.approx(5e-5, rel=1e-15))
    assert (fit_problem.integrator, fit_problem.method) == ("velocity verlet", "least squares")
    assert not fit_problem.scaled
    assert fit_problem.write == tmp_path / "learned" / "fat.tis"
    assert len(fit_problem.demands) == 1


def test_what_belongs_to_one_thing_is_not_adjusted_by_two_lines(compiled):
    assert refused(compiled, WHOLE) == ["TIS804"]  # spring constants of fat and of the cart


def test_a_learn_block_keeps_its_layout():
    source = Source("whole", "language 1\n" + WHOLE)
    assert format_source(source) == source.text


def test_what_is_not_written_has_a_meaning(fit_problem):
    found = fit_problem()
    assert found.axis.nodes is None
    assert found.axis.column is None
    assert (found.last_part, found.revise, found.demands, found.write) == (0.0, (), (), None)
    assert (found.step, found.integrator, found.method) == (None, "automatic", "automatic")
    assert found.scaled
    assert not any(data.held_out or data.overrides for data in found.data)


def test_a_run_leaves_learning_aside(compiled):
    without, learning = compiled(""), compiled(GOOD)
    assert without.fit_problems == ()
    assert not learning.plan.expectations
    assert np.array_equal(without.network.springs.stiffness, learning.network.springs.stiffness)


def test_several_blocks_are_lessons_of_their_own(compiled):
    one, two = (
        f"learn {name} {{ data = {data}; {FIT}; adjust spring constant of gum; {more} }}\n"
        for name, data, more in (
            ("fat", '"bench_01.csv"', "hold out = 10 %"), ("gum", '"bench_02.csv"', ""),
        )
    )  # fmt: skip
    expects = (
        'expect error(data) < 8 %\nexpect error("bench_02.csv") < 8 %\n'
        "expect error(held out) < 8 %\n"
    )
    first, second = compiled(one + two + expects).fit_problems
    assert [len(found.demands) for found in (first, second)] == [2, 2]


# --- data -------------------------------------------------------------------------------------


def test_files_lie_beside_the_text_that_names_them(compiled, tmp_path):
    folder = tmp_path / "further"
    folder.mkdir()
    for name in ("deep.csv", "part.tis"):
        (folder / name).touch()
    (tmp_path / "scene.tis").write_text(SCENE, encoding="utf-8")
    path = tmp_path / "lesson.tis"
    block = (
        f'learn gum {{ data = "further/deep.csv"; {FIT}; adjust mass; write "further/a.tis" }}'
    )
    path.write_text(f'language 1\nuse "./scene"\n{block}\n', encoding="utf-8")
    (found,) = compile_request(Request(read_source(path, "lesson.tis")))[0].fit_problems
    assert found.data[0].path == folder / "deep.csv"
    assert found.write == folder / "a.tis"


def test_a_text_that_a_result_keeps_needs_no_data(tmp_path):
    block = f'learn gum {{ data = "gone.csv"; {FIT}; adjust mass }}\n'
    library = Path(__file__).parents[2] / "library"
    names = ("fuzzy/words.tis", "fuzzy/soft_tissue.tis")
    kept = StoredTexts({name: (library / name).read_text(encoding="utf-8") for name in names})
    request = Request(Source("scene.tis", SCENE + block), files=kept)
    assert compile_request(request)[0].fit_problems[0].data[0].path == Path("gone.csv")


def test_what_was_different_can_be_set(fit_problem, compiled, tmp_path):
    found = fit_problem('data "bench_03.csv" { depth = depth_2 * 1.5; bend = 5 kN/m^3 }',
                   expects="param depth_2 = 1 mm")  # fmt: skip
    overrides = found.data[-1].overrides
    assert overrides == ("depth = depth_2 * 1.5", "bend = 5 kN/m^3")
    source = read_source(tmp_path / "scene.tis", "scene.tis")
    again, _ = compile_request(Request(source, overrides=overrides))
    depth = again.scene.constants.definitions.values["depth"]
    assert float(depth.amount) == pytest.approx(1.5e-3, rel=1e-15)  # one product


def test_results_need_no_columns(fit_problem):
    fit = "fit = positions(liver)\nfit = force(pressed)"
    found = fit_problem(data='data = ["run.h5", "old.VTKHDF"]', fit=fit)
    assert [one.columns for one in found.fits] == [(), ()]
    mixed = 'data = ["run.h5", "bench_01.csv"]'
    assert refused(fit_problem, data=mixed, fit=fit) == ["TIS802", "TIS802"]


def test_data_of_one_name_are_refused(fit_problem, tmp_path):
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "bench_01.csv").touch()
    assert refused(fit_problem, 'data "b/bench_01.csv"') == ["TIS307"]


def test_a_displacement_takes_the_place_of_the_time(fit_problem, compiled):
    found = fit_problem('displacement of pressed using column "u_um" in um')
    assert found.axis.column.unit == pytest.approx(1e-6, rel=1e-15)
    assert np.array_equal(found.axis.nodes, compiled("").nodes_of("pressed"))


# --- fits -------------------------------------------------------------------------------------


def fit_of(fit_problem, text):
    (found,) = fit_problem(fit=f"fit = {text}").fits
    return found


def test_a_fit_is_a_measure_with_columns(fit_problem, compiled):
    found = fit_of(
        fit_problem, 'force(pressed) using column "f" in mN every 10 ms to 2 mN weighing 0.5'
    )
    assert (found.text, found.measure, found.along) == (
        "force(pressed)",
        MEASURES["force"],
        None,
    )
    assert [(one.name, one.unit) for one in found.columns] == [("f", 1e-3)]
    assert (found.every, found.noise, found.weight) == (0.01, 0.002, 0.5)
    assert (found.dimension, found.free_zero) == (FORCE, False)
    assert np.array_equal(found.subjects[0].nodes, compiled("").nodes_of("pressed"))


def test_a_column_stands_behind_a_fit_or_below_it(fit_problem):
    behind = fit_of(fit_problem, 'force(pressed) using column "f" in mN every 10 ms weighing 2')
    below = fit_of(
        fit_problem, 'force(pressed)\nagainst column "f" in mN every 10 ms weighing 2'
    )
    for name in ("text", "measure", "every", "weight", "dimension"):
        assert getattr(below, name) == getattr(behind, name)
    assert [(c.name, c.unit) for c in below.columns] == [
        (c.name, c.unit) for c in behind.columns
    ]


@pytest.mark.parametrize(
    "text", ["position(cart) along (3, 0, 4)", "position(cart along (3, 0, 4))"]
)
def test_a_direction_stands_in_brackets_or_behind_them(fit_problem, text):
    found = fit_of(fit_problem, f'{text} using column "x" in mm with free zero')
    assert found.text == text
    assert found.free_zero
    assert found.along == pytest.approx([0.6, 0.0, 0.8], rel=1e-15)  # of length 1


def test_positions_are_those_of_every_node(fit_problem, compiled):
    found = fit_of(fit_problem, 'positions(cart) using columns "node x y z" in mm')
    assert (found.measure, found.dimension) == (None, LENGTH)
    assert np.array_equal(found.subjects[0].nodes, compiled("").nodes_of("cart"))
    units = [(one.name, one.unit) for one in found.columns]
    assert units == [("node", 1.0), ("x", 1e-3), ("y", 1e-3), ("z", 1e-3)]
    assert len(fit_of(fit_problem, 'positions(front) using columns "x y z" in m').columns) == 3


def test_forces_are_in_one_column_or_three(fit_problem):
    for columns, count in (('column "f"', 1), ('columns "fx fy fz"', 3)):
        found = fit_of(fit_problem, f"force(forceps A) using {columns} in N")
        assert len(found.columns) == count
        assert found.subjects[0].nodes is None


def test_plain_numbers_need_no_unit(fit_problem):
    (bare,) = fit_of(fit_problem, 'strain(liver) using column "e"').columns
    (percent,) = fit_of(fit_problem, 'strain(liver) using column "e" in 1 %').columns
    (alone,) = fit_of(fit_problem, 'strain(liver) using column "e" in %').columns
    assert (bare.unit, percent.unit, alone.unit) == (1.0, 0.01, 0.01)


@pytest.mark.parametrize(
    ("unit", "hint"),
    [
        ("mm/1.03", "in 0.970874 mm"),
        ("mm * 2.5", "in 2.5 mm"),
        ("mm/0", "in 0.97 m"),
        ("lenghts", "in 0.97 m"),
    ],
)
def test_a_factor_stands_before_the_unit_of_a_column(fit_problem, unit, hint):
    line = 'fit = position(cart) along (1, 0, 0) using column "x" in'
    with pytest.raises(CompileError) as caught:
        fit_problem(f"{line} {unit}")
    (finding,) = [one for one in caught.value.diagnostics if one.code == "TIS104"]
    assert str(finding.hint).endswith(hint)
    (column,) = fit_problem(f"{line} 0.97 mm").fits[-1].columns
    assert (column.unit, column.factor) == (pytest.approx(0.97e-3, rel=1e-15), 0.97)


@pytest.mark.parametrize(
    "own",
    [
        "{ zero = 1 mN }",
        "{ fit = force(pressed) }",
        "{ adjust mass }",
        "with free zero",
    ],
)
def test_files_with_zeros_or_fits_of_their_own_are_sent_to_blocks(fit_problem, own):
    with pytest.raises(CompileError) as caught:
        fit_problem(f'data "bench_03.csv" {own}')
    (finding,) = [one for one in caught.value.diagnostics if one.severity == "error"]
    assert finding.code == "TIS303"
    assert "use a learn block for each machine or specimen" in str(finding.hint)


def test_a_param_may_be_called_as_entries_are(compiled):
    learn = f'learn fat {{ data "bench_03.csv" {{ zero = 2 mm }}; {FIT}; {ADJUST} }}'
    (found,) = compiled(f"param zero = 1 mm\n{learn}\n").fit_problems
    assert found.data[0].overrides == ("zero = 2 mm",)


# --- what may change --------------------------------------------------------------------------


def adjust_of(fit_problem, text):
    (found,) = fit_problem(adjust=f"adjust {text}").adjusts
    return found


def test_limits_and_what_was_expected_are_in_si_units(fit_problem):
    found = adjust_of(
        fit_problem, "spring constant of fat from 1 N/m to 1 kN/m around 20 N/m by 30 %"
    )
    assert (found.low, found.high, found.prior) == (1.0, 1000.0, (20.0, 0.3))
    assert (found.dimension, found.per, len(found.members)) == (STIFFNESS, "tissue", 0)


@pytest.mark.parametrize("around", ["initial value", "4 mm"])
def test_each_spring_may_be_expected_where_it_starts(compiled, fit_problem, around):
    text = f"adjust rest length of cart per spring around {around} by 50 %"
    priors = Parametrisation(compiled(""), fit_problem(adjust=text)).priors()
    # Springs of 11 and 2 mm; parameters are logarithms over their starts.
    values = [0.0, 0.0] if around == "initial value" else np.log([4 / 11, 4 / 2]).tolist()
    assert [one.place for one in priors] == [0, 1]
    assert [one.value for one in priors] == pytest.approx(values, rel=1e-12, abs=0.0)
    assert [one.spread for one in priors] == pytest.approx([np.log(1.5)] * 2, rel=1e-12)


@pytest.mark.parametrize(
    "text", ["spring constant of gum", "start position of cart along (1, 0, 0)"]
)
def test_a_single_number_and_a_place_have_no_initial_value(fit_problem, text):
    adjust = f"adjust {text} around initial value by 50 %"
    assert refused(fit_problem, adjust=adjust) == ["TIS312"]


@pytest.mark.parametrize(
    ("what", "low", "high"),
    [
        ("viscosity of gum", 0.0, inf), ("prestress of gum", -10.0, 0.99),
        ("exponent of gum", 0.1, 10.0), ("speed of gum", 0.0, inf),
        ("stiffening of gum", -inf, inf), ("bend of scarred", 1e3, 9e3),
        ("yield force of gum", 0.0, inf), ("relaxation time of gum", 0.0, inf),
        ("rest length of cart", 0.0, inf), ("start position of cart", -inf, inf),
        ("words of spring constant", -inf, inf), ("mass to 3 mg", 0.0, 3e-6),
    ],
)  # fmt: skip
def test_numbers_have_the_limits_of_what_they_are(fit_problem, what, low, high):
    found = adjust_of(fit_problem, what)
    assert (found.low, found.high) == pytest.approx((low, high), rel=1e-15)
    assert found.prior is None


@pytest.mark.parametrize(
    ("text", "of", "per", "members"),
    [
        ("spring constant of cart per spring", "cart", "spring", "springs of cart"),
        ("spring constant of liver per region", "liver", "region", "springs of liver"),
        ("viscosity of liver", "liver", "set", "springs of liver"),
        ("viscosity of scar of liver per spring", "scar of liver", "spring", "scar"),
        ('viscosity of "scar of liver"', "scar of liver", "set", "scar"),
        ("viscosity of scar", "scar of liver", "set", "scar"),
        ("mass of cart per node", "cart", "node", "nodes of cart"),
        ("mass of front", "front", "set", "nodes of front"),
        ("rest length of pressed per spring", "pressed", "spring", "springs of pressed"),
        ("start velocity of cart per node", "cart", "node", "nodes of cart"),
        ("spring constant of gum per spring", "gum", "spring", "springs of gum"),
        ("spring constant of gum", "gum", "tissue", ""),  # the tissue, not the body
        ("rest length of gum", "gum", "set", "springs of gum"),  # the body
    ],
)  # fmt: skip
def test_nodes_and_springs_are_those_that_are_named(
    fit_problem, compiled, text, of, per, members
):
    found, scene = adjust_of(fit_problem, text), compiled("")
    assert (found.of, found.per) == (of, per)
    match members.split(" of "):
        case ["springs", name]:
            expected = scene.springs_of(name)
        case ["nodes", name]:
            expected = scene.nodes_of(name)
        case ["scar"]:
            inside = np.isin(scene.network.springs.ends, scene.nodes_of("scar of liver")).all(
                axis=1
            )
            expected = np.flatnonzero(inside)
        case _:
            expected = []
    assert np.array_equal(found.members, expected)


def test_a_start_may_have_a_direction(fit_problem):
    found = adjust_of(
        fit_problem, "start velocity of cart along (0, 2, 0) from -1 m/s to 1 m/s"
    )
    assert np.array_equal(found.along, [0.0, 1.0, 0.0])
    assert (found.dimension, found.low, found.high) == (VELOCITY, -1.0, 1.0)
    assert adjust_of(fit_problem, "start position of cart").along is None


def test_rules_may_be_revised_without_anything_adjusted(fit_problem):
    found = fit_problem(adjust="revise rules of soft tissue")
    assert (found.adjusts, found.revise) == ((), ("soft tissue",))


@pytest.mark.parametrize(
    ("lines", "code"),
    [
        ("adjust mass\nadjust mass of fat", "TIS307"),
        ("adjust rest length of gum\nadjust prestress of gum", "TIS804"),
        ("adjust viscosity of liver\nadjust viscosity of scar", "TIS804"),
        ("adjust viscosity of gum\nadjust viscosity of liver per region", "TIS804"),
        ("adjust mass of front\nadjust mass of cart per node", "TIS804"),
        ("adjust spring constant\nadjust words of spring constant", "TIS804"),
        ("adjust start position of cart\nadjust start position of front", "TIS804"),
    ],
)
def test_nothing_is_adjusted_twice(fit_problem, lines, code):
    assert refused(fit_problem, adjust=lines) == [code]


@pytest.mark.parametrize(
    "lines",
    [
        "adjust viscosity of gum\nadjust viscosity of cart",
        "adjust viscosity of gum\nadjust viscosity of scarred",
        "adjust spring constant of gum\nadjust words of spring constant",  # it is written
        "adjust start position of cart along (1, 0, 0)\n"
        "adjust start position of cart along (0, 1, 0)",
    ],
)
def test_different_things_are_adjusted_together(fit_problem, lines):
    assert len(fit_problem(adjust=lines).adjusts) == 2


# --- expectations -----------------------------------------------------------------------------


def test_an_expectation_is_judged_by_errors(fit_problem):
    expects = (
        'expect error(held out) < 8 % over run\nexpect error("bench_01.csv") < error(data)'
    )
    first, second = fit_problem("hold out = 20 %", expects=expects).demands
    errors = {"held out": 0.031, "data": 0.02, "bench_01.csv": 0.01}
    assert first.holds(errors)
    assert first.describe(errors) == "error(held out) = 3.1 %"
    assert not first.holds(errors | {"held out": 0.09})
    assert second.holds(errors)
    assert not second.holds(errors | {"bench_01.csv": 0.03})
    assert second.describe(errors) == 'error("bench_01.csv") = 1 %, error(data) = 2 %'


def test_errors_can_be_joined_and_compared_with_numbers_of_the_scene(fit_problem):
    expects = "param bound = 5 %\nexpect error(data) between 0 and bound or error(data) == 1"
    (demand,) = fit_problem(expects=expects).demands
    assert [demand.holds({"data": error}) for error in (0.05, 0.06, 1.0)] == [True, False, True]


# --- mistakes ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("right", "wrong", "code"),
    [
        ("learn fat", "lear fat", "TIS303"),  # expectations of learning follow from it
        ("body liver", "bdy liver", "TIS303"),
        ("set pressed = nodes", "set pressed = nods", "TIS312"),
        ("tissue gum {", "tissue gum { mas = 3 mg; ", "TIS303"),
        ("springs of cart", "springs of crt", "TIS301"),
        ("x > 12 mm", "x > 12 s", "TIS502"),
        ("param depth = 3 mm", "param depth = 3 s + 3 mm", "TIS502"),
        ('use "fuzzy/soft_tissue"', 'use "fuzzy/soft_tisue"', "TIS601"),
        ("duration = 0.5 s", "duration = 0.5 mm", "TIS502"),
        ("fit = force(front)", "let fit = force(front)", "TIS303"),
        ('column "t_s"', 'columns " "', "TIS312"),
        ("{ depth = 2 mm }", "{ param depth = 2 mm }", "TIS303"),
    ],
)
def test_what_only_follows_from_a_mistake_is_not_told(compiled, tmp_path, right, wrong, code):
    compiled("")  # puts the data there
    path, text = tmp_path / "scene.tis", SCENE + GOOD
    assert right in text
    path.write_text(text.replace(right, wrong, 1), encoding="utf-8")
    with pytest.raises(CompileError) as error:
        compile_request(Request(read_source(path, "scene.tis")))
    errors = [one for one in error.value.diagnostics if one.severity == "error"]
    assert [one.code for one in errors] == [code]


# --- the table of entries ---------------------------------------------------------------------


#: Forms of blocks that fit words to numbers of tissues.
OF_TISSUES = (
    "fit = QUANTITY of TISSUE weighing 2", "fit = QUANTITY of all tissues",
    "adjust weights of RULES", "hold out TISSUE", "hold out = [TISSUE]",
)  # fmt: skip
FORMS = [(name, form) for name, one in SENTENCES.items() for form in one.texts(name)]


@pytest.mark.parametrize("form", OF_TISSUES)
def test_every_form_of_fits_to_numbers_of_tissues_can_be_written(compiled, form):
    assert form in [one for _, one in FORMS]
    text = form.replace("QUANTITY", "viscosity").replace("TISSUE", "told")
    text = text.replace("RULES", "soft tissue")
    told = "".join(
        f"tissue {name} like fat {{ viscosity = 9 mN*s/m }}\n" for name in ("told", "said")
    )
    fit = "" if text.startswith("fit") else "fit = viscosity of [told, said]"
    scene = compiled(f"{told}learn fat {{\n{fit}\n{text}\nadjust words of viscosity\n}}\n")
    assert scene.fit_problems == ()
    (found,) = scene.vocabulary_fits
    assert {one.tissue for one in found.targets} <= {"told", "said"}
    assert found.scales == ("viscosity",)


@pytest.mark.parametrize(
    ("entry", "form"), [(name, form) for name, form in FORMS if form not in OF_TISSUES]
)
def test_every_form_of_the_table_can_be_written(fit_problem, entry, form, tmp_path):
    for name in ("one.csv", "two.csv", "three.csv", "table.csv"):
        (tmp_path / name).touch()
    text = form.replace("NAME", "depth").replace("SET", "cart").replace("TISSUE", "fat")
    text = text.replace("FORCE", "bed")
    text = text.replace("QUANTITY", "viscosity").replace("RULES", "soft tissue")
    given = {entry: text} if entry in ("data", "fit", "adjust") else {}
    more = [] if given else [text]
    if entry == "against column":
        given, more = {"fit": f"fit = force(pressed)\n{text}"}, []
    if "csv" in text and entry == "hold out":
        given = {"data": 'data = ["one.csv", "two.csv", "three.csv", "table.csv"]'}
    assert fit_problem(*more, **given).adjusts


def test_dimensions_of_words_are_those_of_their_scales(fit_problem):
    assert adjust_of(fit_problem, "words of hardness").dimension == NUMBER
    assert adjust_of(fit_problem, "words of spring constant").dimension == STIFFNESS
