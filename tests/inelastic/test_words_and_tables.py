"""What springs relax and yield by: written, concluded, typed into tables, and changed."""

import numpy as np
import pytest

from tests.findings import finding_of
from tests.inelastic.scenes import ran, rod
from tests.validate.scenes import compiled_scene
from tissuec.compiler.provenance import explain_tissue
from tissuec.core.source import Source
from tissuec.pipeline import read_words
from tissuec.scene.request import Request

NET = """language 1
tissue gum {{ spring constant = 100 N/m; viscosity = 0 N*s/m; mass = 10 g; {memory} }}
{more}
body rod {{ mesh is explicit; tissue is gum; {body} }}
table nodes of rod in mm with columns "id x" {{ 1 0; 2 20; 3 30 }}
table springs of rod with columns "a b {column}" {{ 1 2 {first}; 2 3 {second} }}
environment {{ gravity = (0, 0, 0) m/s^2 }}
simulate {{ duration = 0.1 s }}
"""


def inelastic(
    memory="relaxing constant = 300 N/m; relaxation time = 20 ms",
    *,
    more="",
    body="",
    column="",
    first="",
    second="",
):
    """Return what the springs of 20 and 10 mm remember."""
    text = NET.format(
        memory=memory, more=more, body=body, column=column, first=first, second=second
    )
    return compiled_scene(text).network.springs.inelastic


def refused(text):
    return finding_of(compiled_scene, text)


def test_a_number_for_a_length_is_shared_out_by_lengths():
    found = inelastic(
        "relaxing constant = 300 N/m per 20 mm; relaxation time = 20 ms; "
        "yield force = 0.2 N; yield viscosity = 5 N*s/m per 20 mm"
    )
    assert found.constant[0] == pytest.approx([300.0, 600.0])
    assert found.viscosity == pytest.approx([5.0, 10.0])
    assert found.limit.tolist() == [0.2, 0.2]


def test_tables_give_single_springs_branches_and_limits():
    found = inelastic(
        "relaxing constant = 300 N/m; relaxation time = 20 ms",
        column="second relaxing constant in N/m second relaxation time in s",
        first="50 0.1", second="- -",
    )  # fmt: skip
    assert found.constant.tolist() == [[300.0, 300.0], [50.0, 0.0]]
    assert found.time.tolist() == [[0.02, 0.02], [0.1, np.inf]]
    # Two branches and one: three variables, in one row.
    assert np.sort(found.slot[found.slot >= 0]).tolist() == [9, 10, 11]
    only = inelastic(
        "", column="yield force in N yield viscosity in N*s/m", first="0 2", second="- -"
    )
    assert only.limit.tolist() == [0.0, np.inf]
    assert only.remembers.tolist() == [True, False]


def test_none_takes_away_what_a_parent_has():
    text = rod(memory="relaxing constant = 300 N/m; relaxation time = 20 ms")
    text = text.replace(
        "body rod", "tissue plain like gum { relaxation time is none }\nbody rod"
    )
    assert (
        compiled_scene(
            text.replace("tissue is gum", "tissue is plain")
        ).network.springs.inelastic
        is None
    )
    like = text.replace("relaxation time is none", "relaxing constant is none")
    found = ran(like.replace("tissue is gum", "tissue is plain"))
    assert (found.tension == 0.0).all()


@pytest.mark.parametrize(
    ("word", "constant", "time", "limit"),
    [
        ("mean", 150.0, 0.02, np.inf),
        ("softer", 0.0, None, np.inf),
        ("stiffer", 300.0, 0.02, 0.2),
    ],
)
def test_a_spring_between_regions_is_made_as_the_interface_says(word, constant, time, limit):
    """Of what one side has alone, a mean has half as much, that relaxes as fast."""
    found = inelastic(
        "relaxing constant = 300 N/m; relaxation time = 20 ms; "
        "yield force = 0.2 N; yield viscosity = 5 N*s/m",
        more="tissue soft { spring constant = 40 N/m; viscosity = 0 N*s/m; mass = 5 g }",
        body=f"region tip where x > 25 mm {{ tissue is soft }}; interface is {word}",
    )
    assert found.constant[0, 1] == constant
    assert found.limit[1] == limit
    if time is not None:
        assert found.time[0, 1] == time


def test_bending_springs_have_their_part():
    text = """language 1
tissue felt { spring constant = 100 N/m; viscosity = 0 N*s/m; mass = 1 g
  relaxing constant = 300 N/m; relaxation time = 20 ms
  yield force = 0.2 N; yield viscosity = 5 N*s/m }
body cloth {
  mesh is sheet { corner = (0, 0, 0) mm; columns = 3; rows = 3
                  first edge = (10, 0, 0) mm; second edge = (0, 10, 0) mm }
  tissue is felt; bending = 10 %
}
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 0.1 s }
"""
    network = compiled_scene(text).network
    found, bends = network.springs.inelastic, network.bends
    assert bends.sum() == 6
    assert found.constant[0, bends] == pytest.approx(30.0)
    assert found.viscosity[bends] == pytest.approx(0.5)
    # It yields at the strain of the springs beside it: twice as long, a tenth as stiff.
    assert found.limit[bends] == pytest.approx(0.2 * 0.1 * 2.0)
    assert (found.time == 0.02).all()


def test_a_vocabulary_concludes_them_as_any_quantity():
    text = """language 1
property firmness from 0 to 1 { evenly = [soft, hard] }
quantity relaxing constant from 1 N/m to 1 kN/m on log scale {
  evenly = [small, big]; applies to each spring of 1 mm
}
quantity relaxation time from 1 ms to 1 s on log scale {
  evenly = [short, long]; applies to each spring
}
rules simple { if firmness is hard then relaxing constant is big and relaxation time is short }
tissue cork { described in simple; firmness is hard }
"""
    words, _ = read_words(Request(Source("cork.tis", text)))
    found = {one.quantity: one for one in explain_tissue(words.tissues["cork"])}
    assert found["relaxing constant"].how == found["relaxation time"].how == "rules"
    assert 30.0 < found["relaxing constant"].value < 1e3
    assert found["relaxation time"].shown.endswith("ms")


def test_a_change_switches_a_branch_on_and_lets_it_relax_faster():
    memory = "relaxing constant = 0 N/m; relaxation time = 20 ms"
    script = """at 0 s: fix bob
      at 0 s: change relaxing constant of rod to 300 N/m
      at 50 ms: change relaxation time of rod by 25 %"""
    found = ran(rod(memory=memory, script=script, length=22))
    early, late = found.time <= 0.05, found.time > 0.05
    left = 0.6 * np.exp(-found.time / 0.02)
    assert found.tension[early] == pytest.approx(0.2 + left[early], rel=1e-8)
    left = 0.6 * np.exp(-2.5 - (found.time - 0.05) / 0.005)
    assert found.tension[late] == pytest.approx(0.2 + left[late], rel=1e-8)


def test_one_half_of_a_pair_is_refused_at_its_place():
    finding = refused(rod(memory="yield force = 0.2 N"))
    assert finding.code == "TIS304"
    assert finding.message == "a yield force needs a yield viscosity"
    assert finding.span.text == "yield force = 0.2 N"
    assert finding.hint == "for example: yield viscosity = 1 N*s/m"


def test_numbers_that_cannot_be_are_refused():
    for memory, message in (
        ("relaxing constant = -1 N/m; relaxation time = 1 s",
         "relaxing constant must be at least 0 N/m, not -1 N/m"),
        ("relaxing constant = 1 N/m; relaxation time = 0 s",
         "relaxation time must be above 0 s, not 0 s"),
        ("yield force = 1 N; yield viscosity = 0 N*s/m",
         "yield viscosity must be above 0 N*s/m, not 0 N*s/m"),
    ):  # fmt: skip
        assert refused(rod(memory=memory)).message == message


def test_a_change_of_what_springs_do_not_have_is_refused():
    finding = refused(rod(script="at 1 ms: change yield force of rod to 1 N"))
    assert finding.message == (
        "1 spring of rod has no yield force and yield viscosity at the start; "
        'to change them later, write "yield force is none" and a yield viscosity in the tissue'
    )


def test_a_method_that_would_leave_it_out_is_refused():
    finding = refused(rod(method="integrator is relaxation; step = 1 ms"))
    assert finding.code == "TIS306"
    assert finding.message.startswith("relaxation does not support springs that relax or yield")


def test_knots_neither_relax_nor_yield():
    network = compiled_scene("""language 1
tissue silk {
  spring constant = 100 N/m; viscosity = 0.1 N*s/m; mass = 1 g; breaking force = 2 N
  relaxing constant = 50 N/m; relaxation time = 20 ms
  yield force = 0.5 N; yield viscosity = 20 N*s/m
}
body sling {
  mesh is thread { line from (0, 0, 0) mm to (20, 0, 0) mm; pieces = 4; thickness = 1 mm }
  tissue is silk
  rupture is allowed
}
environment { gravity = (0, 0, 0) m/s^2; contact is off }
simulate { duration = 0.1 s }
""").network
    thread = network.threads["sling"]
    memory = network.springs.inelastic
    for knot in (thread.hold, thread.slip):
        assert (memory.slot[:, knot] == -1).all()
    assert (memory.slot[:, thread.pieces] >= 0).all()
