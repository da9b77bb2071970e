"""Two blocks that are glued at a face, and how they are deformed."""

import numpy as np

from tests.validate.scenes import compiled_scene
from tissuec.mechanics.settling import settle
from tissuec.mechanics.state import State

GEL = """tissue gel {{
  Young's modulus = 10 kPa; Poisson's ratio = {poisson}; density = 1000 kg/m^3
  retardation time = {lag}
}}
"""
TIED = (
    "language 1\n"
    + GEL
    + """body coarse {{
  mesh is lattice {{ cell = 5 mm; box from (0, 0, 0) mm to (20, 10, 10) mm }}; tissue is gel
  {motion}
}}
body fine {{
  mesh is lattice {{ cell = 2.5 mm; box from (20, 0, 0) mm to (40, 10, 10) mm }}; tissue is gel
  {motion}
}}
set face = nodes of fine where x < 20.1 mm
joint tie {{ glue from face to coarse }}
set left = nodes of coarse where x < 0.1 mm
set right = nodes of fine where x > 39.9 mm
"""
)
#: Of the fine block, faces that do not lie in those of the coarse one.
CROSSED = ("cell = 2.5 mm", "cell = (2.5, 3.333333333333, 3.333333333333) mm")
#: The same as one mesh of the small cells.
WHOLE = (
    "language 1\n"
    + GEL
    + """body fine {{
  mesh is lattice {{ cell = 2.5 mm; box from (0, 0, 0) mm to (40, 10, 10) mm }}; tissue is gel
  {motion}
}}
set left = nodes of fine where x < 0.1 mm
set right = nodes of fine where x > 39.9 mm
"""
)
RUN = """environment {{ gravity = {gravity} m/s^2 }}
script {{ {script} }}
simulate {{ duration = {duration}; {method} }}
output {{ {output} }}
"""


def glued(text=TIED, *, poisson=0.3, lag="1 ms", motion="", gravity="(0, 0, 0)", script="",
          duration="1 s", method="integrator is equilibrium; step = 0.5 s",
          output="force(right) every 0.5 s"):  # fmt: skip
    """Return the text of a scene of glued blocks."""
    return (text + RUN).format(
        poisson=poisson, lag=lag, motion=motion, gravity=gravity, script=script,
        duration=duration, method=method, output=output,
    )  # fmt: skip


def standing(text):
    """Return the state of a scene as drawn."""
    return State.start(compiled_scene(text).network, gravity=np.zeros(3), drag=0.0)


def error_of_even_motion(state, gradient, moved):
    """Return by how much nodes that come to rest miss a uniform gradient of displacement [m].

    Args:
        moved: Which nodes are moved by it, shape (node,).
    """
    drawn = state.network.position
    even = drawn + drawn @ np.array(gradient).T
    state.holders["moved"] = np.flatnonzero(moved)
    state.position[moved] = even[moved]
    settle(state, np.ones(len(drawn), dtype=bool))
    return np.abs(state.position - even).max()


def at_ends(position):
    """Return which nodes are at either end in x."""
    x = position[:, 0]
    return (x < x.min() + 1e-9) | (x > x.max() - 1e-9)


def on_box(position):
    """Return which nodes are on the box around all of them."""
    low, high = position.min(axis=0), position.max(axis=0)
    return ((position < low + 1e-9) | (position > high - 1e-9)).any(axis=1)
