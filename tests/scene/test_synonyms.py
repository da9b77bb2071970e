"""Synonyms, such as terms of the publication, stand for names wherever a name can stand."""

import numpy as np
import pytest

from tissuec.core.errors import CompileError
from tissuec.core.names import SYNONYMS
from tissuec.core.source import Source
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

TEXT = """language 1
use "fuzzy/soft_tissue"
tissue gum {
  spring constant = 40 N/m; viscosity = 0.01 N*s/m; mass = 10 mg; breaking force = 2 N
}
tissue wall {
  described in soft tissue; hardness is soft; elasticity is big; weight is low
  shiftability is high; consistency is smooth
}
body net { mesh is explicit; tissue is gum; rupture is allowed }
table nodes of net in mm with columns "id x y z" { 1 0 0 0; 2 5 0 0; 3 0 5 0 }
table springs of net with columns "a b breaking force in N" { 1 2 1; 2 3 -; 3 1 3 }
body tube {
  mesh is tube { axis from (0, 0, 0) mm to (20, 0, 0) mm; radius = 3 mm; rings = 4; sides = 6 }
  tissue is wall
}
set all = springs of net
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: change breaking force of all to 1 N }
simulate { duration = 1 s }
"""


def compiled(text):
    return compile_request(Request(Source("scene.tis", text)))[0]


def test_scenes_with_synonyms_compile_to_the_same_network_and_script():
    plain, other = TEXT, TEXT
    for word, name in SYNONYMS.items():
        assert name in TEXT
        other = other.replace(name, word.title())
    one, two = compiled(plain), compiled(other)
    for name in ("stiffness", "damping", "mass", "strength"):
        assert np.array_equal(one.network.array(name), two.network.array(name))
    assert one.network.springs.strength[:3].tolist() == [1.0, 2.0, 3.0]
    assert [type(event.action) for event in one.plan.events] == [
        type(event.action) for event in two.plan.events
    ]


def test_a_quantity_under_both_names_is_written_twice():
    text = TEXT.replace("breaking force = 2 N", "fraction force = 2 N; breaking force = 3 N")
    with pytest.raises(CompileError) as caught:
        compiled(text)
    assert [one.code for one in caught.value.diagnostics] == ["TIS307"]
