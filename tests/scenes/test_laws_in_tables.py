"""Laws that single springs of a table have: read, mixed with those of tissues, and moving."""

import numpy as np
import pytest

from tests.findings import finding_of
from tests.validate.scenes import compiled_scene, validated
from tissuec.laws import LINEAR
from tissuec.mechanics import observables
from tissuec.mechanics.state import State

SCENE = """language 1
{laws}
tissue gum {{ {gum}viscosity = 10 mN*s/m; mass = 1 g; {tissue} }}
body net {{ mesh is explicit; tissue is gum; {body} }}
table nodes of net in mm with columns "id x y z" {{ 0 0 0 0; 1 11 0 0; 2 22 0 0; 3 33 0 0 }}
table springs of net with columns "a b rest length in mm {columns}" {{
  0 1 10 {cells[0]}
  1 2 10 {cells[1]}
  2 3 10 {cells[2]}
}}
set left = nodes of net in [0]
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{ at 0 s: fix left }}
simulate {{ duration = 0.1 s; tolerance = 1e-7 }}
output {{ trajectory every 5 ms }}
"""
LAWS = """law fibre { spring law is polynomial { cube = 4e7 N/m^3 }; viscosity law is linear }
law "stiff band" { spring force of e = 3 * c * e; viscous force of w = 2 * d * w }
law free { spring force of e = 5 N/m * e }"""
MIXED = ("fibre", "-", '"stiff band"')


def scene(cells=MIXED, *, laws=LAWS, gum="spring constant = 20 N/m; ", tissue="", body="",
          columns="law"):  # fmt: skip
    return SCENE.format(
        laws=laws, cells=cells, gum=gum, tissue=tissue, body=body, columns=columns
    )


def pulls(compiled):
    """Return the tensions at rest: each spring is drawn 1 mm too long [N]."""
    net = compiled.network
    state = State.start(net, gravity=np.zeros(3), drag=0.0)
    return observables.tension(state, net.position, np.zeros_like(net.position))


def finding(text):
    return finding_of(compiled_scene, text)


def test_each_spring_has_the_law_of_its_row_or_that_of_the_tissue():
    compiled = compiled_scene(scene())
    assert [compiled.network.springs.laws[n].name for n in compiled.network.springs.law] == [
        "fibre", LINEAR.name, "stiff band",
    ]  # fmt: skip
    assert pulls(compiled) == pytest.approx([20e-3 + 4e-2, 20e-3, 60e-3])


def test_an_open_cell_takes_a_law_of_the_tissue_and_a_named_one_replaces_it():
    compiled = compiled_scene(scene(tissue="spring law is dead band { slack = 0.5 mm }"))
    assert pulls(compiled) == pytest.approx([60e-3, 10e-3, 60e-3])


def test_a_law_without_a_spring_constant_asks_for_none():
    compiled = compiled_scene(scene(("free", "free", "free"), gum=""))
    assert pulls(compiled) == pytest.approx([5e-3] * 3)
    assert compiled.network.provenance["stiffness"][0].how == "no part of the law"


def test_a_law_with_one_needs_it_from_tissue_or_table():
    found = finding(scene(("free", "fibre", "free"), gum=""))
    assert (found.code, found.message) == (
        "TIS206",
        "the spring constant of tissue gum is missing: neither a rule nor a number gives it",
    )
    typed = scene(
        ("free -", "fibre 30", "free -"), gum="", columns="law spring constant in N/m"
    )
    assert pulls(compiled_scene(typed)) == pytest.approx([5e-3, 70e-3, 5e-3])


def test_a_law_of_a_tissue_without_a_spring_constant_does_not_stand_in_for_one():
    text = scene(gum="", tissue="spring force of e = 7 N/m * e")
    assert finding(text).code == "TIS206"


def test_springs_between_regions_may_have_a_law_of_their_own_whatever_the_interface():
    body = "interface is mean; region far where x > 15 mm { tissue is chalk }"
    laws = LAWS + "\ntissue chalk like gum { spring law is tension only }"
    assert finding(scene(laws=laws, body=body)).code == "TIS309"
    compiled = compiled_scene(scene(("-", "free", "-"), laws=laws, body=body))
    assert pulls(compiled) == pytest.approx([20e-3, 5e-3, 20e-3])


def test_the_order_of_rows_and_capitals_do_not_matter():
    one = compiled_scene(scene(("free", "FIBRE", "free")))
    assert pulls(one) == pytest.approx([5e-3, 60e-3, 5e-3])


def test_an_unknown_law_is_refused_at_its_cell():
    found = finding(scene(("fibre", "fiber", "fibre")))
    assert (found.code, found.message) == ("TIS301", 'there is no law called "fiber"')
    assert found.span.one_line == "fiber"
    assert 'did you mean "fibre"' in found.hint


def test_a_net_of_mixed_laws_moves_as_the_reference_does():
    found = validated(scene())
    assert found.verdict == "kept"
