"""Springs between regions, and chosen ones, are made of what is said of them."""

import re

import numpy as np
import pytest

from tests.every import every
from tests.matter.elastic import findings
from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.learn.parameters.substitution import UsePlace, recompiled
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

GEL = "density = 1000 kg/m^3; retardation time = 5 ms"
TISSUES = f"""language 1
tissue low {{ spring constant = 2 N/m; {GEL} }}
tissue middle {{ spring constant = 6 N/m; {GEL} }}
tissue high {{ spring constant = 20 N/m; {GEL} }}
tissue glue {{ spring constant = 0.5 N/m; {GEL} }}
"""
BLOCK = (
    "mesh is lattice { kind is sodium chloride; reach is second neighbours; cell = 5 mm; "
    "box from (0, 0, 0) mm to (10, 10, 30) mm }; tissue is middle; "
    "region bottom where z < 11 mm { tissue is low }; "
    "region top where z > 21 mm { tissue is high }"
)
THREAD = (
    "mesh is thread { line from (0, 0, 0) mm to (60, 0, 0) mm; thickness = 2 mm; pieces = 6 }; "
    "tissue is middle; region near where x < 25 mm { tissue is low }; "
    "region far where x > 45 mm { tissue is high }"
)


def compiled(body, tissues=TISSUES):
    text = f"""{tissues}body piece {{ {body} }}
environment {{ gravity = (0, 0, 0) m/s^2 }}
simulate {{ duration = 1 ms; tolerance = 1e-6; integrator is dop853 }}
"""
    return compile_request(Request(Source("piece.tis", text)))[0]


def all_of(tissue):
    """Return the constants of the block, made of one tissue."""
    return compiled(
        f"{BLOCK.partition('tissue is')[0]}tissue is {tissue}"
    ).network.springs.stiffness


def between(network, low, high):
    """Return which springs lead from below one height to above another [mm]."""
    ends = np.sort(1e3 * network.position[:, 2][network.springs.ends], axis=1)
    return (ends[:, 0] < low) & (ends[:, 1] > high)


def test_springs_of_an_interface_are_those_of_a_body_of_its_tissue():
    network = compiled(
        f"{BLOCK}; interface from piece to bottom {{ tissue is glue }}; "
        "interface is softer from top to piece"
    ).network
    lower, upper = between(network, 11, 14), between(network, 21, 24)
    assert lower.sum() == upper.sum() > 0
    assert network.springs.stiffness[lower] == pytest.approx(all_of("glue")[lower], rel=1e-12)
    assert network.springs.stiffness[upper] == pytest.approx(all_of("middle")[upper], rel=1e-12)
    beside = (
        ~lower & ~upper & (network.position[:, 2][network.springs.ends].max(axis=1) < 0.011)
    )
    assert network.springs.stiffness[beside] == pytest.approx(all_of("low")[beside], rel=1e-12)


@pytest.mark.parametrize(("rule", "part"), [("mean", 0.5), ("softer", 0.0), ("stiffer", 1.0)])
def test_each_pair_of_regions_has_a_rule_of_its_own(rule, part):
    network = compiled(
        f"{BLOCK}; interface is stiffer; interface is {rule} from bottom to piece"
    ).network
    lower, upper = between(network, 11, 14), between(network, 21, 24)
    soft, stiff = all_of("low")[lower], all_of("middle")[lower]
    assert network.springs.stiffness[lower] == pytest.approx(
        soft + part * (stiff - soft), rel=1e-12
    )
    assert network.springs.stiffness[upper] == pytest.approx(all_of("high")[upper], rel=1e-12)


def test_chosen_springs_go_before_interfaces():
    network = compiled(
        f"{BLOCK}; interface is softer; springs where z between 11 mm and 14 mm "
        "{ tissue is glue; prestress = 10 % }"
    ).network
    chosen = np.abs(network.position[:, 2][network.springs.ends].mean(axis=1) - 12.5e-3) < 1e-3
    assert between(network, 11, 14)[chosen].all()
    assert network.springs.stiffness[chosen] == pytest.approx(all_of("glue")[chosen], rel=1e-12)
    drawn = np.linalg.norm(
        np.diff(network.position[network.springs.ends], axis=1)[:, 0], axis=1
    )
    assert network.springs.rest == pytest.approx(np.where(chosen, 0.9, 1.0) * drawn, rel=1e-12)


def test_parts_of_a_bar_in_a_row_resist_as_springs_in_a_row():
    found = compiled(
        f"{THREAD}; interface from near to piece {{ tissue is glue }}; "
        "interface is softer from far to piece",
        re.sub(r"spring constant = (\S+) N/m", r"Young's modulus = \1 kPa", TISSUES),
    )
    force = 60e-3 / (1.0 / found.network.springs.stiffness[:6]).sum()  # at a strain of 1
    # Two of low, one of glue, one of middle, one between (the softer: middle), one of high.
    moduli = np.array([2e3, 2e3, 0.5e3, 6e3, 6e3, 20e3])
    expected = np.pi * 1e-6 / (10e-3 / moduli).sum() * 60e-3
    assert force == pytest.approx(expected, rel=1e-12)


def test_what_is_learnt_of_a_tissue_reaches_springs_between_regions():
    body = f"{BLOCK}; interface is softer; interface from bottom to piece {{ tissue is glue }}"
    learnt = recompiled(compiled(body), {(UsePlace("glue"), "spring constant"): 0.7}, {})
    other = compiled(body, TISSUES.replace("0.5 N/m", "0.7 N/m"))
    assert np.array_equal(learnt.network.springs.stiffness, other.network.springs.stiffness)


@every(
    ("entry", "code", "said"),
    [
        ("interface is softer from a to piece", "TIS301", "no region called"),
        ("interface is softer from piece to piece", "TIS302", "no springs from piece to piece"),
        (
            "interface from near to far { tissue is gel }",
            "TIS302",
            "no springs from near to far",
        ),
        ("interface is softer from near to piece", "TIS304", "from piece to far"),
        ("interface is soft from near to piece", "TIS305", "cannot be"),
        ("interface is softer to far", "TIS304", "the first region is missing"),
        (
            "interface is softer; springs where x < 0 mm { tissue is gel }",
            "TIS302",
            "no springs where",
        ),
        ("springs { tissue is gel }", "TIS304", "condition of the springs is missing"),
        (
            "interface is softer; springs where x > 0 mm { mass = 1 g }",
            "TIS303",
            "not an entry",
        ),
        (
            "interface is softer from near to piece; interface is mean from piece to near",
            "TIS307",
            "given twice",
        ),
        (
            "interface is softer; springs where x > 1 mm { tissue is gel }; "
            "springs where x > 9 mm { tissue is gel }",
            "TIS311",
            "two conditions select",
        ),
    ],
)
def test_mistakes_are_told(entry, code, said):
    body = THREAD.replace("middle", "gel").replace("low", "gel").replace("high", "gel")
    found = findings(
        f"Young's modulus = 2 kPa; {GEL}",
        f"{body}; {entry}".replace("tissue is gel; region", "region"),
    )
    assert [(one.code, said in one.message) for one in found] == [(code, True)]


def test_springs_of_a_table_need_an_interface_whatever_their_law():
    text = """language 1
tissue low { spring constant = 10 N/m; viscosity = 1 mN*s/m; mass = 1 g }
tissue high { spring constant = 90 N/m; viscosity = 1 mN*s/m; mass = 1 g }
law band { spring force of e = c * e }
body net {
  mesh is explicit; tissue is low; interface is softer from a to net
  region a where x < 5 mm { tissue is high }; region b where x > 15 mm { tissue is high }
}
table nodes of net in mm with columns "id x" { 1 0; 2 10; 3 20 }
table springs of net with columns "a b law" { 1 2 band; 2 3 band }
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 ms }
"""
    with pytest.raises(CompileError, match="the material of springs from net to b"):
        compile_request(Request(Source("net.tis", text)))
    found = compile_request(Request(Source("net.tis", text.replace(" from a to net", ""))))[0]
    assert found.network.springs.stiffness.tolist() == [10.0, 10.0]
