"""Which measure has a meaning for which body: what is declared is what is reported."""

import numpy as np
import pytest

from tests.validate.scenes import compiled_scene
from tests.whole_runs import carried_out
from tissuec.compiler.measures.statistics import FieldStatistic
from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.pipeline import compile_request
from tissuec.results.fields import FIELDS
from tissuec.scene.request import Request
from tissuec.script.measures import MEASURES
from tissuec.script.measures.needs import BODIES, KINDS, NEEDS, STRAINED, WHOLE, meaning

SCENE = """language 1
tissue gel { Young's modulus = 5 kPa; density = 1000 kg/m^3; retardation time = 2 ms }
tissue cord { spring constant = 40 N/m; viscosity = 10 mN*s/m; mass = 50 mg }
body solid {
  mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (10, 5, 5) mm }; tissue is gel
  velocity = (1, 0, 0) m/s; spin = (0, 30, 0) Hz
}
body wall {
  mesh is sphere { centre = (0, 0, 30) mm; radius = 5 mm; subdivisions = 1 }
  tissue is gel; thickness = 1 mm; velocity = (1, 0, 0) m/s; spin = (0, 30, 0) Hz
}
body net {
  mesh is sphere { centre = (0, 0, 60) mm; radius = 5 mm; subdivisions = 1 }; tissue is cord
  velocity = (1, 0, 0) m/s; spin = (0, 30, 0) Hz
}
body thread {
  mesh is thread { line from (0, 0, 90) mm to (30, 0, 90) mm; pieces = 4; thickness = 2 mm }
  tissue is cord; velocity = (1, 0, 0) m/s; spin = (0, 30, 0) Hz
}
body mat {
  mesh is sheet {
    corner = (0, 0, 120) mm; first edge = (20, 0, 0) mm; second edge = (0, 9, 0) mm
    columns = 5; rows = 3 }
  tissue is gel; thickness = 1 mm
}
set face = nodes of solid where x == 0 mm
set part = nodes of net where z > 59 mm
set few = springs of net where z > 60 mm
tool tongs { kind is forceps }
environment { gravity = (0, 0, 0) m/s^2 }
script { SCRIPT }
simulate { duration = 1 ms }
output { OUTPUT }
"""
#: What stands for each kind; a set of nodes is one of elements.
NAMES = dict(
    zip(KINDS, ("net", "thread", "wall", "solid", "face", "few", "tongs"), strict=True)
)


def written(measure, kind):
    """Return a measure of what stands for a kind."""
    name = NAMES[kind]
    first = measure.form.replace("A)", f"{name})").replace("(A,", f"({name},")
    return first.replace(", B)", ", mat)")


def answered(measure, kind, script=""):
    """Return the codes of errors and warnings on a measure, and the compiled scene."""
    output = f"{written(measure, kind)} every 1 ms"
    text = SCENE.replace("OUTPUT", output).replace("SCRIPT", script)
    try:
        compiled, warnings = compile_request(Request(Source("scene.tis", text)))
    except CompileError as error:
        return {one.code for one in error.diagnostics if one.severity == "error"}, None
    return {one.code for one in warnings if one.code == "W703"}, compiled


OF_BODIES = [
    name for name, one in MEASURES.items() if one.subjects and not getattr(one, "of_contact", 0)
]


#: Conditions of the table that the scene meets.
MET = {
    "yes",
    "unless it is flat",
    "unless it is fixed",
    "of elements",
    "what it holds or consists of",
}


@pytest.mark.parametrize("name", sorted(OF_BODIES))
def test_what_a_measure_is_declared_for_is_what_it_is_taken_of(name):
    measure = MEASURES[name]
    needs = getattr(measure, "needs", ())
    for kind in KINDS:
        found, compiled = answered(measure, kind)
        where = set(meaning(measure.takes, needs, kind).split(", "))
        lacks = {"", "with springs in it", WHOLE, STRAINED}
        never = bool(where & lacks) or measure.takes == "jaws"
        assert found == ({"TIS702"} if never else {"W703"} if where - MET else set()), kind
        is_zero = all(NEEDS[one].result == "is always 0" for one in needs) or kind in BODIES
        if found == {"W703"} and kind != "tool" and is_zero:
            _, run = carried_out(compiled)
            of = "cut faces of " * (measure.takes == "cut faces") + NAMES[kind]
            values = np.nan_to_num(run.log_arrays(f"{name} of {of}")[1])
            assert (
                np.abs(values).max(initial=0.0) < 1e-15
            )  # sums of forces of some millinewtons


def test_pressure_is_known_of_what_is_pressed_and_of_nothing_else():
    measure = MEASURES["pressure"]
    assert answered(measure, "net")[0] == {"W703"}
    for order in ("press inside of net with 1 kPa", "preserve volume of net with 1 kPa"):
        assert answered(measure, "net", f"at 0 s: {order}")[0] == set()


@pytest.mark.parametrize(
    ("pressed", "zero"),
    [("solid", False), ("face", True), ("wall", True), ("inside of wall", True)],
)
def test_an_applied_pressure_is_known_of_what_the_script_names(pressed, zero):
    order = f"at 0 s: press {pressed} with 1 kPa"
    assert answered(MEASURES["applied pressure"], "solid", order)[0] == (
        {"W703"} if zero else set()
    )


SOLID = """language 1
tissue gel { Young's modulus = 5 kPa; density = 1000 kg/m^3 }
tissue cord { spring constant = 40 N/m; viscosity = 10 mN*s/m; mass = 50 mg }
body solid {
  mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (10, 5, 5) mm }; tissue is gel
}
body other like solid { moved by (0, 0, 9) mm }
set face = nodes of solid where x == 0 mm
set part = nodes of other where x == 0 mm
environment { gravity = (0, 0, 0) m/s^2; MORE }
script { at 0 s: fix face }
simulate { duration = 1 ms }
output { force(solid) every 1 ms; torque([solid, other]) every 1 ms }
"""


@pytest.mark.parametrize(
    ("inside", "more", "known"),
    [
        ("", "", False),
        ("", "joint glue { springs from face to part; tissue is cord }", None),
        ("contact is tools only; friction = 0",
         "tool slope { kind is plane; point = (0, 0, -9) mm; normal = (0, 0, 1) }", True),
        ("symmetric about plane through (0, 0, 0) mm facing (1, 0, 0)", "", True),
        ("", "force bed { kind is foundation; acts on face; stiffness = 1 kPa/m }", True),
    ],
)  # fmt: skip
def test_the_force_of_a_body_is_known_where_something_can_act_on_it(inside, more, known):
    text = SOLID.replace("MORE", inside) + more
    found = compile_request(Request(Source("scene.tis", text)))[1]
    said = [one.message.split(" is")[0] for one in found if one.code == "W703"]
    both = ["force(solid)", "torque([solid, other])"]
    # A joint acts on one of the bodies, but not on both together.
    assert said == ([] if known else both if known is False else both[1:])


def test_volumes_of_flat_sheets_are_refused():
    text = SCENE.replace("OUTPUT", "volume(mat) every 1 ms").replace("SCRIPT", "")
    with pytest.raises(CompileError, match=r"volume\(A\) needs a body that encloses a volume"):
        compiled_scene(text)


def test_every_need_is_declared_by_a_measure_and_has_words():
    measures = [*MEASURES.values(), *(FieldStatistic("largest", one) for one in FIELDS)]
    used = {need for one in measures for need in getattr(one, "needs", ())}
    assert used == set(NEEDS)
    assert all((one.text or one.absent) and one.hint for one in NEEDS.values())
