"""Bars whose tissue has a law of solids follow its curve in uniaxial tension."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import tissuec
from tests.validate.scenes import compiled_scene, quantity, validated
from tests.whole_runs import carried_out
from tissuec.core.errors import CompileError
from tissuec.validate.forces.laws import spring_rule

SCENE = """language 1
tissue tendon {{ {tissue} }}
body cord {{
  mesh is thread {{ line from (0, 0, 0) mm to (50, 0, 0) mm; pieces = 10; thickness = 2 mm }}
  tissue is tendon
}}
set left = nodes of cord where x < 0.1 mm
set right = nodes of cord where x > 49.9 mm
environment {{ gravity = (0, 0, 0) m/s^2; contact is off }}
script {{
  at 0 s: fix left
  from 0 s to 50 ms: move right by (15, 0, 0) mm using smooth profile
}}
simulate {{ duration = 60 ms; tolerance = 1e-6 }}
output {{ force of right every 5 ms; energy every 5 ms }}
"""
MATTER = "Young's modulus = 60 kPa; density = 1100 kg/m^3; retardation time = 1 ms"
YOUNG, SECTION = 60e3, np.pi * 1e-6  # [Pa], [m²]


def of_first(slope):
    """Return the stress of a law of I1 alone, from its slope."""
    return lambda x: 2.0 * (x - x**-2) * slope(x * x + 2.0 / x - 3.0)


def powers(*terms):
    """Return the stress Σ 2 s/a (λ^(a - 1) - λ^(-a/2 - 1)) of pairs s, a."""
    return lambda x: sum(
        2.0 * s / a * (x ** (a - 1.0) - x ** (-0.5 * a - 1.0)) for s, a in terms
    )


#: Nominal stress by the stretch, in units of the shear modulus.
LAWS = {
    "neo hookean": lambda x: x - x**-2,
    "mooney rivlin { share = 0.3 }": lambda x: (x - x**-2) * (0.7 + 0.3 / x),
    "yeoh { second = 0.5; third = 0.2 }": of_first(lambda z: 0.5 * (1.0 + z + 0.6 * z * z)),
    "exponential { stiffening = 0.7 }": of_first(lambda z: 0.5 * np.exp(0.7 * z)),
    "veronda westmann { stiffening = 0.4 }": lambda x: (
        2.0 * (x - x**-2) * (np.exp(0.4 * (x * x + 2.0 / x - 3.0)) - 0.5 / x)
    ),
    "ogden { exponent = 5; second exponent = -3; second share = 0.3 }":
        powers((0.7, 5.0), (0.3, -3.0)),
    "hencky": lambda x: 3.0 * np.log(x) / x,
}  # fmt: skip
STRETCHES = np.array([0.4, 0.8, 0.99, 1.0, 1.001, 1.3, 2.0, 3.5])


def text(law, tissue=MATTER):
    return SCENE.format(tissue=f"{tissue}; solid law is {law}")


def pulled(law, stretch):
    """Return the force of each piece of a cord that is stretched evenly [N]."""
    springs = compiled_scene(text(law)).network.springs
    return springs.behaviour.pull((stretch - 1.0) * springs.rest)[:10]


@pytest.mark.parametrize("law", LAWS)
def test_a_bar_follows_the_law_of_its_solid(law):
    for stretch in STRETCHES:
        expected = SECTION * YOUNG / 3.0 * LAWS[law](stretch)
        np.testing.assert_allclose(pulled(law, stretch), expected, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("law", LAWS)
def test_it_is_that_of_one_element_whose_sides_are_free(law):
    body = """mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (5, 5, 5) mm }
  tissue is gel"""
    tissue = f"{MATTER}; Poisson's ratio = 0.4999; solid law is {law}"
    solid = f"""language 1
tissue gel {{ {tissue} }}
body cube {{ {body} }}
environment {{ gravity = (0, 0, 0) m/s^2 }}
simulate {{ duration = 1 ms }}
"""
    network = compiled_scene(solid).network
    (field,), drawn = network.of_kind("elements"), network.position

    def least(along):
        return minimize_scalar(
            lambda across: float(field.energy(0.0, drawn * [along, across, across])),
            bounds=(0.3, 1.5), method="bounded", options={"xatol": 1e-12},
        ).fun  # fmt: skip

    step, volume = 1e-4, float(field.volume.sum())
    stress = (least(1.4 + step) - least(1.4 - step)) / (2.0 * step * volume)
    assert pulled(law, 1.4)[0] / SECTION == pytest.approx(stress, rel=5e-4)


@pytest.mark.parametrize("law", LAWS)
def test_a_run_pulls_with_that_force(law):
    _, recording = carried_out(compiled_scene(text(law)))
    time, force = recording.log_arrays("force of right")
    expected = SECTION * YOUNG / 3.0 * LAWS[law](1.3)
    assert abs(force[-1, 0]) == pytest.approx(expected, rel=5e-3)
    assert time[-1] == pytest.approx(0.06)


@pytest.mark.parametrize("law", LAWS)
def test_the_rule_of_the_reference_is_its_own(law):
    springs = compiled_scene(text(law)).network.springs
    c, rest = np.full(8, 3.0), np.full(8, 0.2)
    bar = next(one for one in springs.laws if one.spring is not None and one.name != "linear")
    rule, e = spring_rule(bar), 0.2 * (STRETCHES - 1.0)
    stress = 0.2 * LAWS[law](STRETCHES)  # c L0 / E times E/3
    np.testing.assert_allclose(rule.force(e, c, rest), stress, rtol=1e-12, atol=1e-15)
    by_difference = (rule.force(e + 1e-7, c, rest) - rule.force(e - 1e-7, c, rest)) / 2e-7
    np.testing.assert_allclose(rule.slope(e, c, rest), by_difference, rtol=1e-6)
    rise = (rule.energy(e + 1e-6, c, rest) - rule.energy(e - 1e-6, c, rest)) / 2e-6
    np.testing.assert_allclose(rise, stress, rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize(
    "law",
    ["veronda westmann { stiffening = 0.4 }", pytest.param("hencky", marks=pytest.mark.slow)],
)
def test_the_reference_agrees_by_formulas_of_its_own(law):
    found = validated(text(law))
    assert found.verdict == "kept"
    assert quantity(found, "position").error < 1e-6
    assert quantity(found, "energy balance").error < 1e-6


def test_springs_of_a_table_with_a_section_are_bars():
    table = """body cord { mesh is explicit; tissue is tendon; section = 2 mm^2 }
table nodes of cord in mm with columns "id x" { 1 0; 2 50 }
table springs of cord with columns "a b" { 1 2 }
"""
    given = text("yeoh { second = 2 }")
    start, end = given.index("body"), given.index("set left")
    scene = tissuec.compile(given[:start] + table + given[end:])
    springs = scene.network.springs
    z = 1.3**2 + 2.0 / 1.3 - 3.0
    expected = 2e-6 * YOUNG / 3.0 * (1.3 - 1.3**-2) * (1.0 + 4.0 * z)
    assert springs.behaviour.pull(0.3 * springs.rest) == pytest.approx([expected])


REFUSED = {
    "spring constant = 1 N/m; viscosity = 1 N*s/m; mass = 1 g": (
        "a solid law has no effect on springs, of which cord consists",
        "write a Young's modulus and a density in the tissue, or remove it from the tissue",
    ),
    f"{MATTER}; spring law is tension only": (
        "a solid law and a spring law exclude each other", "remove one of them",
    ),
}  # fmt: skip


@pytest.mark.parametrize("tissue", REFUSED)
def test_mistakes_are_refused(tissue):
    with pytest.raises(CompileError) as caught:
        compiled_scene(text("hencky", tissue))
    message, hint = REFUSED[tissue]
    (found,) = [one for one in caught.value.diagnostics if one.message == message]
    assert found.code == "TIS306"
    assert hint in str(found.hint)
