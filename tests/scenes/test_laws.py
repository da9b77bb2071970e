"""Laws in scenes: read with their units, joined over regions, explained, and refused."""

import numpy as np
import pytest

from tests.every import every
from tests.findings import finding_of
from tissuec.core.source import Source
from tissuec.laws import LINEAR
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

FRAME = """language 1
tissue plain {{ spring constant = 20 N/m; viscosity = 10 mN*s/m; mass = 1 g }}
{tissues}
body rod {{ mesh is explicit; tissue is {tissue}; {body} }}
table nodes of rod in mm with columns "id x y z" {{
  0 0 0 0; 1 {first} 0 0; 2 20 0 0; 3 30 0 0
}}
table springs of rod with columns "a b" {{ 0 1; 1 2; 2 3 }}
environment {{ gravity = (0, 0, 0) m/s^2 }}
simulate {{ duration = 1 s }}
"""


def compiled(tissues, *, tissue="special", body="", first=10):
    text = FRAME.format(tissues=tissues, tissue=tissue, body=body, first=first)
    return compile_request(Request(Source("scene.tis", text)))[0].network


def refused(tissues, **more):
    return finding_of(compiled, tissues, **more)


def test_a_formula_says_what_the_law_of_that_name_does():
    named = compiled(
        "tissue special like plain { spring law is exponential { stiffening = 8 } }"
    )
    freely = compiled(
        "tissue special like plain { spring force of stretch = "
        "spring constant * rest length / 8 * (exp(8 * stretch / rest length) - 1) }"
    )
    e = np.linspace(-0.004, 0.009, 3)
    assert freely.springs.behaviour.pull(e) == pytest.approx(
        named.springs.behaviour.pull(e), rel=1e-13
    )
    assert freely.springs.behaviour.slope(e) == pytest.approx(
        named.springs.behaviour.slope(e), rel=1e-13
    )


def test_formulas_use_params_and_units_and_both_laws_stand_side_by_side():
    net = compiled(
        "param b = 40 kN/m^3\n"
        "tissue special like plain { spring force of e = c*e + b*e^3\n"
        "viscous force of v = d * v * max(abs(v) / (1 mm/s), 1) }"
    )
    behaviour = net.springs.behaviour
    assert behaviour.pull(np.full(3, 0.01)) == pytest.approx(20 * 0.01 + 40e3 * 1e-6)
    none = np.zeros(3)
    assert behaviour.brake(none, np.full(3, 2e-3)) == pytest.approx(0.01 * 2e-3 * 2.0)
    assert behaviour.brake(none, np.full(3, 5e-4)) == pytest.approx(0.01 * 5e-4)


@pytest.mark.parametrize(
    "head", ["viscous force of e and w", "viscous force of stretch and rate"]
)
def test_a_viscous_force_of_elongation_and_speed(head):
    e, w = head.split()[3], head.split()[5]
    net = compiled(
        f"tissue special like plain {{ {head} = d * (1 + 8 * {e} / rest length) * {w} }}"
    )
    stretch, speed = np.array([-1e-3, 0.0, 4e-3]), np.array([0.2, -0.1, 0.05])
    found = net.springs.behaviour
    assert found.brake(stretch, speed) == pytest.approx(0.01 * (1 + 800 * stretch) * speed)
    assert found.brake_slope(stretch, speed) == pytest.approx(0.01 * (1 + 800 * stretch))
    assert found.brake_by_e(stretch, speed) == pytest.approx(0.01 * 800 * speed)
    assert found.pull(stretch) == pytest.approx(20.0 * stretch)


def test_a_law_is_inherited_and_can_be_replaced():
    tissues = (
        "tissue thread like plain { spring law is tension only }\n"
        "tissue longer like thread { mass = 2 g }\n"
        "tissue special like longer { spring law is linear }\n"
    )
    assert compiled(tissues, tissue="longer").springs.laws[1].name == "tension only"
    assert compiled(tissues).springs.laws == (LINEAR,)


def test_what_no_law_uses_need_not_be_given():
    net = compiled(
        "tissue special {\n"
        "spring law is curve { elongations = [0 mm, 1 mm]; forces = [0 N, 2 N] }\n"
        "viscosity = 10 mN*s/m; mass = 1 g }"
    )
    assert net.springs.behaviour.pull(np.full(3, 5e-4)) == pytest.approx(1.0)


def test_regions_have_laws_of_their_own_and_the_interface_chooses():
    tissues = (
        "tissue special like plain { spring constant = 5 N/m; spring law is tension only }\n"
    )
    ends = "region right where x > 15 mm {{ tissue is plain }}; interface is {}"
    for word, numbers in (("softer", [1, 1, 0]), ("stiffer", [1, 0, 0])):
        net = compiled(tissues, body=ends.format(word).replace("{{", "{").replace("}}", "}"))
        assert net.springs.law.tolist() == numbers


MISTAKES = {
    "spring law is exponentail { stiffening = 2 }": ("TIS305", 'did you mean "exponential"'),
    "spring law is exponential": ("TIS304", "stiffening"),
    "spring law is exponential { stiffening = 0 }": ("TIS309", "stiffening"),
    "spring law is exponential { stiffening = 2 mm }": ("TIS502", ""),
    "spring law is toe { strain = -2 % }": ("TIS308", "above"),
    "spring law = 3": ("TIS312", "spring force of e"),
    "spring law is curve { elongations = 3 mm; forces = [1 N, 2 N] }":
        ("TIS312", "[1 mm, 2 mm]"),
    "spring law is curve { elongations = [1 mm, 0 mm]; forces = [1 N, 2 N] }":
        ("TIS309", "ascend"),
    "spring force of e = c * e * e": ("TIS502", "a force"),
    "spring force of e = c * x": ("TIS301", '"x"'),
    "spring force of e = 3 N * exp(e)": ("TIS502", "exp"),
    "spring force of e = 3 N * 2 ^ (e / 1 mm)": ("TIS502", "exp and log"),
    "spring force of e = 1 N * sqrt(e / 1 mm)": ("TIS504", "abs"),
    "spring force of e = c * e / 0": ("TIS504", "zero"),
    "spring force of c = c * 1 mm": ("TIS503", "call it e"),
    "spring force on e = c * e": ("TIS312", "spring force of e"),
    "mass of e = 3 g": ("TIS303", "write mass = …"),
    "viscosity law is power { exponent = 2 }": ("TIS304", "speed"),
    "viscous force of w = d": ("TIS502", "a force"),
    "viscous force of e and w = d * e": ("TIS502", "a force"),
    "viscous force of e and w = d * w + 3 N * exp(e / (1 m))": ("TIS309", "4.05 N at 300 mm"),
    "viscous force of w = d * w + 1 N": ("TIS309", "spring force"),
    "viscous force of e and w = d * w * sqrt(e / (1 mm))": ("TIS504", "-100 um and -100 um/s"),
    "viscous force of w and e = d * w": ("TIS503", "call it e"),
    "viscous force of d and w = d * w": ("TIS503", "call it e"),
    "viscous force of w and w = d * w": ("TIS503", "call it e"),
    "viscous force of x and x = d * x": ("TIS503", "call it w"),
    "viscous force on e and w = d * w": ("TIS312", "viscous force of e and w = …"),
    "spring force of e and w = c * e": ("TIS312", "spring force of e = …"),
    "stress = 3 kPa": ("TIS312", "stress of strain = …"),
    "stress of e = 3 N * e": ("TIS502", "a pressure"),
    "stress of e = 3 kPa * e / (1 mm)": ("TIS502", ""),
    "stress of e = 3 kPa * sqrt(e)": ("TIS504", "abs"),
    "stress of e = 3 kPa * e; spring constant = 2 N/m": ("TIS306", "spring constant"),
    "stress of e = 3 kPa * max(e - 0.1, 0)": ("TIS304", "Young's modulus"),
    "stress of e = Young's modulus * e": ("TIS304", "Young's modulus"),
    "stress of e = 3 kPa * e; spring law is linear": ("TIS307", "spring law"),
    "spring law is stress curve { strains = [0, 1 %]; stresses = [0 Pa, 1 N] }":
        ("TIS502", "stresses"),
}  # fmt: skip


@every("entry", MISTAKES)
def test_mistakes_are_named(entry):
    code, words = MISTAKES[entry]
    found = refused(f"tissue special like plain {{ {entry} }}")
    assert found.code == code
    assert words in f"{found.message} {found.hint}"


def test_a_formula_outside_of_a_tissue_is_no_part_of_a_scene():
    found = refused("spring force of e = 3 N", tissue="plain")
    assert found.code == "TIS115"
    assert "in a tissue" in found.hint


def test_springs_of_a_table_have_no_section_for_a_stress():
    table = 'table springs of rod with columns "a b law" { 0 1 elastin }\n'
    text = FRAME.format(tissues="law elastin { stress of e = 3 kPa * e }", tissue="plain",
                        body="", first=10)  # fmt: skip
    start, end = text.index("table springs"), text.index("environment")
    found = finding_of(
        compile_request, Request(Source("scene.tis", text[:start] + table + text[end:]))
    )
    assert found.code == "TIS306"
    assert "in the tissue" in found.hint


JOINED = "region right where x > 15 mm { tissue is plain }; interface is mean"


@pytest.mark.parametrize("law", ["spring law is tension only", "viscosity law is power"])
def test_two_laws_have_no_mean(law):
    more = " { exponent = 0.5; speed = 1 m/s }" if "viscosity" in law else ""
    stiff = "stiffening = 3; " if "viscosity" in law else ""
    found = refused(f"tissue special like plain {{ {stiff}{law}{more} }}", body=JOINED)
    assert found.code == "TIS309"
    assert "between special" not in found.message and "rod and right" in found.message
    assert "interface is softer from rod to right, or stiffer" in found.hint


@pytest.mark.parametrize(("other", "mean"), [("stiffening = 2", 5.0), ("mass = 2 g", 4.0)])
def test_springs_between_two_stiffenings_have_their_mean(other, mean):
    network = compiled(
        f"tissue special like plain {{ stiffening = 8; spring constant = 60 N/m }}\n"
        f"tissue other like plain {{ {other} }}",
        body=JOINED.replace("is plain", "is other"),
    )
    springs = network.springs
    # 0.1 of the rest length: c L0 (exp(k ε) - 1)/k, with the means of both c and k.
    pull = springs.behaviour.pull(0.1 * springs.rest)
    assert pull[1] == pytest.approx(40.0 * 0.01 * np.expm1(0.1 * mean) / mean, rel=1e-12)
    assert pull[0] == pytest.approx(60.0 * 0.01 * np.expm1(0.8) / 8.0, rel=1e-12)
    small = springs.behaviour.pull(1e-9 * springs.rest) / 1e-9 / springs.rest
    assert small[1] == pytest.approx(40.0, rel=1e-6)


def test_a_strain_needs_a_rest_length():
    found = refused("tissue special like plain { spring law is toe { strain = 3 % } }", first=0)
    assert found.code == "TIS309"
    assert "no rest length" in found.message


def test_points_of_a_curve_in_compression_are_held_against_the_solid():
    """The closed form has the stress of the solid; bars follow all points and are silent."""
    from tissuec.analysis.lab.closed_form import LawCurve
    from tissuec.pipeline import check_request
    from tissuec.scene.tissues.known_curves import COMPRESSION

    def found(strains, stresses, mesh):
        text = f"""language 1
tissue disc {{ spring law is stress curve {{ strains = {strains}; stresses = {stresses} }}
  density = 1000 kg/m^3; retardation time = 1 ms }}
body pad {{ mesh is {mesh}; tissue is disc }}
environment {{ gravity = (0, 0, 0) m/s^2 }}
simulate {{ duration = 1 ms }}
"""
        compiled, warnings = check_request(Request(Source("disc.tis", text)))
        tissue = compiled.scene.bodies["pad"].tissue
        pressed = -float(LawCurve.of(tissue).stress(COMPRESSION, [0.2])[0])
        return [one.message for one in warnings if one.code == "W215"], pressed

    def of_formula(formula, mesh):
        text = f"""language 1
tissue disc {{ {formula}; density = 1000 kg/m^3; retardation time = 1 ms }}
body pad {{ mesh is {mesh}; tissue is disc }}
environment {{ gravity = (0, 0, 0) m/s^2 }}
simulate {{ duration = 1 ms }}
"""
        _, warnings = check_request(Request(Source("disc.tis", text)))
        return [one.message for one in warnings if one.code == "W215"]

    block = "lattice { cell = 5 mm; box from (0, 0, 0) mm to (10, 10, 10) mm }"
    bar = "thread { line from (0, 0, 0) mm to (20, 0, 0) mm; pieces = 2; thickness = 2 mm }"
    bent = "[-20 %, 0, 20 %]", "[-10 kPa, 0 Pa, 1 kPa]"
    (message,), pressed = found(*bent, block)
    assert "at a strain of -20 %, the curve has -10 kPa" in message
    said = float(message.rpartition("the solid ")[2].split()[0])
    assert 1e3 * said == pytest.approx(pressed, rel=1e-2)  # of three digits that are shown
    assert found(*bent, bar)[0] == []
    formula = "stress of strain = 5 kPa * max(strain, 0)"
    assert "at a strain of -5 %, the curve has 0 Pa" in of_formula(formula, block)[0]
    assert of_formula(formula, bar) == []
    # One that distinguishes nothing: a line is near to the solid at small strains, which is
    # stiffer in compression by 3 strain; an exponential is softer.
    assert of_formula("stress of strain = 5 kPa * strain", block) == []
    stiffening = "stress of strain = 1 kPa * (exp(10 * strain) - 1)"
    assert "at a strain of -5 %, the curve has -393 Pa" in of_formula(stiffening, block)[0]
    assert of_formula(stiffening, bar) == []
    # What agrees with the solid within 20 % is no contradiction.
    assert found("[-20 %, 0, 20 %]", "[-1.5 kPa, 0 Pa, 1 kPa]", block)[0] == []
