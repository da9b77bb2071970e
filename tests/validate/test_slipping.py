"""Friction of faces in the reference: steps end where bristles begin to slip or to stick."""

import numpy as np
import pytest

from tests.validate.scenes import compiled_scene
from tissuec.validate.reference import reference
from tissuec.validate.stepping import ReferenceFailure
from tissuec.validate.uncertainty import uncertainty

GEL = """Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  retardation time = 10 ms"""

#: A plate that rubs a block which does not yield: back and forth, while its pressure changes.
DEPTH, FRICTION = 0.3e-3, 0.4
RUBBED = f"""language 1
tissue gel {{ {GEL} }}
body block {{
  mesh is lattice {{ cell = 5 mm; box from (0, 0, 0) mm to (5, 5, 5) mm }}; tissue is gel
}}
tool plate {{ kind is plane; point = (0, 0, 4.7) mm; normal = (0, 0, -1) }}
environment {{
  gravity = (0, 0, 0) m/s^2; contact is tools only; friction = {FRICTION}
}}
script {{
  at 0 s: fix block
  from 0 ms to 10 ms: move plate by (0.3, 0, -0.1) mm using constant speed
  from 10 ms to 20 ms: move plate by (-0.1, 0, 0.1) mm using constant speed
  from 20 ms to 30 ms: move plate by (-0.4, 0, -0.2) mm using constant speed
  from 30 ms to 40 ms: move plate by (0.05, 0, 0.2) mm using smooth profile
  from 40 ms to 50 ms: move plate by (-0.02, 0, 0.25) mm using constant speed
}}
simulate {{ duration = 50 ms; tolerance = 1e-3 }}
output {{ force of plate every 1 ms }}
"""
WAYS = ((0.3, -0.1), (-0.1, 0.1), (-0.4, -0.2), (0.05, 0.2), (-0.02, 0.25))  # [mm]


def bristle(layer, count=20_000):
    """Return times [s], z and φ [m] of the law for this path, in small steps."""
    each = np.arange(1, count + 1) / count
    parts = [each] * 5
    parts[3] = each**3 * (10.0 - 15.0 * each + 6.0 * each**2)
    ends = np.cumsum([(0.0, 0.0), *WAYS], axis=0) * 1e-3
    path = [
        a + part[:, None] * (b - a) for a, b, part in zip(ends, ends[1:], parts, strict=False)
    ]
    x, z = np.concatenate([ends[:1], *path]).T
    depth = DEPTH - z
    press = np.where(depth < layer, depth**2 / (2.0 * layer), depth - 0.5 * layer)
    found, slides = np.zeros(len(x)), False
    for i, (way, most) in enumerate(zip(np.diff(x), FRICTION * press[1:], strict=True)):
        bent = found[i] + way
        # What slips bears all of the friction until the plate turns back.
        slides = abs(bent) >= most or (slides and way * found[i] >= 0.0)
        found[i + 1] = np.copysign(most, bent) if slides else bent
    return np.linspace(0.0, 50e-3, len(x)), found, press


def test_bristles_follow_the_law_whatever_the_steps():
    compiled = compiled_scene(RUBBED)
    network, times = compiled.network, np.linspace(0.0, 50e-3, 26)
    expected = bristle(network.contact.layer)
    for rtol in (1e-3, 1e-5):
        force = reference(network, compiled.plan, times, rtol=rtol).force
        on_tool = force[:, network.body_nodes :].sum(axis=1)
        z, press = (np.interp(times, expected[0], each) for each in expected[1:])
        ratio = on_tool[:, 0] / on_tool[:, 2]
        assert np.abs(np.abs(ratio) - np.abs(z) / press).max() < 1e-4 * FRICTION


def test_finer_steps_bring_the_reference_of_a_shaken_block_nearer():
    """A block that swings on a slope: its points slip and stick some dozen times."""
    text = f"""language 1
tissue gel {{ {GEL} }}
body block {{
  mesh is lattice {{ cell = 20 mm; box from (0, 0, 0) mm to (20, 20, 20) mm }}; tissue is gel
}}
tool slope {{ kind is plane; point = (0, 0, 0) mm; normal = (0, 0, 1) }}
environment {{
  gravity = (4.3, 0, -8.8) m/s^2; contact is tools only; friction = 0.5
}}
simulate {{ duration = 12 ms; tolerance = 1e-3 }}
"""
    compiled = compiled_scene(text)
    network, plan, times = compiled.network, compiled.plan, np.linspace(0.0, 12e-3, 4)
    one, other = (reference(network, plan, times, rtol=rtol) for rtol in (1e-6, 1e-5))
    assert float(uncertainty(one, other, network)[-1]) < 1e-4
    assert one.effort.steps < 80


def test_methods_of_many_steps_are_refused():
    compiled = compiled_scene(RUBBED)
    with pytest.raises(ReferenceFailure, match="uses steps before the last one"):
        reference(compiled.network, compiled.plan, np.array([0.0, 0.05]), method="BDF")
