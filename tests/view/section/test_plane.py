"""Planes as people write them."""

import numpy as np
import pytest

from tests.every import every
from tissuec.view.section import read_plane
from tissuec.view.section.plane import SectionPlane


@every(
    ("text", "normal", "offset"),
    [
        ("z = 6 mm", (0, 0, 1), 6e-3),
        ("x=-2.5cm", (1, 0, 0), -0.025),
        ("y = 0", (0, 1, 0), 0.0),
        ("z = 2 * 3 mm", (0, 0, 1), 6e-3),
        ("through (0, 0, 6) mm facing (0, 3, 4)", (0, 0.6, 0.8), 4.8e-3),
        ("through (17 mm, 0, 1 cm) facing (1, 0, 0)", (1, 0, 0), 0.017),
        ("plane through (1, 1, 1) m facing (0, 0, -2)", (0, 0, -1), -1.0),
        ("along plane through (0,0,0) facing (1,0,0)", (1, 0, 0), 0.0),
    ],
)
def test_a_plane_is_read_and_written(text, normal, offset):
    plane = read_plane(text)
    assert plane.normal == pytest.approx(normal) and plane.offset == pytest.approx(offset)
    again = read_plane(plane.text)
    assert again.normal == pytest.approx(normal, abs=1e-4)
    assert again.offset == pytest.approx(offset, rel=1e-3)


@every(
    ("text", "marked", "said"),
    [
        ("z = 6", "6", 'write "6 mm"'),
        ("z = 6 kg", "6 kg", "must be a length (m), but 6 kg is a mass"),
        ("z = (1, 2, 3) mm", "(1, 2, 3) mm", "is one length"),
        ("z = depth", "depth", 'there is no number called "depth"'),
        ("z = 3 mm; x = 3 mm", "z = 3 mm", "not a plane"),
        ("z = 6 parsecs", "parsecs", "not a unit"),
        ("w = 3 mm", "w = 3 mm", 'write "z = 6 mm"'),
        ("z > 6 mm", ">", 'unexpected ">"; write "z = 6 mm"'),
        ("z = 6 mm and more", "and", 'write "z = 6 mm"'),
        ("through (1, 2, 3) facing (0, 0, 1)", "(1, 2, 3)", 'write "(1, 2, 3) mm"'),
        ("through (1, 2, 3) mm", "through (1, 2, 3) mm", "the direction is missing"),
        ("through (1, 2, 3) mm facing up", "up", 'write "z = 6 mm"'),
        (
            "through (0, 0, 1) mm facing (0, 0, 0)",
            "facing (0, 0, 0)",
            "a direction cannot be (0, 0, 0)",
        ),
        ("along line through (0, 0, 1) mm facing (0, 0, 1)", "along line", "sections: plane"),
        ("z = 1e400 mm", "1e400 mm", "too large"),
    ],
)
def test_what_is_wrong_is_marked(text, marked, said):
    with pytest.raises(ValueError, match="\n") as caught:
        read_plane(text)
    message, line, carets = str(caught.value).split("\n")
    assert said in message and line.strip() == text
    begin = carets.index("^")
    assert line[begin : len(carets)] == marked


def test_the_front_is_turned_to_the_eye():
    plane = SectionPlane((0.0, 0.0, 1.0), 2.0)
    assert plane.towards(np.array([0.0, 0.0, 5.0])) is plane
    assert plane.towards(np.array([0.0, 0.0, 1.0])) == SectionPlane((0.0, 0.0, -1.0), -2.0)
