"""A stress of the strain: what bars, walls and springs of matter resist with."""

import numpy as np
import pytest

import tissuec
from tests.matter.test_bodies import THREAD, text_of
from tests.validate.scenes import validated

AREA = np.pi * 1e-6  # of the thread, 2 mm thick
REST = 40e-3 / 32
OWN = 32  # springs that resist being drawn; the thread has one more, of its loop
DENSE = "density = 1060 kg/m^3; retardation time = 2 ms"
FUNG = "stress of strain = 2 kPa * (exp(10 * strain) - 1)"
CURVE = (
    "spring law is stress curve { strains = [-10 %, 0, 5 %, 10 %, 20 %]; "
    "stresses = [-4 kPa, 0 Pa, 3 kPa, 15 kPa, 70 kPa] }"
)
TOE = "Young's modulus = 5 kPa; spring law is toe { strain = 3 % }"


def net(tissue, mesh=THREAD, more=""):
    return tissuec.compile(text_of(mesh, tissue, more)).network


def pull(network, strain):
    """Return the tension of all springs at a strain [N]."""
    return network.springs.behaviour.pull(strain * network.springs.rest)[:OWN]


@pytest.mark.parametrize("strain", [-0.1, 0.0, 0.04, 0.3])
def test_a_bar_is_under_the_stress_that_is_written(strain):
    found = pull(net(f"{FUNG}; {DENSE}"), strain)
    assert found == pytest.approx(AREA * 2e3 * (np.exp(10.0 * strain) - 1.0), rel=1e-12)


def test_it_may_be_of_youngs_modulus_and_of_params():
    stress = "Young's modulus = 7 kPa; stress of e = Young's modulus * e + k*e^3"
    text = text_of(THREAD, f"{stress}; {DENSE}")
    text = text.replace("language 1\n", "language 1\nparam k = 20 kPa\n")
    found = pull(tissuec.compile(text).network, 0.2)
    assert found == pytest.approx(AREA * (7e3 * 0.2 + 20e3 * 0.008), rel=1e-12)


def test_a_straight_one_is_youngs_modulus():
    linear, straight = (
        net(f"{modulus}; {DENSE}")
        for modulus in ("Young's modulus = 5 kPa", "stress of e = 5 kPa * e")
    )
    assert np.array_equal(linear.springs.stiffness, straight.springs.stiffness)
    assert np.array_equal(linear.springs.damping, straight.springs.damping)
    assert pull(straight, 0.1) == pytest.approx(pull(linear, 0.1), rel=1e-14)


def test_the_slope_at_rest_is_youngs_modulus_where_none_is_written():
    given = tissuec.compile(text_of(THREAD, f"{FUNG}; {DENSE}")).scene.tissues["gel"].given
    assert given["young's modulus"].value == pytest.approx(20e3, rel=1e-14)
    written = net(f"{FUNG}; Young's modulus = 5 kPa; {DENSE}")
    assert pull(written, 0.2) == pytest.approx(pull(net(f"{FUNG}; {DENSE}"), 0.2), rel=1e-12)
    assert written.springs.damping[:OWN] == pytest.approx(2e-3 * 5e3 * AREA / REST, rel=1e-12)


def test_a_curve_goes_through_its_points():
    network = net(f"{CURVE}; {DENSE}")
    for strain, stress in ((-0.1, -4e3), (0.0, 0.0), (0.05, 3e3), (0.1, 15e3), (0.2, 70e3)):
        assert pull(network, strain) == pytest.approx(AREA * stress, rel=1e-12, abs=1e-15)


@pytest.mark.parametrize("law", [FUNG, TOE])
def test_strength_is_the_nominal_stress_that_breaks_a_bar(law):
    network = net(f"{law}; {DENSE}; strength = 30 kPa", more="rupture is allowed")
    assert network.springs.strength[:OWN] == pytest.approx(AREA * 30e3, rel=1e-12)


def test_a_tissue_like_one_of_springs_takes_its_stress_and_forgets_their_constant():
    text = text_of(THREAD, f"{FUNG}; {DENSE}").replace("tissue gel {", "tissue gel like net {")
    net_like = "tissue net { spring constant = 4 N/m; mass = 1 mg; viscosity = 1 mN*s/m }\n"
    found = tissuec.compile(text.replace("tissue gel", net_like + "tissue gel")).network
    assert pull(found, 0.1) == pytest.approx(AREA * 2e3 * (np.e - 1.0), rel=1e-12)


@pytest.mark.parametrize("law", [FUNG, CURVE])
def test_runs_keep_their_promise_and_the_reference_agrees(law):
    found = validated(
        text_of(
            THREAD, f"{law}; {DENSE}",
            sets="set left = nodes of piece where x < 1 mm\n"
            "set right = nodes of piece where x > 39 mm\ntool hook { kind is forceps }",
            script="script { at 0 s: { fix left; grasp right with hook }\n"
            "from 0 s to 10 ms: move hook by (6, 0, 0) mm using smooth profile }",
        ).replace("duration = 1 ms", "duration = 12 ms; tolerance = 1e-6")
        + "output { trajectory every 1 ms }\n"
    )  # fmt: skip
    assert found.verdict == "kept"
