"""Numbers beyond all measure end a run with a sentence, and not with an error of Python."""

import numpy as np
import pytest

import tissuec
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.stability import damping_ratio

PAIR = """language 1
tissue t {{ spring constant = 10 N/m; viscosity = 1 N*s/m; mass = 1 g{law} }}
body b {{ mesh is explicit; tissue is t }}
table nodes of b in mm with columns "id x" {{ 1 0; 2 11 }}
table springs of b with columns "a b rest length in mm" {{ 1 2 10 }}
environment {{ gravity = (0, 0, 0) m/s^2 }}
simulate {{ duration = {duration} s }}
"""


@pytest.mark.parametrize("damping", [1e200, 1e308, np.inf, np.nan])
def test_methods_have_a_limit_whatever_the_damping(damping):
    for method in INTEGRATORS.values():
        limit = method.stability_limit(100.0, damping_ratio(100.0, damping))
        assert limit >= 0.0  # and is a number


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(
    ("law", "duration"),
    [("; viscous force of e and w = d * (1 + max(e, 1e308 mm) / rest length) * w", "1e-3"),
     ("", "1e-99")],
)  # fmt: skip
def test_a_run_ends_with_a_sentence(law, duration):
    text = PAIR.format(law=law, duration=duration)
    with tissuec.run(text, companion="off") as result:
        assert result.outcome.startswith(("done", "stopped", "the run stopped"))
