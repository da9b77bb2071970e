"""Rasterisation of triangles with a depth buffer."""

from math import ceil, floor

from tissuec.kernels.records import Floats, Pixels, Rows, Stack


def fill(
    corners: Stack, colour: Stack, opacity: Floats, picture: Pixels, nearness: Rows, hides: int
) -> None:
    """Draw triangles in turn; see ``view.player.shading``.

    Args:
        corners: Column and row [pixels] and nearness of each corner, shape (triangle, 3, 3).
        colour: Of each corner, dimensionless, shape (triangle, 3, channel).
        opacity: Of each triangle, 0 to 1, shape (triangle,).
        picture: Changed in place, shape (row, column, channel).
        nearness: Of what is drawn in each pixel, changed in place, shape (row, column).
        hides: 1 if triangles hide what is drawn behind them later.
    """
    height, width = nearness.shape
    for t in range(corners.shape[0]):
        ax, ay, az = corners[t, 0, 0], corners[t, 0, 1], corners[t, 0, 2]
        bx, by, bz = corners[t, 1, 0], corners[t, 1, 1], corners[t, 1, 2]
        cx, cy, cz = corners[t, 2, 0], corners[t, 2, 1], corners[t, 2, 2]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if area == 0.0:
            continue
        # Pixels have their middles at halves.
        left = ceil(min(max(min(ax, bx, cx) - 0.5, 0.0), width))
        right = floor(min(max(ax, bx, cx) - 0.5, width - 1.0))
        low = ceil(min(max(min(ay, by, cy) - 0.5, 0.0), height))
        high = floor(min(max(ay, by, cy) - 0.5, height - 1.0))
        for row in range(low, high + 1):
            y = row + 0.5
            for column in range(left, right + 1):
                x = column + 0.5
                u = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / area
                v = ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / area
                w = 1.0 - u - v
                if u < 0.0 or v < 0.0 or w < 0.0:
                    continue
                near = u * az + v * bz + w * cz
                if near <= nearness[row, column]:
                    continue
                if hides == 1:
                    nearness[row, column] = near
                alpha = opacity[t]
                for k in range(3):
                    new = u * colour[t, 0, k] + v * colour[t, 1, k] + w * colour[t, 2, k]
                    old = picture[row, column, k]
                    picture[row, column, k] = old + alpha * (new - old)
