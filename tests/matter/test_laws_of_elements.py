"""Tissues as elements: laws of solids, curves of stress, and what is refused."""

import h5py
import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import tissuec
from tests.every import every
from tests.validate.scenes import compiled_scene
from tissuec.core.errors import CompileError
from tissuec.mechanics.deformation import six

BAR = """language 1
tissue liver {{ Young's modulus = 10 kPa; density = 1000 kg/m^3; {law} }}
body bar {{
  made of elements
  mesh is lattice {{ cell = 5 mm; box from (0, 0, 0) mm to ({long}, 5, 5) mm{more} }}
  tissue is liver
}}
set left = nodes of bar where x < 0.1 mm
set right = nodes of bar where x > {long} mm - 0.1 mm
script {{
  at 0 s: fix left
  from 0 s to 20 ms: move right by (1, 0, 0) mm using smooth profile
}}
environment {{ gravity = (0, 0, 0) m/s^2 }}
simulate {{ duration = 30 ms }}
output {{ trajectory every 10 ms; blocks }}
"""
MODULUS = 10e3  # [Pa]


def scene(law, *, long=5, more=""):
    return BAR.format(law=law, long=long, more=more)


def elements(text):
    """Return the elements of a scene, and where all nodes are drawn."""
    network = compiled_scene(text).network
    (field,) = (block.field for block in network.blocks if block.kind == "elements")
    return field, network.position


def tension(text, stretch):
    """Return the nominal stress of one free element that is stretched along x [Pa]."""
    field, drawn = elements(text)
    volume = float(field.volume.sum())

    def energy(along, across):
        return float(field.energy(0.0, drawn * np.array([along, across, across])))

    def least(along):
        found = minimize_scalar(
            lambda across: energy(along, across), bounds=(0.3, 1.5), method="bounded",
            options={"xatol": 1e-12},
        )  # fmt: skip
        return found.fun

    step = 1e-4
    return (least(stretch + step) - least(stretch - step)) / (2.0 * step * volume)


@pytest.mark.parametrize("stretch", [1.05, 1.15, 1.3])
def test_a_curve_of_stress_is_followed_in_tension(stretch):
    text = scene("stress of strain = 10 kPa / 8 * (exp(8 * strain) - 1)")
    expected = MODULUS / 8.0 * np.expm1(8.0 * (stretch - 1.0))
    # 1 % is what the documentation says; the stress along the curve grows to 12 times.
    assert tension(text, stretch) == pytest.approx(expected, rel=0.01)


def test_a_solid_law_is_that_of_the_tissue():
    ratio, stretch = 0.499, 1.3
    text = scene(
        f"Poisson's ratio = {ratio}; solid law is yeoh {{ second = 0.6; third = 1.8 }}"
    )
    z = stretch**2 + 2.0 / stretch - 3.0
    slope = 0.5 + 0.6 * z + 1.5 * 1.8 * z**2
    shear = MODULUS / (2.0 * (1.0 + ratio))
    expected = 2.0 * shear * slope * (stretch - stretch**-2)
    # The change of volume is σ/3K, which is 0.3 % here.
    assert tension(text, stretch) == pytest.approx(expected, rel=0.01)


def test_a_law_of_ogden_is_followed_in_tension():
    """σ = Σ 2 μ s/a (λ^(a - 1) - λ^(-1 - a/2)) where the volume hardly changes."""
    ratio, stretch = 0.4999, 1.4
    text = scene(
        f"Poisson's ratio = {ratio}; solid law is ogden {{ exponent = 9; "
        "second exponent = -2; second share = 0.3 }"
    )
    shear = MODULUS / (2.0 * (1.0 + ratio))
    expected = sum(
        2.0 * shear * share / a * (stretch ** (a - 1.0) - stretch ** (-1.0 - 0.5 * a))
        for share, a in ((0.7, 9.0), (0.3, -2.0))
    )
    assert tension(text, stretch) == pytest.approx(expected, rel=2e-3)


def test_parts_of_a_body_have_laws_of_their_own():
    text = scene("Poisson's ratio = 0.4", long=20).replace(
        "  tissue is liver\n",
        "  tissue is liver\n  region tip where x > 10.1 mm { tissue is scar }\n",
    )
    text = text.replace("body bar", "tissue scar like liver { solid law is exponential "
                        "{ stiffening = 5 } }\nbody bar")  # fmt: skip
    field, _ = elements(text)
    assert [type(law).__name__ for law in field.laws][1:] == ["NeoHookean", "SolidExponential"]
    assert set(field.law.tolist()) == {0, 2}


def fibred(law, *, more="fibres = (1, 0, 0)"):
    return scene(law).replace("  tissue is liver\n", f"  tissue is liver; {more}\n")


@pytest.mark.parametrize("spread", ["", "; fibre dispersion = 0.2"])
def test_along_fibres_there_is_the_fibre_modulus(spread):
    text = fibred(f"Poisson's ratio = 0.3; fibre modulus = 50 kPa{spread}")
    field, drawn = elements(text)
    part = 1e-5
    volume = float(field.volume.sum())

    def energy(along, ratio):
        widths = 1.0 - ratio * along
        return float(field.energy(0.0, drawn * np.array([1.0 + along, widths, widths])))

    least = minimize_scalar(
        lambda ratio: energy(part, ratio), bounds=(0.0, 0.6), method="bounded",
        options={"xatol": 1e-10},
    )  # fmt: skip
    assert 2.0 * least.fun / (volume * part**2) == pytest.approx(50e3, rel=2e-3)


def test_stiffening_fibres_follow_their_exponential():
    text = fibred("Poisson's ratio = 0.4; fibre modulus = 50 kPa; fibre stiffening = 3",
                  more="fibres = (1, 1, 0); second fibres = (1, -1, 0)")  # fmt: skip
    field, drawn = elements(text)
    bare, _ = elements(scene("Poisson's ratio = 0.4"))
    stretched = drawn * np.array([1.2, 1.0, 1.0])
    e = 0.5 * (1.2**2 + 1.0) - 1.0  # of both families
    k1 = 0.25 * 40e3
    expected = 2.0 * k1 / 6.0 * np.expm1(3.0 * e * e) * float(field.volume.sum())
    added = float(field.energy(0.0, stretched) - bare.energy(0.0, stretched))
    assert added == pytest.approx(expected, rel=1e-12)


@every(
    ("text", "said"),
    [
        (
            fibred("Poisson's ratio = 0.3; fibre stiffening = 3", more="mass = 1 g"),
            "a fibre stiffening needs a fibre modulus",
        ),
        (fibred("fibre modulus = 50 kPa", more="mass = 1 g"), 'bar needs "fibres"'),
        (fibred("Poisson's ratio = 0.3"), "fibres of bar have no effect"),
        (fibred("fibre modulus = 5 kPa"), "the fibre modulus is less than Young's modulus"),
        (fibred("fibre modulus = 50 kPa", more="fibres is axial"), "only a tube can"),
        (fibred("fibre modulus = 50 kPa; fibre dispersion = 0.32"), "at most 0.3"),
        (
            scene("stress of strain = 10 kPa * strain; solid law is neo hookean"),
            "a solid law and a curve of stress exclude each other",
        ),
        (scene("spring law is toe { strain = 3 % }"), "a spring law is not available"),
        (scene("solid law is yeoh"), 'solid law yeoh needs "second"'),
        (scene("solid law is ogden { exponent = 0.001 }"), "the limit of 0 is the law hencky"),
        (
            scene("solid law is ogden { exponent = 2; second share = 0.6; third share = 0.6 }"),
            '"second share" and "third share" are more than 1 together',
        ),
        (scene("solid law is rubber"), 'there is no solid law called "rubber"'),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused(text, said):
    with pytest.raises(CompileError) as caught:
        compiled_scene(text)
    assert said in str(caught.value)


def test_stress_of_elements_is_in_blocks(tmp_path):
    text = scene("Poisson's ratio = 0.4; retardation time = 1 ms", long=10)
    result = tissuec.run(text, out=tmp_path / "bar.vtkhdf", companion="off")
    field, _ = elements(text)
    total, volume = field.node_stress(result.position[-1])
    with h5py.File(tmp_path / "bar.blocks.vtkhdf") as file:
        stress = file["VTKHDF/bar_solid/PointData/stress"][-len(total) :]
    np.testing.assert_allclose(
        stress, six(total / volume[:, None, None]), atol=1e-5 * np.abs(stress).max()
    )  # the file is in single precision
