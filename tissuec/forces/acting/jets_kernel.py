"""Jets on surfaces, as scalar loops; for the equations see ``acting.jets``.

Scratch of a triangle (``faces``): 0 normal along the jet, 3 its product with a corner, 4 cos θ,
5 area cos² θ of an element, 6 how much of a shade it throws, 7 where its corners are in ξ, in
turn to the left, 13 their middle, 15 their distance from there, 16 blur of the shade in ξ, 17
forces on its corners along the normal. Of an element (``points``): 0 its place, 3 distance
ahead, 4 where it is in ξ, 6 force on it.

Where threads share the triangles, one of them first finds those within the jet, and at last
adds the forces in the order of triangles.

Shared arguments:
    k: Row of the triangle in ``faces``.
    t: Index of the triangle in ``corners``.
    other: Row of another triangle in ``faces``.
    shades: Number of triangles listed in ``jet.shades``.
    side: Size of a cell of the grid in ξ, dimensionless.
    thrust: Momentum flux J of the jet [N].
    p0, p1, p2: A point [m].
    point: Row of ``jet.points``, shape (7,); see above for the units.
    shade: Row of ``jet.faces``, shape (20,); see above for the units.
    jet: Record of the jet; its fields give the shapes and units.
"""

from math import exp, inf, pi, sqrt
from typing import NamedTuple

from tissuec.kernels.boundary_conditions import total
from tissuec.kernels.records import BoundaryConditions, Floats, IntegerRows, Integers, Rows
from tissuec.kernels.thread_loops import UNDIVIDED, items_of

CUT = 4.5  # widths b beside the axis beyond which nothing is left but rounding
DEEP = 0.5  # of the blur of a shade: how far behind its triangle it is full
LIT, DARK = 0.3, 0.7  # covered parts of the jet
STEEP = 0.2  # cos θ below which the shades of triangles fade
NEAR = 0.5  # bores in front of the opening within which the jet sets in
FLAT = 1e-6  # of the blur: what is no further than this behind a plane is in it
SLACK = 2.0  # elements may be further off in ξ than the corners of their triangle
TINY = 1e-200  # added to a length before dividing
FINDING = 0  # ``part`` of a table that only finds triangles
GRID = 32  # cells along each side of the field in which triangles are sorted


class JetTable(NamedTuple):
    """A jet of fluid and the triangles that it may meet."""

    acts: BoundaryConditions  # the flow [m³/s] is the first component of the only one
    opening: Integers  # nodes in the opening and ahead of it, shape (2,)
    bore: float  # [m]
    density: float  # [kg/m³]
    growth: float  # of the width for each distance
    width: float  # b0 [m]
    corners: IntegerRows  # nodes of triangles, shape (triangle, 3)
    side: Integers  # from where they can be pushed, shape (triangle,)
    struck: Integers  # 1 if they are pushed, shape (triangle,)
    blur: Floats  # of their shades [m], shape (triangle,)
    shares: Rows  # elements of triangles as shares of their corners, shape (share, 3)
    shares_start: Integers  # among them, shape (triangle,)
    shares_end: Integers  # shape (triangle,)
    frame: Floats  # scratch: opening, direction, and two directions across, shape (12,)
    part: int  # that is computed, from 1 on; ``parts`` + 1 to add all up
    parts: int
    faces: Rows  # scratch, shape (triangle, 20)
    points: Rows  # scratch, shape (element of one triangle, 7)
    elements: Integers  # number of the first element of each triangle, shape (triangle,)
    lit: Floats  # part V of the jet that comes to each element, shape (element,)
    met: Integers  # scratch: triangles within the jet, shape (triangle,)
    link: Integers  # scratch: the next one in the same cell, shape (triangle,)
    shades: Integers  # scratch: those before one, shape (triangle,)
    head: Integers  # scratch: the first one in each cell, shape (cell,)
    found: Integers  # scratch: number of triangles within the jet, shape (1,)
    cell_size: Floats  # scratch: size of the cells in ξ, shape (1,)


def blow(time: float, x: Floats, v: Floats, f: Floats, power: Floats, jet: JetTable) -> None:
    """Add the forces of a jet to those on nodes, and the power that it supplies."""
    flow, _, _, _, _, _ = total(0, time, jet.acts)
    if flow <= 0.0:
        return
    thrust = jet.density * flow * flow / (0.25 * pi * jet.bore**2)
    part, parts = jet.part, jet.parts
    if part <= FINDING:
        power[0] += recoil(thrust, x, v, f, jet)
        jet.found[0] = survey(x, jet)
        jet.cell_size[0] = sort(jet.found[0], jet)
    count, first, last = jet.found[0], 0, 0
    if part == UNDIVIDED:
        last = count
    elif FINDING < part <= parts:
        first, last = items_of(part - 1, parts, count)
    speed = sqrt(2.0 * thrust / (pi * jet.density))
    for k in range(first, last):
        if jet.faces[k, 5] > 0.0:
            divide(k, speed, x, v, jet)
            dim(k, before(k, jet.cell_size[0], x, jet), jet)
            gather(k, jet)
    if part == UNDIVIDED or part > parts:
        for k in range(count):
            if jet.faces[k, 5] > 0.0:
                power[0] += push(k, v, f, jet)


def recoil(thrust: float, x: Floats, v: Floats, f: Floats, jet: JetTable) -> float:
    """Set the frame of a jet, add the recoil on its opening, and return its power [W]."""
    frame = jet.frame
    o, q = 3 * jet.opening[0], 3 * jet.opening[1]
    size = sqrt((x[q] - x[o]) ** 2 + (x[q + 1] - x[o + 1]) ** 2 + (x[q + 2] - x[o + 2]) ** 2)
    power = 0.0
    for k in range(3):
        frame[k], frame[3 + k] = x[o + k], (x[q + k] - x[o + k]) / size
        f[o + k] -= thrust * frame[3 + k]
        power -= thrust * frame[3 + k] * v[o + k]
    # Any two directions across the jet do.
    e0, e1, e2 = frame[3], frame[4], frame[5]
    if abs(e0) < 0.6:
        a0, a1, a2 = 0.0, e2, -e1
    else:
        a0, a1, a2 = -e2, 0.0, e0
    size = sqrt(a0 * a0 + a1 * a1 + a2 * a2)
    frame[6], frame[7], frame[8] = a0 / size, a1 / size, a2 / size
    frame[9] = e1 * frame[8] - e2 * frame[7]
    frame[10] = e2 * frame[6] - e0 * frame[8]
    frame[11] = e0 * frame[7] - e1 * frame[6]
    return power


def way(p0: float, p1: float, p2: float, jet: JetTable) -> tuple[float, float, float, float]:
    """Return the distance ahead of a point [m], b there [m], and the point's place in ξ."""
    a = jet.frame
    r0, r1, r2 = p0 - a[0], p1 - a[1], p2 - a[2]
    ahead = r0 * a[3] + r1 * a[4] + r2 * a[5]
    width = sqrt(jet.width**2 + (jet.growth * ahead) ** 2)
    one = (r0 * a[6] + r1 * a[7] + r2 * a[8]) / width
    other = (r0 * a[9] + r1 * a[10] + r2 * a[11]) / width
    return ahead, width, one, other


def rise(part: float) -> float:
    """Return a smooth step from 0 at 0 to 1 at 1."""
    part = min(max(part, 0.0), 1.0)
    return part * part * (3.0 - 2.0 * part)


def survey(x: Floats, jet: JetTable) -> int:
    """List the triangles within a jet and return their number."""
    corners, count = jet.corners, 0
    for t in range(corners.shape[0]):
        i, j, k = 3 * corners[t, 0], 3 * corners[t, 1], 3 * corners[t, 2]
        m0 = (x[i] + x[j] + x[k]) / 3.0
        m1 = (x[i + 1] + x[j + 1] + x[k + 1]) / 3.0
        m2 = (x[i + 2] + x[j + 2] + x[k + 2]) / 3.0
        far = 0.0
        for c in (i, j, k):
            far = max(far, (x[c] - m0) ** 2 + (x[c + 1] - m1) ** 2 + (x[c + 2] - m2) ** 2)
        far = sqrt(far)
        ahead, width, one, other = way(float(m0), float(m1), float(m2), jet)
        most = sqrt(jet.width**2 + (jet.growth * (abs(ahead) + far)) ** 2)
        off = sqrt(one * one + other * other) * width
        if ahead + far > 0.0 and off < CUT * most + far:
            jet.met[count] = t
            look(count, t, x, jet)
            count += 1
    return count


def look(k: int, t: int, x: Floats, jet: JetTable) -> None:
    """Set the row of ``faces`` for a triangle within a jet."""
    face, frame, side = jet.faces[k], jet.frame, jet.side[t]
    h, i, j = 3 * jet.corners[t, 0], 3 * jet.corners[t, 1], 3 * jet.corners[t, 2]
    p0, p1, p2 = x[i] - x[h], x[i + 1] - x[h + 1], x[i + 2] - x[h + 2]
    q0, q1, q2 = x[j] - x[h], x[j + 1] - x[h + 1], x[j + 2] - x[h + 2]
    n0, n1, n2 = p1 * q2 - p2 * q1, p2 * q0 - p0 * q2, p0 * q1 - p1 * q0
    size = sqrt(n0 * n0 + n1 * n1 + n2 * n2)
    inverse = 1.0 / size if size > 0.0 else 0.0
    slope = (n0 * frame[3] + n1 * frame[4] + n2 * frame[5]) * inverse
    if slope < 0.0:
        inverse, i, j = -inverse, j, i
    face[0], face[1], face[2] = n0 * inverse, n1 * inverse, n2 * inverse
    face[3] = face[0] * x[h] + face[1] * x[h + 1] + face[2] * x[h + 2]
    turned = jet.struck[t] and (side == 0 or side * slope < 0.0)
    part = 0.5 * size / (jet.shares_end[t] - jet.shares_start[t])
    face[4] = abs(slope)
    face[5] = part * slope * slope if turned else 0.0
    face[6] = rise(abs(slope) / STEEP)
    mean = 0.0
    place = 7
    for c in (h, i, j):
        p0, p1, p2 = float(x[c]), float(x[c + 1]), float(x[c + 2])
        _, width, one, other = way(p0, p1, p2, jet)
        face[place], face[place + 1] = one, other
        mean += width / 3.0
        place += 2
    face[13] = (face[7] + face[9] + face[11]) / 3.0
    face[14] = (face[8] + face[10] + face[12]) / 3.0
    reach = 0.0
    for place in range(7, 13, 2):
        far = (face[place] - face[13]) ** 2 + (face[place + 1] - face[14]) ** 2
        reach = max(reach, far)
    face[15], face[16] = SLACK * sqrt(reach), jet.blur[t] / mean


def sort(count: int, jet: JetTable) -> float:
    """Enter triangles into cells; return the size of these in ξ."""
    reach = span = 0.0
    for k in range(count):
        reach = max(reach, jet.faces[k, 15])
        span = max(span, jet.faces[k, 15] + jet.faces[k, 16])
    side = max(reach + span, 2.0 * CUT / GRID)
    for c in range(GRID * GRID):
        jet.head[c] = -1
    for k in range(count):
        i, j = cell(k, side, jet)
        jet.link[k] = jet.head[GRID * i + j]
        jet.head[GRID * i + j] = k
    return side


def cell(k: int, side: float, jet: JetTable) -> tuple[int, int]:
    """Return the row and column of a triangle in the grid of cells."""
    one, other = jet.faces[k, 13], jet.faces[k, 14]
    i, j = int((one + CUT) / side), int((other + CUT) / side)
    return min(max(i, 0), GRID - 1), min(max(j, 0), GRID - 1)


def divide(k: int, speed: float, x: Floats, v: Floats, jet: JetTable) -> None:
    """Set the elements of a triangle, without shading.

    Args:
        speed: On the axis, times b [m²/s].
    """
    frame, shares, t = jet.frame, jet.shares, jet.met[k]
    h, i, j = 3 * jet.corners[t, 0], 3 * jet.corners[t, 1], 3 * jet.corners[t, 2]
    start = jet.shares_start[t]
    for p in range(jet.shares_end[t] - start):
        s = start + p
        a, b, c = shares[s, 0], shares[s, 1], shares[s, 2]
        point = jet.points[p]
        away = 0.0
        for m in range(3):
            point[m] = a * x[h + m] + b * x[i + m] + c * x[j + m]
            away += frame[3 + m] * (a * v[h + m] + b * v[i + m] + c * v[j + m])
        p0, p1, p2 = float(point[0]), float(point[1]), float(point[2])
        ahead, width, one, other = way(p0, p1, p2, jet)
        point[3], point[4], point[5] = ahead, one, other
        here = speed / width * exp(-(one * one + other * other))
        slower = min(away, here)
        left = here * (here - 2.0 * slower) + max(slower, 0.0) ** 2
        near = rise(ahead / (NEAR * jet.bore))
        point[6] = jet.density * left * near * jet.faces[k, 5]


def before(k: int, side: float, x: Floats, jet: JetTable) -> int:
    """List the triangles that may shade one; return their number."""
    face, found = jet.faces[k], 0
    row, column = cell(k, side, jet)
    for i in range(max(row - 1, 0), min(row + 2, GRID)):
        for j in range(max(column - 1, 0), min(column + 2, GRID)):
            other = int(jet.head[GRID * i + j])
            while other >= 0:
                shade = jet.faces[other]
                one, two = face[13] - shade[13], face[14] - shade[14]
                span = face[15] + shade[15] + shade[16]
                if one * one + two * two < span * span and stands_before(k, other, x, jet):
                    jet.shades[found] = other
                    found += 1
                other = int(jet.link[other])
    return found


def stands_before(k: int, other: int, x: Floats, jet: JetTable) -> bool:
    """Return whether a corner of triangle k is behind a triangle that has no corner of k."""
    shade, corners = jet.faces[other], jet.corners
    t, u = jet.met[k], jet.met[other]
    behind = -inf
    for c in range(3):
        for d in range(3):
            if corners[t, c] == corners[u, d]:
                return False
        i = 3 * corners[t, c]
        level = shade[0] * x[i] + shade[1] * x[i + 1] + shade[2] * x[i + 2]
        behind = max(behind, level - shade[3])
    return bool(behind > FLAT * jet.blur[u])


def dim(k: int, shades: int, jet: JetTable) -> None:
    """Reduce the forces on a triangle's elements by the shades of triangles ahead of it."""
    t = jet.met[k]
    near, first = NEAR * jet.bore, jet.elements[t]
    for p in range(jet.shares_end[t] - jet.shares_start[t]):
        point, covered = jet.points[p], 0.0
        for n in range(shades):
            other = jet.shades[n]
            shade = jet.faces[other]
            deep = point[0] * shade[0] + point[1] * shade[1] + point[2] * shade[2] - shade[3]
            start = point[3] * shade[4] - deep
            if deep > 0.0 and start > 0.0:
                cover = shade[6] * within(point, shade)
                if cover > 0.0:
                    cover *= rise(deep / (DEEP * jet.blur[jet.met[other]]))
                    covered += cover * rise(start / (shade[4] * near))
        jet.lit[first + p] = 1.0 - rise((covered - LIT) / (DARK - LIT))
        point[6] *= jet.lit[first + p]


def within(point: Floats, shade: Floats) -> float:
    """Return the part of an element that is within the blurred edges of a triangle (0 to 1)."""
    cover = 1.0
    for a in range(7, 13, 2):
        b = a + 2 if a < 11 else 7
        one, two = shade[b] - shade[a], shade[b + 1] - shade[a + 1]
        left = one * (point[5] - shade[a + 1]) - two * (point[4] - shade[a])
        left /= sqrt(one * one + two * two) + TINY
        if left <= -shade[16]:
            return 0.0
        cover *= rise(0.5 + 0.5 * left / shade[16])
    return cover


def gather(k: int, jet: JetTable) -> None:
    """Set the forces on the corners of a triangle from those on its elements."""
    face, start = jet.faces[k], jet.shares_start[jet.met[k]]
    one = two = three = 0.0
    for p in range(jet.shares_end[jet.met[k]] - start):
        s = start + p
        one += jet.shares[s, 0] * jet.points[p, 6]
        two += jet.shares[s, 1] * jet.points[p, 6]
        three += jet.shares[s, 2] * jet.points[p, 6]
    face[17], face[18], face[19] = one, two, three


def push(k: int, v: Floats, f: Floats, jet: JetTable) -> float:
    """Add the forces on the corners of a triangle; return their power [W]."""
    face, t = jet.faces[k], jet.met[k]
    h, i, j = 3 * jet.corners[t, 0], 3 * jet.corners[t, 1], 3 * jet.corners[t, 2]
    one, two, three = face[17], face[18], face[19]
    power = 0.0
    for m in range(3):
        f[h + m] += one * face[m]
        f[i + m] += two * face[m]
        f[j + m] += three * face[m]
        power += face[m] * (one * v[h + m] + two * v[i + m] + three * v[j + m])
    return power
