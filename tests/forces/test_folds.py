"""Folds of hinges: angles between two faces."""

import numpy as np
import pytest

from tissuec.forces.surfaces.bending import folds


def test_a_fold_is_the_angle_between_two_faces_whichever_way_it_goes():
    for angle in (-3.0, -1.0, 0.0, 0.5, 3.0):
        tip = [0.3, np.cos(angle), np.sin(angle)]
        corners = np.array([[0, 0, 0], [1, 0, 0], tip, [0.6, -2.0, 0.0]])
        assert folds(corners[None]) == pytest.approx([angle])
        # The other way round the edge, and seen from the other end.
        assert folds(corners[None, [1, 0, 3, 2]]) == pytest.approx([angle])
