"""``[A, B]`` wherever a set or a body can stand: the same as the set with a name."""

import numpy as np
import pytest

from tests.validate.scenes import compiled_scene
from tests.whole_runs import carried_out
from tissuec.core.errors import CompileError

SCENE = """language 1
tissue gel { spring constant = 40 N/m; viscosity = 0.02 N*s/m; mass = 1 g }
tissue silk { spring constant = 90 N/m; viscosity = 0.1 N*s/m }
body one { mesh is sheet { corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm
  second edge = (0, 10, 0) mm; columns = 5; rows = 3; diagonals is both }; tissue is gel }
body two like one { moved by (0, 0, 5) mm }
body three like one { moved by (0, 0, -5) mm }
set left = nodes of one where x < 1 mm
set right = nodes of two where x > 19 mm
set both = [left, right]
set far = nodes of [one, two] where x > 14 mm
joint fibres { springs from BODIES to three; tissue is silk; reach = 30 mm }
force wind { kind is foundation; acts on BOTH; stiffness = 1 kPa/m }
environment { gravity = (0, 0, -9.81) m/s^2; damping = 20 mN*s/m }
script {
  at 0 s: fix BOTH
  from 1 ms to 4 ms: move BOTH by (0, 0, 1) mm using smooth profile
  at 2 ms: push far with (0, 0, 1) mN
  at 3 ms: change spring constant of BODIES by 2
  when force(BOTH) > 1 kN: cut BODIES along plane through (9, 0, 0) mm facing (1, 0, 0)
}
simulate { duration = 5 ms; integrator is dop853; tolerance = 1e-5 }
output { trajectory of BODIES every 1 ms; force of BOTH every 1 ms
  springs of BODIES every 1 ms }
expect force(BOTH along (0, 0, 1)) > 0 N at 4 ms and count(nodes of BODIES) > 0 at 4 ms
"""
SCENE = SCENE.replace(" at 4 ms and", " and")


def compiled(both, either):
    return compiled_scene(SCENE.replace("BOTH", both).replace("BODIES", either))


def test_a_union_is_the_set_that_it_could_be_named_as():
    named = compiled_scene(
        SCENE.replace("BOTH", "both")
        .replace("BODIES", "pair")
        .replace("set far", "set pair = [one, two]\nset far")
    )
    listed = compiled("[left, right]", "[one, two]")
    runs = [carried_out(one)[1] for one in (named, listed)]
    for one, other in zip(*(run.frame_arrays() for run in runs), strict=True):
        assert np.array_equal(one, other, equal_nan=True)
    logs = [[log.name for log in one.plan.output.logs] for one in (named, listed)]
    assert logs == [
        ["force of both", "springs of pair"],
        ["force of [left, right]", "springs of [one, two]"],
    ]
    forces = [
        run.log_arrays(title)[1]
        for run, title in zip(runs, ("force of both", "force of [left, right]"), strict=True)
    ]
    assert np.array_equal(*forces) and forces[0].any()


def test_results_do_not_list_unions_among_the_sets():
    names = [group.name for group in compiled("[left, right]", "[one, two]").groups.named()]
    assert names == ["left", "right", "both", "far"]


def test_a_set_can_be_chosen_from_several_bodies():
    found = compiled("both", "one").groups
    far = next(group for group in found.named() if group.name == "far").indices
    own = [found.bodies[name].nodes for name in ("one", "two")]
    assert np.isin(far, np.concatenate(own)).all()
    assert [np.isin(far, nodes).sum() for nodes in own] == [6, 6]


@pytest.mark.parametrize(
    ("both", "code", "words"),
    [
        ("[left, rihgt]", "TIS301", 'there is no set called "rihgt"'),
        ("[left, fibres]", "TIS314", ""),
    ],
)
def test_a_wrong_name_in_a_union_is_marked_itself(both, code, words):
    with pytest.raises(CompileError) as caught:
        compiled(both, "one")
    found = caught.value.diagnostics[0]
    assert found.code == code and words in str(found)
    if code == "TIS301":
        assert found.span.text == "rihgt"
