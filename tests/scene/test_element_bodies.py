"""Bodies made of finite elements: what they consist of, and what is refused."""

import numpy as np
import pytest
from click.testing import CliRunner

import tissuec
from tests.every import every
from tests.findings import finding_of
from tests.whole_runs import carried_out
from tissuec.analysis.bodies import properties_of
from tissuec.cli import group
from tissuec.compiler.compile import Compiled
from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.forces.solids.elements import SolidElements
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

SCENE = """\
language 1
tissue gel {{ Young's modulus = 10 kPa; density = 1000 kg/m^3; {tissue} }}
tissue nut {{ Young's modulus = 40 kPa; Poisson's ratio = 0.4; density = 2000 kg/m^3 }}
body block {{
  mesh is lattice {{ cell = 5 mm; box from (0, 0, 0) mm to (20, 20, 20) mm; {mesh} }}
  tissue is gel
  {body}
}}
set low = nodes of block where z < 0.1 mm
set high = nodes of block where z > 19.9 mm
environment {{ gravity = (0, 0, {gravity}) m/s^2 }}
script {{ at 0 s: fix low; {script} }}
simulate {{ duration = {duration} }}
"""


def scene(
    body="made of elements",
    *,
    tissue="",
    mesh="",
    script="",
    duration="1 ms",
    gravity=0,
    more="",
):
    text = SCENE.format(
        body=body, tissue=tissue, mesh=mesh, script=script, duration=duration, gravity=gravity
    )
    return Request(Source("block.tis", text + more))


def compiled(body="made of elements", **parts) -> Compiled:
    found, warnings = compile_request(scene(body, **parts))
    # Sets without any use, regions whose limits are between cells, and parts moved at once.
    assert {w.code for w in warnings} <= {"W502", "W213", "W504"}
    return found


def elements(of: Compiled) -> SolidElements:
    (block,) = (block for block in of.network.blocks if block.kind == "elements")
    return block.field


def refusal(body="made of elements", **parts) -> tuple[str, str]:
    found = finding_of(compile_request, scene(body, **parts))
    return f"{found.code}: {found.message}", found.hint


def test_solids_of_matter_consist_of_elements():
    assert elements(compiled("")).item_count == 64


@pytest.mark.parametrize("kind", ["", "kind is sodium chloride; reach is second neighbours"])
def test_solids_of_matter_cannot_be_made_of_springs(kind):
    found = finding_of(compile_request, scene("made of springs", mesh=kind))
    assert (found.code, found.span.text) == ("TIS306", "made of springs")
    assert "a solid or a wall in pascals consists of elements" in found.message
    (edit,) = found.hint.edits
    text = found.span.source.text
    span = edit.at(found.span).span
    left = text[: span.start] + edit.text + text[span.end :]
    assert "made of" not in left
    assert (_codes(left) == {"TIS306"}) == bool(kind)  # of the reach of springs


def test_a_region_of_single_springs_is_refused():
    own = "tissue own { spring constant = 4 N/m; viscosity = 1 mN*s/m; mass = 1 mg }\n"
    region = "region top where z > 12 mm { tissue is own }"
    found = finding_of(compile_request, scene(region, more=own))
    assert found.message == "elements need a Young's modulus, but own describes springs"
    assert found.span.text.startswith("region top")


@pytest.mark.parametrize("quantity", ["shear viscosity = 2 Pa*s", "Young's modulus = 5 kPa"])
def test_springs_of_a_solid_have_no_quantity_in_pascals(quantity):
    text = f"""language 1
tissue net {{ spring constant = 4 N/m; viscosity = 1 mN*s/m; mass = 1 mg }}
tissue own like net {{ {quantity}; mass = 1 mg }}
body block {{
  mesh is lattice {{ kind is diamond; cell = 5 mm; box from (0, 0, 0) mm to (20, 20, 20) mm }}
  tissue is net; springs where z > 9 mm {{ tissue is own }}
}}
environment {{ gravity = (0, 0, 0) m/s^2 }}
simulate {{ duration = 1 ms }}
"""
    found = finding_of(compile_request, Request(Source("block.tis", text)))
    assert found.span.text == quantity
    assert "elements, threads and bars have one" in found.message


@pytest.mark.parametrize("what", ["reach is second neighbours", "kind is diamond"])
def test_entries_of_springs_in_a_solid_of_matter_lead_out(what):
    found = finding_of(compile_request, scene("", mesh=what))
    assert [note.message for note in found.notes] == [
        "a tissue with a Young's modulus is made of elements"
    ]
    assert found.notes[0].span.text == "tissue is gel"
    text = scene("", mesh=what).source.text
    for edit in found.hint.edits:
        span = edit.at(found.span).span
        changed = text[: span.start] + edit.text + text[span.end :]
        codes = _codes(changed)
        assert "TIS306" not in codes, (edit.text, codes)


def _codes(text: str) -> set[str]:
    try:
        _, warnings = compile_request(Request(Source("block.tis", text)))
    except CompileError as error:
        return {one.code for one in error.diagnostics}
    return {one.code for one in warnings}


def test_a_lattice_of_a_wrong_tissue_is_not_asked_for_a_kind():
    assert _codes(scene("", tissue="Poisson's ratio = 0.5").source.text) == {"TIS308"}


def test_a_body_of_a_wrong_tissue_is_asked_for_nothing_of_springs():
    directed = "prestress along (0, 0, 1); fibres = (1, 0, 0); second fibres = (0, 1, 0)"
    wrong = "Poisson's ratio = 0.5; fibre modulus = 30 kPa; prestress = 10 %"
    assert _codes(scene(directed, tissue=wrong).source.text) == {"TIS308"}


def test_an_open_file_is_a_wall_and_a_filled_one_a_solid(tmp_path):
    shape = "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
    (tmp_path / "tip.obj").write_text(shape)
    text = """language 1
tissue gel { Young's modulus = 10 kPa; density = 1000 kg/m^3; retardation time = 0 s }
body tip { mesh is imported { file "tip.obj" in mm; MORE }; tissue is gel; THICK }
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 ms }
"""

    def kinds(more, thick=""):
        (tmp_path / "tip.tis").write_text(text.replace("MORE", more).replace("THICK", thick))
        found = tissuec.compile(tmp_path / "tip.tis")
        return {block.kind for block in found.network.blocks}

    assert "elements" in kinds("filling is tetrahedra; cell = 1.5 mm")
    assert "elements" not in kinds("", "thickness = 1 mm")


def test_the_volume_of_a_body_is_that_of_its_elements():
    # A uniform stretch of 10 % along z; the ends stay as wide as they are drawn.
    more = "expect volume(block) between 8.7999999 ml and 8.8000001 ml at 1 us\n"
    script = "from 0 s to 1 us: move high by (0, 0, 2) mm using constant speed"
    held = script + "; at 0 s: fix inner"
    outcome, _ = carried_out(
        compiled(
            "", mesh="", script=held, duration="1 us",
            more="set inner = nodes of block where z between 1 mm and 19 mm\n" + more,
        )
    )  # fmt: skip
    assert not (outcome.failures or outcome.unreached)


def test_moduli_follow_from_the_tissue():
    found = elements(compiled(tissue="Poisson's ratio = 0.3; retardation time = 2 ms"))
    assert found.item_count == 64
    np.testing.assert_allclose(found.shear, 10e3 / 2.6, rtol=1e-12)
    np.testing.assert_allclose(found.bulk + found.local, 10e3 / 1.2, rtol=1e-12)
    np.testing.assert_allclose(found.viscosity, 2e-3 * 10e3 / 2.6, rtol=1e-12)


def test_without_more_a_tissue_has_a_ratio_of_one_quarter_and_no_viscosity():
    found = elements(compiled())
    np.testing.assert_allclose(found.bulk_modulus / found.shear, 5.0 / 3.0, rtol=1e-12)
    assert not found.viscosity.any()
    thick = elements(compiled(tissue="shear viscosity = 3 Pa*s"))
    np.testing.assert_allclose(thick.viscosity, 3.0)
    wide = elements(compiled(tissue="Poisson's ratio = -0.5"))
    np.testing.assert_allclose(wide.bulk_modulus / wide.shear, 1.0 / 6.0, rtol=1e-12)


def test_edges_of_elements_are_no_springs():
    network = compiled().network
    assert (network.spring_count, network.line_count) == (0, 300)
    assert network.bodies[0].lines == network.bodies[0].edges == slice(0, 300)
    assert not network.bears.any()
    assert network.shown_lines.all()
    between = np.diff(network.position[network.edges], axis=1)[:, 0]
    np.testing.assert_allclose(np.linalg.norm(between, axis=1), 5e-3)
    assert not len(network.provenance["stiffness"].index)
    assert network.mass.sum() == pytest.approx(8e-3, rel=1e-12)


@pytest.mark.parametrize("limit", ["z > 10 mm", "z >= 10 mm"])
def test_a_plane_between_two_layers_of_cells_divides_regions_there(limit):
    body = f"made of elements; region top where {limit} {{ tissue is nut }}"
    found = compiled(body)
    own = elements(found)
    height = found.network.position[own.nodes][..., 2].mean(axis=1)
    hard = 40e3 / 2.8
    np.testing.assert_allclose(
        own.shear, np.where(height > 10e-3, hard, 10e3 / 2.5), rtol=1e-12
    )
    assert found.network.mass.sum() == pytest.approx(4e-3 + 8e-3, rel=1e-12)


def test_the_mass_of_a_body_goes_by_volume():
    network = compiled("made of elements; mass = 64 g").network
    assert network.mass.sum() == pytest.approx(64e-3, rel=1e-12)
    weight = network.mass * network.weighing
    assert weight.max() == pytest.approx(8.0 * weight.min(), rel=1e-12)


def test_a_pressed_block_resists_as_its_elements_do():
    press = "from 0 s to 0.5 s: move high by (0, 0, -0.2) mm using smooth profile"
    # 43.02 mN of ever smaller elements; four across are stiffer by 16 parts in a thousand.
    outcome, _ = carried_out(
        compiled(
            tissue="Poisson's ratio = 0.3; retardation time = 5 ms; "
            "solid law is neo hookean { volume is quadratic }", script=press,
            duration="0.7 s", more="expect force(high) between 43.6 mN and 43.8 mN at 0.7 s\n",
        )
    )  # fmt: skip
    assert not (outcome.failures or outcome.unreached)


def test_a_block_settles_under_its_weight():
    # Nodes of the base do not weigh on it: 7 g of 8 g do.
    more = "expect force(low) between 68.6 mN and 68.7 mN at 1 ms\n"
    outcome, _ = carried_out(
        compiled(
            tissue="retardation time = 5 ms", script="at 0 s: settle", gravity=-9.81, more=more
        )
    )
    assert not (outcome.failures or outcome.unreached)
    # ρ g h² / 2 E is 0.2 mm; a little less, as the base cannot become wider.
    sunk = outcome.state.position - outcome.state.network.position
    assert -0.25e-3 < sunk[:, 2].min() < -0.1e-3


def test_contact_is_as_stiff_as_elements():
    text = scene(tissue="Poisson's ratio = 0.3").source.text
    found, _ = compile_request(
        Request(Source("a.tis", text.replace("m/s^2 }", "m/s^2; contact is everywhere }")))
    )
    # Of the order of Young's modulus times the edge of a cell, for each of three directions.
    assert 50.0 < float(np.max(found.network.contact.stiffness)) < 500.0


def test_check_counts_elements(tmp_path):
    (tmp_path / "block.tis").write_text(scene().source.text, encoding="utf-8")
    said = CliRunner().invoke(group, ["check", str(tmp_path / "block.tis")])
    assert "(125 nodes, 64 elements)" in said.output


def test_properties_of_a_body_are_those_of_its_tissue():
    found = compiled(tissue="Poisson's ratio = 0.3; retardation time = 2 ms")
    (block,) = properties_of(found)
    assert block.elasticity is not None
    assert block.elasticity.young == pytest.approx((10e3,) * 3)
    assert block.elasticity.poisson == pytest.approx(0.3)
    assert block.retardation_time == pytest.approx(2e-3)
    assert len(block.vibrations) == 3
    (two,) = properties_of(
        compiled("made of elements; region a where z > 9 mm { tissue is nut }")
    )
    assert two.elasticity is None
    assert any("differ" in note for note in two.notes)


MISTAKES = {
    "made = elements": 'TIS312: a body is "made of" elements or springs',
    "made is elements": 'TIS312: a body is "made of" elements or springs',
    "made elements": 'TIS312: a body is "made of" elements or springs',
    "made of element": 'TIS305: unknown constituent "element"',
    "made of gel": 'TIS305: a body cannot be made of "gel"',
    "made of elements; made of elements": 'TIS307: "made" is given twice',
    "made of elements; interface is softer":
        'TIS306: "interface" is not available for elements',
    "made of elements; bending = 3 %": 'TIS306: "bending" is not available for elements',
    "made of elements; fibres = (1, 0, 0)":
        "TIS306: fibres of block have no effect: its tissue has no fibre modulus",
    "made of elements; thickness = 1 mm": 'TIS306: a body of elements cannot have "thickness"',
    "made of elements; springs where x > 1 mm { tissue is nut }":
        "TIS306: a tissue for springs where x > 1 mm is not available for elements",
    "made of elements; region a where x > 1 mm { prestress = 2 % }":
        "TIS304: block needs the direction of its prestress",
    "made of elements; prestress along (1, 0, 0)":
        "TIS306: the direction of prestress of block has no effect: its tissue has no "
        "prestress",
    "made of elements; prestress along (0, 0, 0)": "TIS308: a direction cannot be (0, 0, 0)",
    "made of elements; prestress along 3": 'TIS312: "along" needs a direction without a unit',
    "made of elements; prestress by (1, 0, 0)": 'TIS303: prestress does not take "by"',
    "made of elements; prestress along (1, 0, 0) across (0, 0, 1)":
        "TIS312: prestress of a body has one direction",
    "made of elements; prestress = 5 %":
        "TIS312: in a body, the prestress is a formula of x, y or z",
}  # fmt: skip


@every(("body", "message"), MISTAKES.items())
def test_what_is_of_springs_is_refused_of_a_body(body, message):
    found, hint = refusal(body)
    assert found == message
    assert hint


TISSUES = {
    "yield force = 1 N; yield viscosity = 1 N*s/m": 2,
    "viscosity = 1 N*s/m": 1,
}  # fmt: skip


@every(("tissue", "many"), TISSUES.items())
def test_what_is_of_springs_is_refused_of_a_tissue(tissue, many):
    with pytest.raises(CompileError) as caught:
        compile_request(scene(tissue=tissue))
    found = caught.value.diagnostics
    assert len(found) == many
    assert {one.code for one in found} == {"TIS306"}
    assert all("available for elements" in one.message for one in found)


SETTLED = "at 0 s: settle"
PRESTRESSED = "fibre modulus = 30 kPa; prestress = 10 %"


TUBE = """language 1
let steep = 35 deg
tissue wall { Young's modulus = 60 kPa; density = 1000 kg/m^3; fibre modulus = 100 kPa }
body tube {
  mesh is thick tube { axis from (0, 0, 0) mm to (0, 0, 4) mm; inner radius = 2 mm
    outer radius = 3 mm; rings = 3; sides = 12; layers = 1 }
  tissue is wall; fibres = FIBRES
}
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 ms }
"""


def test_the_angle_of_fibres_can_be_computed():
    def fibres(angle):
        text = TUBE.replace("FIBRES", angle)
        return compile_request(Request(Source("tube.tis", text)))[0].network.blocks[0].field

    expected = fibres("35 deg").fibres
    for angle in ("steep", "0.5 * 70 deg", "-(-steep)"):
        found = fibres(angle).fibres
        np.testing.assert_allclose(found.along, expected.along, atol=1e-15)
    _, warnings = compile_request(Request(Source("tube.tis", TUBE.replace("FIBRES", "-35"))))
    (found,) = (w for w in warnings if w.code == "W504")
    assert found.message == "without a unit, -35 is an angle in radians: 5.57 turns"
    assert found.hint == "write deg or rad after the number"


def test_prestress_goes_along_the_only_fibres_unless_something_else_is_written():
    fibred = "made of elements; fibres = (0, 3, 4)"
    scenes = {"tissue": PRESTRESSED, "script": SETTLED}
    found = elements(compiled(fibred, **scenes)).prestretch
    np.testing.assert_allclose(found.axis, (0.0, 0.6, 0.8))
    assert not found.is_across
    np.testing.assert_allclose(found.stretch, 1.0 / 0.9)
    found = elements(compiled(f"{fibred}; prestress across (0, 0, 2)", **scenes))
    np.testing.assert_allclose(found.prestretch.axis, (0.0, 0.0, 1.0))
    assert found.prestretch.is_across
    said, _ = refusal(f"{fibred}; second fibres = (1, 0, 0)", tissue=PRESTRESSED)
    assert "because it has two families of fibres" in said


def test_prestress_of_a_region_goes_before_that_of_the_tissue():
    body = "made of elements; prestress along (1, 0, 0); region top where z > 10 mm "
    scenes = {"tissue": "prestress = 5 %", "script": SETTLED}
    found = compiled(body + "{ prestress = 20 % }", **scenes)
    own = elements(found)
    height = found.network.position[own.nodes][..., 2].mean(axis=1)
    np.testing.assert_allclose(
        own.prestretch.stretch, 1.0 / np.where(height > 10e-3, 0.8, 0.95)
    )
    assert elements(compiled(tissue="prestress = 0 %")).prestretch is None
    # Half of the block may be without any.
    own = elements(compiled(body + "{ tissue is nut }", **scenes))
    assert set(own.prestretch.stretch) == {1.0, 1.0 / 0.95}


def test_check_warns_of_a_prestressed_block_that_is_held_out_of_balance():
    held = {"tissue": "prestress = 5 %", "body": "made of elements; prestress along (1, 0, 0)"}
    _, warnings = compile_request(scene(**held))
    assert "W309" in [w.code for w in warnings]
    (said,) = (w for w in warnings if w.code == "W309")
    assert "block is not in equilibrium at 0 s: prestress pulls" in said.message
    _, warnings = compile_request(scene(**held, script=SETTLED))
    assert "W309" not in [w.code for w in warnings]


def test_springs_have_no_direction_of_prestress():
    mesh = "kind is sodium chloride; reach is second neighbours"
    text = scene("prestress along (1, 0, 0)", mesh=mesh, tissue="retardation time = 1 ms")
    text = text.source.text.replace("Young's modulus = 10 kPa", "spring constant = 10 N/m")
    found = finding_of(compile_request, Request(Source("block.tis", text)))
    assert f"{found.code}: {found.message}" == (
        "TIS306: only a body of elements has a direction of prestress"
    )


@pytest.mark.parametrize("order", ["tighten block to 4 mm", "tie block with square knot"])
def test_edges_of_elements_are_no_joint_to_be_drawn_in(order):
    found = finding_of(compile_request, scene(script=f"at 0 s: {order}"))
    assert found.message == "block is neither a body with mesh thread nor a joint"


def test_what_is_of_springs_is_refused_of_a_mesh():
    assert refusal(mesh="kind is diamond") == (
        "TIS306: diamond says where springs are, but elements are the cubic cells",
        'write "kind is sodium chloride"',
    )
    assert refusal(mesh="reach is second neighbours")[0] == (
        'TIS306: "reach" of a mesh is not available for elements'
    )
    assert compiled(mesh="kind is sodium chloride").network.line_count == 300


def test_a_volume_is_preserved_by_the_elements_alone():
    found, _ = refusal(script="at 0 s: preserve volume of block with 10 kPa")
    assert "already resist changes of volume" in found
