"""What texts compile to: which nodes and springs are the same, and how their numbers differ."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.view.compare.scenes import TABLES
from tissuec.view.compare.comparison import compare
from tissuec.view.compare.matching import match_nodes, match_springs
from tissuec.view.compare.parameters import ROUNDING, relative_difference

NUMBERS = st.floats(-1e6, 1e6) | st.just(np.inf)


def test_a_scene_and_itself_differ_in_nothing(compared, told):
    found = compared(TABLES, TABLES)
    assert found.is_same
    assert told(found).endswith("no differences (text, 19 nodes, 26 springs)")


@given(st.lists(st.tuples(NUMBERS, NUMBERS), min_size=1))
def test_relative_differences_are_the_same_from_either_side_and_bounded(pairs):
    a, b = np.array(pairs).T
    there, back = relative_difference(a, b), relative_difference(b, a)
    assert np.array_equal(there, back)
    assert ((there >= 0.0) & (there <= 2.0)).all()
    assert np.array_equal(there == 0.0, a == b)


@pytest.mark.parametrize(
    ("a", "b", "relative"),
    [(8.0, 10.0, 0.2), (0.0, 3.0, 1.0), (-1.0, 1.0, 2.0), (2.0, np.inf, 1.0),
     (np.inf, np.inf, 0.0), (0.0, 0.0, 0.0)],
)  # fmt: skip
def test_relative_differences_in_closed_form(a, b, relative):
    assert relative_difference(np.array([a]), np.array([b]))[0] == pytest.approx(relative)


def test_a_number_of_a_tissue_is_told_with_both_lines_of_text(compared, told):
    found = compared(TABLES, TABLES.replace("40 N/m", "50 N/m"))
    assert {change.quantity for change in found.changes} == {"spring constant"}
    chain, flap, joining = found.changes
    assert [chain.part, flap.part, joining.part] == ["chain", "flap", "flap | hard of flap"]
    assert (chain.count, chain.total, chain.relative) == (4, 4, pytest.approx(0.2))
    assert (chain.a, chain.b) == (40.0, 50.0)
    assert [(given.place, given.how, given.text) for given in chain.from_a] == [
        ("scene:3", "written", "spring constant = 40 N/m")
    ]
    assert chain.from_b[0].text == "spring constant = 50 N/m"
    assert [given.how for given in joining.from_a] == ["interface softer"]
    text = told(found)
    assert "spring constant of chain: all 4 springs, 40 N/m -> 50 N/m, 20 %" in text
    assert "a: scene:3, written: spring constant = 40 N/m" in text
    assert "identical: settings, nodes and springs, script" in text


def test_a_region_is_told_by_itself(compared):
    found = compared(TABLES, TABLES.replace("90 N/m", "45 N/m"))
    assert [(change.part, change.relative) for change in found.changes] == [
        ("hard of flap", 0.5)
    ]


def test_limits_that_one_does_not_have_are_none(compared, told):
    found = compared(TABLES, TABLES.replace("breaking force = 2 N", "breaking force is none"))
    (change,) = found.changes
    assert change.quantity == "breaking force"
    assert (change.a, change.b, change.relative) == (2.0, np.inf, 1.0)
    assert "2 N -> none, 100 %" in told(found)


def test_where_numbers_are_not_alike_the_largest_difference_has_an_id(compared, told):
    table = '"a b spring constant in N/m" { 1 2 40; 2 3 44; 2 3 30; 3 4 40 }'
    other = TABLES.replace('"a b" { 1 2; 2 3; 2 3; 3 4 }', table)
    found = compared(TABLES, other)
    (change,) = found.changes
    assert (change.count, change.total, change.worst) == (2, 4, "3 of chain")
    assert (change.a, change.b, change.relative) == (40.0, 30.0, 0.25)
    assert change.range_b == (30.0, 44.0)
    assert change.from_b[0].how == "table"
    assert "2 of 4 springs, 40 N/m -> 30 N/m (spring 3 of chain), 25 % at most" in told(found)


def test_rounding_is_no_difference(compared):
    """Numbers next to one another are the same; those that somebody could mean are not."""
    assert np.spacing(40.0) / 40.0 < ROUNDING
    assert not compared(TABLES, TABLES.replace("40 N/m", "40.000000000000007 N/m")).changes
    assert compared(TABLES, TABLES.replace("40 N/m", "40.0000000001 N/m")).changes


def test_drawn_places_are_compared_with_the_size_of_the_drawing(compared, told):
    found = compared(TABLES, TABLES.replace("4 30 }", "4 33 }"))
    place, length = found.changes
    assert (place.quantity, place.worst) == ("drawn position", "4 of chain")
    assert place.relative == pytest.approx(3.0 / 33.0)
    assert place.a == pytest.approx((0.03, 0.0, 0.0))
    assert length.quantity == "rest length"
    assert "(0.03, 0, 0) m -> (0.033, 0, 0) m (node 4 of chain), 9.09 %" in told(found)


def test_a_row_that_is_left_out_leaves_the_other_springs_their_partners(scene):
    a, b = scene(TABLES), scene(TABLES.replace("1 2; 2 3; 2 3; 3 4", "2 3; 2 3; 3 4"))
    found = compare(a, b)
    assert not found.changes
    (leftover,) = found.leftovers
    assert (leftover.side, leftover.what, leftover.part) == ("a", "spring", "chain")
    assert (leftover.count, leftover.total, leftover.ids) == (1, 4, (1,))
    pairs = match_springs(a, b, match_nodes(a, b))
    assert pairs.a[:3].tolist() == [1, 2, 3] and pairs.b[:3].tolist() == [0, 1, 2]


def test_ids_count_and_not_the_order_of_rows(scene):
    a = scene(TABLES)
    b = scene(TABLES.replace("1 0; 2 10; 3 20; 4 30", "4 30; 1 0; 3 20; 2 10"))
    found = compare(a, b)
    assert found.texts and not found.changes and not found.leftovers
    assert match_nodes(a, b).b[:4].tolist() == [1, 3, 2, 0]


def test_springs_that_are_written_the_other_way_round_are_the_same(compared):
    found = compared(TABLES, TABLES.replace("1 2; 2 3; 2 3; 3 4", "2 1; 3 2; 2 3; 4 3"))
    assert not found.changes and not found.leftovers


def test_bodies_that_only_one_has_are_told_as_wholes(compared, told):
    start, end = TABLES.index("body flap"), TABLES.index("environment")
    without = TABLES[:start] + TABLES[end:]
    found = compared(TABLES, without)
    assert "only in a: all 15 nodes of flap" in told(found)
    assert "only in a: all 22 springs of flap" in told(found)
    assert not found.changes
    assert [one.side for one in compared(without, TABLES).leftovers] == ["b", "b"]


def test_a_body_with_another_name_is_another_body(compared):
    found = compared(TABLES, TABLES.replace("chain", "row"))
    assert len(found.nodes) == 15
    assert {one.part for one in found.leftovers} == {"chain", "row"}


def test_a_body_that_comes_in_between_changes_nothing_of_the_others(compared):
    more = """body dot { mesh is explicit; tissue is cord }
table nodes of dot in mm with columns "id x" { 1 90; 2 95 }
table springs of dot with columns "a b" { 1 2 }
body chain"""
    found = compared(TABLES, TABLES.replace("body chain", more))
    assert not found.changes and {one.part for one in found.leftovers} == {"dot"}
    assert (len(found.nodes), len(found.springs)) == (19, 26)


def test_another_mesh_keeps_what_has_the_same_ids(compared, told):
    found = compared(TABLES, TABLES.replace("columns = 5", "columns = 6"))
    assert len(found.nodes) == 19
    assert "only in b: 3 of 18 nodes of flap (16, 17, 18)" in told(found)


def test_laws_and_what_springs_remember_are_compared(compared, told):
    memory = "relaxing constant = 10 N/m; relaxation time = 20 ms; "
    found = compared(TABLES, TABLES.replace("tissue cord {", "tissue cord { " + memory))
    assert {c.quantity for c in found.changes} == {"relaxing constant", "relaxation time"}
    law = "spring law is tension only; "
    found = compared(TABLES, TABLES.replace("tissue cord {", "tissue cord { " + law))
    assert {(c.quantity, c.a, c.b) for c in found.changes} == {
        ("law", "linear", "tension only")
    }
    assert "law of chain: all 4 springs, linear -> tension only" in told(found)


def test_layout_is_no_difference_and_remarks_are(compared):
    assert not compared(TABLES, TABLES.replace("; ", " ;  ").replace("{ ", "{   ")).texts
    (text,) = compared(TABLES, TABLES.replace("tissue scar", "# worse\ntissue scar")).texts
    assert (text.name, text.kind) == ("scene", "changed")
    assert "+# worse" in text.lines


def test_what_is_used_is_compared_too(compared, told):
    words = TABLES.replace("tissue cord", 'use "tissues/muscle"\ntissue cord')
    found = compared(TABLES, words)
    assert [(one.name, one.kind) for one in found.texts] == [
        ("scene", "changed"),
        ("fuzzy/words.tis", "only in b"),
        ("fuzzy/soft_tissue.tis", "only in b"),
        ("tissues/muscle.tis", "only in b"),
    ]
    assert 'only in b: "tissues/muscle.tis"' in told(found)


def test_the_script_of_two_scenes_is_compared(compared, told):
    script = "script { at 0 s: fix flap; at 0.2 ms: free flap }\nsimulate"
    text = TABLES.replace("simulate", script, 1)
    found = compared(text, text.replace("0.2 ms", "0.5 ms"))
    assert "\nscript\n  200 us -> 500 us: free flap" in told(found)
    assert found.settings == ()


def test_settings_of_the_simulation_are_told(compared):
    found = compared(TABLES, TABLES.replace("1 ms }", "2 ms; tolerance = 1e-6 }", 1))
    assert {(fact.name, fact.a, fact.b) for fact in found.settings} == {
        ("duration", 0.001, 0.002),
        ("tolerance", 0.0001, 1e-06),
    }


def test_a_spring_that_leads_elsewhere_is_another_spring(compared, told):
    found = compared(TABLES, TABLES.replace("{ 1 2; 2 3;", "{ 1 3; 2 3;"))
    alone = [(one.side, one.part, one.ids) for one in found.leftovers]
    assert alone == [("a", "chain", (1,)), ("b", "chain", (1,))]
    assert "only in a: 1 of 4 springs of chain (1)" in told(found)


def test_joints_are_parts_of_their_own(compared):
    joint = "joint seam { springs from chain to flap; tissue is scar }\nenvironment"
    joined = TABLES.replace("environment", joint, 1)
    found = compared(joined, joined.replace("90 N/m", "45 N/m"))
    assert [change.part for change in found.changes] == ["hard of flap", "seam"]
    assert [one.part for one in compared(TABLES, joined).leftovers] == ["seam"]
