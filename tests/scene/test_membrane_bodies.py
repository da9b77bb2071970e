"""Walls of finite elements: what their triangles are made of, runs, and what is refused."""

from unittest.mock import Mock

import numpy as np
import pytest
from click.testing import CliRunner

from tests.every import every
from tests.whole_runs import carried_out, same_on_threads
from tissuec.analysis.bodies import properties_of
from tissuec.cli import group
from tissuec.compiler.compile import Compiled
from tissuec.compiler.script.initial_state import state_at_start
from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.engine.threads import parts_of
from tissuec.forces.enclosed.volume import Enclosure
from tissuec.forces.surfaces.membranes import Membranes
from tissuec.forces.surfaces.plates import Plates
from tissuec.mechanics.settling import settle
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request
from tissuec.validate.validation import validate

SHEET = (
    "sheet {{ corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm; second edge = (0, 10, 0) mm; "
    "columns = 9; rows = 5 {mesh} }}"
)
TUBE = (
    "tube {{ axis from (0, 0, 0) mm to (40, 0, 0) mm; radius = 5 mm; rings = 9; sides = 12 "
    "{mesh} }}"
)
SPHERE = "sphere {{ centre = (0, 0, 0) mm; radius = 10 mm; subdivisions = 2 {mesh} }}"
SCENE = """\
language 1
tissue skin {{ Young's modulus = 100 kPa; density = 1000 kg/m^3; {tissue} }}
tissue scar {{ Young's modulus = 400 kPa; Poisson's ratio = 0.4; density = 2000 kg/m^3 }}
body wall {{
  mesh is {kind}
  tissue is skin
  {body}
}}
environment {{ gravity = (0, 0, {gravity}) m/s^2 }}
{script}
simulate {{ duration = {duration} }}
"""
MADE = "made of elements; thickness = 2 mm"


def scene(
    body=MADE, *, tissue="", kind=SHEET, mesh="", script="", duration="1 ms", gravity=0, more=""
):
    text = SCENE.format(
        body=body, tissue=tissue, kind=kind.format(mesh=mesh), script=script,
        duration=duration, gravity=gravity,
    )  # fmt: skip
    return Request(Source("wall.tis", text + more))


def compiled(body=MADE, **parts) -> Compiled:
    found, warnings = compile_request(scene(body, **parts))
    assert not [w for w in warnings if w.code not in ("W502", "W401", "W417")]
    return found


def triangles(of: Compiled) -> Membranes:
    (found,) = of.network.of_kind("membranes")
    return found


def refusals(body=MADE, **parts) -> list[tuple[str, str]]:
    with pytest.raises(CompileError) as caught:
        compile_request(scene(body, **parts))
    return [(f"{one.code}: {one.message}", one.hint) for one in caught.value.diagnostics]


def test_moduli_and_masses_follow_from_the_tissue():
    found = compiled(tissue="Poisson's ratio = 0.3; retardation time = 2 ms")
    own = triangles(found)
    assert own.item_count == 64
    np.testing.assert_allclose(own.shear, 100e3 / 2.6, rtol=1e-12)
    np.testing.assert_allclose(own.bulk, 100e3 / 1.2, rtol=1e-12)
    np.testing.assert_allclose(own.viscosity, 2e-3 * 100e3 / 2.6, rtol=1e-12)
    assert own.weight.sum() == pytest.approx(20e-3 * 10e-3 * 2e-3, rel=1e-12)
    assert found.network.mass.sum() == pytest.approx(0.4e-3, rel=1e-12)
    assert not found.network.springs.stiffness.any()
    assert str(found.network.size) == "45 nodes, 64 elements"


def test_a_ratio_is_that_of_solids_unless_it_is_written():
    np.testing.assert_allclose(triangles(compiled()).thinning, -1.0 / 3.0, rtol=1e-12)
    curve = "stress of strain = 100 kPa * strain * (1 + 5 * strain)"
    own = triangles(compiled(tissue=curve))
    ratio = (3.0 * own.bulk - 2.0 * own.shear) / (6.0 * own.bulk + 2.0 * own.shear)
    np.testing.assert_allclose(ratio, 0.4997, rtol=1e-9)


def test_regions_go_by_the_centres_of_triangles():
    body = MADE + "; region old where x > 10 mm { tissue is scar }"
    found = compiled(body)
    own = triangles(found)
    place = found.network.position[own.nodes][..., 0].mean(axis=1)
    np.testing.assert_allclose(own.shear, np.where(place > 0.01, 400e3 / 2.8, 100e3 / 2.5))
    assert found.network.mass.sum() == pytest.approx(0.6e-3, rel=1e-12)


@pytest.mark.parametrize("kind", [SHEET, TUBE, SPHERE], ids=["sheet", "tube", "sphere"])
def test_fibres_lie_in_the_wall(kind):
    tissue = "fibre modulus = 300 kPa; fibre stiffening = 2"
    own = triangles(compiled(MADE + "; fibres = (1, 0, 0)", kind=kind, tissue=tissue))
    np.testing.assert_allclose(np.linalg.norm(own.fibres.along, axis=2), 1.0, rtol=1e-12)
    np.testing.assert_allclose(own.fibres.stiffness, 50e3, rtol=1e-12)


def test_fibres_across_a_wall_are_refused():
    tissue = "fibre modulus = 300 kPa"
    (found, hint), *_ = refusals(MADE + "; fibres = (0.05, 0, 1)", tissue=tissue)
    assert found == (
        "TIS309: wall cannot have this direction of fibres: it is perpendicular to the wall"
    )
    assert "within the wall" in hint


def test_fibres_of_a_tube_run_along_it_and_around_it():
    tissue = "fibre modulus = 300 kPa"
    body = MADE + "; fibres is circumferential; second fibres is axial"
    found = compiled(body, kind=TUBE, tissue=tissue)
    own, x = triangles(found), found.network.position

    # A tube that is longer stretches the second family only, and one that is wider the first.
    def strains(position):
        along = np.einsum("eqxk,efk->efx", own.deformations(position), own.fibres.along)
        return (along**2).sum(axis=-1) - 1.0

    longer = strains(x * [1.1, 1.0, 1.0])
    np.testing.assert_allclose(longer, np.tile([0.0, 0.21], (len(longer), 1)), atol=1e-12)
    wider = strains(x * [1.0, 1.1, 1.1])
    np.testing.assert_allclose(wider, np.tile([0.21, 0.0], (len(wider), 1)), atol=1e-12)


def test_prestress_is_tension_in_the_plane():
    script = "script { at 0 s: fix wall }"
    found = compiled(tissue="prestress = 10 %; Poisson's ratio = 0.3", script=script)
    own = triangles(found)
    stress, volume = own.node_stress(found.network.position)
    plane = (stress / volume[:, None, None])[:, :2, :2]
    assert np.allclose(plane, plane[0, 0, 0] * np.eye(2), atol=1e-9 * plane.max())
    # σ = E ε / (1 - ν) in small strain.
    assert plane[0, 0, 0] == pytest.approx(100e3 * 0.111 / 0.7, rel=0.2)
    part = MADE + "; region tight where x > 10 mm { prestress = 5 % }"
    tight = triangles(compiled(part))
    assert 0.4 < (tight.weight < 0.999 * tight.weight.max()).mean() < 0.6
    loose = triangles(compiled(tissue="prestress = -10 %"))
    assert loose.node_stress(found.network.position)[0][0, 0, 0] < 0.0


def test_prestress_along_a_direction():
    body, tissue = (
        MADE + "; prestress along (1, 0, 0)",
        "prestress = 10 %; Poisson's ratio = 0.49",
    )
    found = compiled(body, tissue=tissue)
    stress, volume = triangles(found).node_stress(found.network.position)
    first = (stress / volume[:, None, None])[0]
    assert first[0, 0] == pytest.approx(100e3 / 2.98 * (0.9**-2 - 0.9), rel=0.02)
    assert abs(first[1, 1]) < 0.02 * first[0, 0]
    across = MADE + "; prestress across (0, 0, 1)"
    assert "needs no plane" in refusals(across, tissue=tissue)[0][0]
    upright = MADE + "; prestress along (0, 0, 1)"
    assert "perpendicular to the wall" in refusals(upright, tissue=tissue)[0][0]
    assert "has no effect" in refusals(body)[0][0]


# --- bending ----------------------------------------------------------------------------------


def bending(of: Compiled) -> list[Plates]:
    return list(of.network.of_kind("plates"))


@pytest.mark.parametrize("ratio", [0.0, 0.3, 0.45])
def test_a_sheet_resists_rolling_as_a_plate(ratio):
    found = compiled(tissue=f"Poisson's ratio = {ratio}; retardation time = 3 ms")
    (plates,), x = bending(found), found.network.position
    rigidity, radius = 100e3 * 2e-3**3 / (12.0 * (1.0 - ratio**2)), 1.0
    inner = plates.only(np.flatnonzero(plates.is_hinge.all(axis=1)))
    area = 20e-3 * 10e-3 * inner.item_count / plates.item_count
    for axis in (0, 1):
        rolled = x.copy()
        rolled[:, axis] = radius * np.sin(x[:, axis] / radius)
        rolled[:, 2] = radius * (1.0 - np.cos(x[:, axis] / radius))
        assert inner.energy(0.0, rolled) == pytest.approx(
            0.5 * rigidity / radius**2 * area, rel=1e-3
        )
    np.testing.assert_allclose(plates.delay, 3e-3, rtol=1e-12)


def test_bending_can_be_left_out():
    assert len(bending(compiled())) == 1
    assert len(bending(compiled(MADE + "; bending is elastic"))) == 1
    assert not bending(compiled(MADE + "; bending is none"))
    found, hint = refusals(MADE + "; bending is soft")[0]
    assert found == "TIS306: bending by springs is not available for elements"
    assert hint


def test_a_strip_that_hangs_over_an_edge_sags_as_a_beam():
    # q l⁴ / 8 E I of a cantilever that is free behind the middle between two held rows; less,
    # as near these it cannot bend across, and more than where it nowhere can.
    script = """\
set root = nodes of wall where x < 2.6 mm
script { at 0 s: { fix root; settle } }
"""
    found = compiled(tissue="Poisson's ratio = 0.3", script=script, gravity=-0.1)
    outcome, _ = carried_out(found)
    (state,) = [outcome.state]
    sag = -(state.position - found.network.position)[:, 2].min()
    length, weight = 20e-3 - 1.25e-3, 1000.0 * 2e-3 * 0.1
    beam = weight * length**4 / (8.0 * 100e3 * 2e-3**3 / 12.0)
    assert (1.0 - 0.3**2) * beam < sag < beam


# --- runs -------------------------------------------------------------------------------------


def test_a_pulled_strip_resists_as_its_tissue_does():
    script = """\
set low = nodes of wall where x < 0.1 mm
set high = nodes of wall where x > 19.9 mm
script { at 0 s: fix low; from 0 s to 0.1 s: move high by (0.2, 0, 0) mm using smooth profile }
"""
    # Clamped ends cannot become narrower: a little more than E A ε = 20 mN.
    more = "expect force(high along (1, 0, 0)) between 20 mN and 20.6 mN at 0.12 s\n"
    outcome, _ = carried_out(
        compiled(tissue="Poisson's ratio = 0.3; retardation time = 10 ms", script=script,
                 duration="0.12 s", more=more)
    )  # fmt: skip
    assert not (outcome.failures or outcome.unreached)


def test_a_cut_takes_triangles_with_it():
    script = """\
script { at 0.1 ms: cut wall along plane through (11, 0, 0) mm facing (1, 0, 0) }
"""
    outcome, _ = carried_out(compiled(script=script, more="expect pieces(wall) == 2 at 1 ms\n"))
    assert not (outcome.failures or outcome.unreached)


#: Ratios of the stiffness of the law to that of a neo-Hookean wall at a stretch.
BALLOONS = {
    "": lambda stretch: 1.0,
    "solid law is mooney rivlin { share = 20 % }": lambda stretch: 0.8 + 0.2 * stretch**2,
}


@pytest.mark.parametrize("law", BALLOONS, ids=["neo-Hookean", "Mooney-Rivlin"])
def test_a_balloon_passes_its_greatest_pressure(law):
    # p = 2 μ H/R (λ⁻¹ - λ⁻⁷) of a thin neo-Hookean balloon, the greatest at 7^(1/6) (A. E.
    # Green, J. E. Adkins, Large Elastic Deformations, 1960).
    found = compiled(
        "made of elements; thickness = 0.1 mm", kind=SPHERE,
        tissue=f"Poisson's ratio = 0.4997; {law}",
    )  # fmt: skip
    own, body = triangles(found), found.network.bodies[0]
    shear = float(own.shear[0])
    radius = np.sqrt(own.weight.sum() / 0.1e-3 / (4.0 * np.pi))
    full = Enclosure.of(found.network, "wall", 30e6, body.span)
    pressures = []
    state = state_at_start(found)
    for stretch in (1.1, 7.0 ** (1.0 / 6.0), 1.6, 2.0):
        kept = full.swollen(stretch**3 - 1.0, full_at_once())
        state.put(kept.block)
        settle(state, np.ones(len(state.position), dtype=bool))
        grown = float(kept.volumes(state.position)[0] / full.drawn[0]) ** (1.0 / 3.0)
        pressures.append(float(kept.pressures(0.0, state.position)[0]))
        closed = 2.0 * shear * 0.1e-3 / radius * (1.0 / grown - grown**-7)
        assert pressures[-1] == pytest.approx(closed * BALLOONS[law](grown), rel=6e-3)
    assert law or pressures[1] == max(pressures)


def full_at_once():
    from tissuec.model.profiles import TimeProfile

    return TimeProfile("constant", 0.0, np.inf)


def test_properties_of_a_wall_are_those_of_its_tissue():
    found = compiled(tissue="Poisson's ratio = 0.3; retardation time = 2 ms")
    (wall,) = properties_of(found)
    assert wall.kind == "wall"
    assert wall.elasticity is not None
    assert wall.elasticity.young == pytest.approx((100e3,) * 2)
    assert wall.elasticity.poisson == pytest.approx(0.3)
    assert wall.elasticity.shear == pytest.approx((100e3 / 2.6,))
    assert wall.retardation_time == pytest.approx(2e-3)
    assert wall.volume == pytest.approx(0.4e-6)
    assert len(wall.vibrations) == 3


def test_check_counts_triangles(tmp_path):
    (tmp_path / "wall.tis").write_text(scene().source.text, encoding="utf-8")
    said = CliRunner().invoke(group, ["check", str(tmp_path / "wall.tis")])
    assert "(45 nodes, 64 elements)" in said.output


CLOTH = """language 1
tissue cloth { Young's modulus = 30 kPa; density = 1 g/cm^3; retardation time = 1 ms }
body wall {
  mesh is sheet {
    corner = (0, 0, 0) cm; first edge = (35, 0, 0) cm; second edge = (0, 35, 0) cm
    columns = 48; rows = 48
  }
  tissue is cloth; thickness = 2 mm; made of elements
}
set rim = nodes of wall where x < 1 mm
set tip = nodes of wall where x > 349 mm
environment { gravity = (0, 0, -9.81) m/s^2; contact is off }
script { at 0 s: { fix rim; push tip with (0, 0, 1) N } }
simulate { duration = 0.4 ms; step = 20 us; integrator is velocity verlet }
output { trajectory every 0.2 ms; energy every 0.2 ms }
"""


def test_threads_share_triangles_and_change_no_bit(threads_in_small_nets):
    found = same_on_threads(CLOTH, 5)
    assert np.ptp(found.position[:], axis=0).max() > 1e-7
    network = compile_request(Request(Source("cloth.tis", CLOTH)))[0].network
    for field in network.of_kind("membranes", "plates"):
        groups = parts_of(field, np.arange(network.node_count))
        assert max(map(len, groups)) >= 2
        assert sum(part.item_count for group in groups for part in group) == field.item_count


def test_a_run_is_that_of_the_reference():
    script = """\
set low = nodes of wall where x < 0.1 mm
set high = nodes of wall where x > 19.9 mm
script { at 0 s: fix low; from 0 s to 4 ms: move high by (1, 0, 1) mm using smooth profile }
output { stress of high every 1 ms; force of high every 1 ms; energy every 1 ms }
"""
    tissue = "retardation time = 0.1 ms; Poisson's ratio = 0.45"
    found = compiled(script=script, duration="4 ms", tissue=tissue)
    report = validate(found, method="DOP853", rtol=None, progress=Mock())
    assert report.verdict == "kept", report.reasons


# --- mistakes ---------------------------------------------------------------------------------

MISTAKES = {
    ("made of elements", SHEET, ""):
        'TIS304: wall needs "thickness": the thickness of its wall',
    (MADE + "; section = 1 mm^2", SHEET, ""):
        'TIS306: a body of elements cannot have "section"',
    (MADE + "; interface is softer", SHEET, ""):
        'TIS306: "interface" is not available for elements',
    (MADE, SHEET, "; diagonals is both"):
        'TIS306: "diagonals" of a mesh is not available for elements',
    (MADE, SHEET, "; second neighbours is yes"):
        'TIS306: "second neighbours" of a mesh is not available for elements',
    (MADE, TUBE, "; interior is crossed"):
        'TIS306: "interior" of a mesh is not available for elements',
    (MADE, SPHERE, "; interior is spokes"):
        'TIS306: "interior" of a mesh is not available for elements',
    (MADE + "; fibres is axial", SHEET, ""):
        "TIS306: fibres of wall have no effect: its tissue has no fibre modulus",
}  # fmt: skip


@every(("parts", "message"), MISTAKES.items())
def test_what_walls_of_elements_do_not_have_is_refused(parts, message):
    body, kind, mesh = parts
    (found, hint), *_ = refusals(body, kind=kind, mesh=mesh)
    assert found == message
    assert hint


def test_what_says_nothing_is_allowed():
    assert compiled(kind=SHEET, mesh="; diagonals is none").network.line_count == 108


def test_a_thread_cannot_consist_of_elements():
    kind = "thread {{ line from (0, 0, 0) mm to (9, 0, 0) mm; pieces = 2; thickness = 1 mm }}"
    (found, hint), *_ = refusals("made of elements", kind=kind)
    assert "neither a solid nor a wall" in found
    assert "made of elements" in hint


def test_only_a_tube_has_axial_fibres():
    (found, _), *_ = refusals(MADE + "; fibres is axial", tissue="fibre modulus = 300 kPa")
    assert found == "TIS309: wall cannot have axial fibres: only a tube can"
