"""Writes ``library/meshes/liver.obj``: a closed surface with the outlines of a liver.

It is made of formulas, not of anybody's scan: an ellipsoid from a divided icosahedron, whose
left lobe is thinner and whose underside is hollow. Coordinates are in millimetres, x to the
left of the body, y to the front, z up. The triangles at the back, where a liver is grown
together with the diaphragm, are the group "bare area"; those at the end of the left lobe are
"left tip".

    python docs/make_organ.py
"""

from pathlib import Path

import numpy as np

from tissuec.meshes.generators.sphere import divide, icosahedron

PLACE = Path(__file__).parent.parent / "library" / "meshes" / "liver.obj"
HEAD = """\
# A surface like a liver, in millimetres; made by docs/make_organ.py, not from a scan.
"""


def organ() -> str:
    """Return the text of the file."""
    unit, triangles = icosahedron()
    for _ in range(3):
        unit, triangles = divide(unit, triangles)
    position = shaped(unit)
    middle = unit[triangles].mean(axis=1)
    names = np.where(middle[:, 0] > 0.93, "left_tip", "surface")
    back = (middle[:, 1] < -0.75) & (np.abs(middle[:, 2]) < 0.55) & (middle[:, 0] < 0.3)
    names = np.where(back, "bare_area", names)
    lines = [HEAD + "o liver"]
    lines += [f"v {x:.2f} {y:.2f} {z:.2f}" for x, y, z in position]
    for name in ("surface", "bare_area", "left_tip"):
        lines.append(f"g {name}")
        lines += [f"f {a} {b} {c}" for a, b, c in triangles[names == name] + 1]
    return "\n".join([*lines, ""])


def shaped(unit):
    """Return the nodes of a unit sphere as those of the organ [mm], shape (node, 3)."""
    x, y, z = unit.T
    left = 1.0 / (1.0 + np.exp(-4.0 * (x - 0.1)))
    hollow = np.where(z < 0.0, 0.8 - 0.25 * np.exp(-8.0 * ((x - 0.2) ** 2 + y**2)), 1.0)
    return np.stack(
        [100.0 * x, 60.0 * y * (1.0 - 0.3 * left), 45.0 * z * (1.0 - 0.55 * left) * hollow],
        axis=1,
    )


if __name__ == "__main__":
    PLACE.write_text(organ(), encoding="utf-8")
