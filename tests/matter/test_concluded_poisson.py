"""A Poisson's ratio that rules conclude: elements have it, bars have none."""

import numpy as np
import pytest

import tissuec
from tests.matter.test_bodies import THREAD, text_of

pytestmark = pytest.mark.filterwarnings("ignore::tissuec.TissueWarning")
MATTER = "Young's modulus = 5 kPa; density = 1000 kg/m^3; retardation time = 1 ms"
WORDS = """language 1
property wetness from 0 to 1 { evenly = [dry, wet] }
quantity Poisson's ratio from 0.1 to 0.49 { evenly = [low, high] }
rules r { if wetness is wet then Poisson's ratio is high }
"""


def net(mesh, tissue, more=""):
    text = text_of(mesh, f"{tissue}; {MATTER}", more)
    return tissuec.compile(text.replace("language 1\n", WORDS, 1)).network


def test_elements_have_it():
    mesh = "lattice { cell = 10 mm; box from (0, 0, 0) mm to (20, 10, 10) mm }"
    (field,) = net(mesh, "described in r; wetness is wet").elements
    (plain,) = net(mesh, "prestress = 0").elements
    assert (field.bulk > 2.0 * plain.bulk).all()


def test_it_does_not_matter_to_a_bar():
    plain, written = (net(THREAD, one) for one in ("prestress = 0", "Poisson's ratio = 0.45"))
    assert np.array_equal(plain.springs.stiffness, written.springs.stiffness)
