"""Jets on surfaces, as scalar loops; what they do stands in ``tissuec.jets``.

Scratch of a triangle (``faces``): 0 normal along the jet, 3 its product with a corner, 4 cos θ,
5 area cos² θ of an element, 6 how much of a shade it throws, 7 where its corners are in ξ, in
turn to the left, 13 their middle, 15 their distance from there, 16 blur of the shade in ξ. Of
an element (``points``): 0 its place, 3 distance ahead, 4 where it is in ξ, 6 force on it.
"""

from math import exp, inf, pi, sqrt

from tissuec.kernels.acts import total
from tissuec.kernels.records import Floats, Jets, Net

CUT = 4.5
DEEP = 0.5
LIT, DARK = 0.3, 0.7
STEEP = 0.2
NEAR = 0.5
FLAT = 1e-6
SLACK = 2.0
TINY = 1e-200
GRID = 32  # cells along each side of the field in which triangles are sorted


def blow(time: float, x: Floats, v: Floats, f: Floats, power: Floats, net: Net) -> None:
    """Add the forces of jets to those on nodes, and the power that they put in."""
    acts, jets = net.acts, net.jets
    for jet in range(jets.bore.size):
        flow, _, _, _, _, _ = total(jets.act[jet], time, acts)
        if flow > 0.0:
            thrust = jets.density[jet] * flow * flow / (0.25 * pi * jets.bore[jet] ** 2)
            power[0] += recoil(jet, thrust, x, v, f, jets)
            count = survey(jet, x, jets)
            side = sort(count, jets)
            speed = sqrt(2.0 * thrust / (pi * jets.density[jet]))
            for k in range(count):
                if jets.faces[k, 5] > 0.0:
                    divide(jet, k, speed, x, v, jets)
                    dim(jet, k, before(k, side, x, jets), jets)
                    power[0] += push(k, v, f, jets)


def recoil(jet: int, thrust: float, x: Floats, v: Floats, f: Floats, jets: Jets) -> float:
    """Set the frame of a jet, push its opening back, and return the power of that [W]."""
    frame = jets.frame
    o, q = 3 * jets.opening[jet, 0], 3 * jets.opening[jet, 1]
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


def way(
    jet: int, p0: float, p1: float, p2: float, jets: Jets
) -> tuple[float, float, float, float]:
    """Return how far ahead a point is [m], b there [m], and where it is in ξ."""
    a = jets.frame
    r0, r1, r2 = p0 - a[0], p1 - a[1], p2 - a[2]
    ahead = r0 * a[3] + r1 * a[4] + r2 * a[5]
    width = sqrt(jets.width[jet] ** 2 + (jets.growth[jet] * ahead) ** 2)
    one = (r0 * a[6] + r1 * a[7] + r2 * a[8]) / width
    other = (r0 * a[9] + r1 * a[10] + r2 * a[11]) / width
    return ahead, width, one, other


def rise(part: float) -> float:
    """Return a smooth step from 0 at 0 to 1 at 1."""
    part = min(max(part, 0.0), 1.0)
    return part * part * (3.0 - 2.0 * part)


def survey(jet: int, x: Floats, jets: Jets) -> int:
    """List the triangles within a jet, and return how many there are."""
    corners, count = jets.corners, 0
    for t in range(jets.first[jet], jets.first[jet + 1]):
        i, j, k = 3 * corners[t, 0], 3 * corners[t, 1], 3 * corners[t, 2]
        m0 = (x[i] + x[j] + x[k]) / 3.0
        m1 = (x[i + 1] + x[j + 1] + x[k + 1]) / 3.0
        m2 = (x[i + 2] + x[j + 2] + x[k + 2]) / 3.0
        far = 0.0
        for c in (i, j, k):
            far = max(far, (x[c] - m0) ** 2 + (x[c + 1] - m1) ** 2 + (x[c + 2] - m2) ** 2)
        far = sqrt(far)
        ahead, width, one, other = way(jet, float(m0), float(m1), float(m2), jets)
        most = sqrt(jets.width[jet] ** 2 + (jets.growth[jet] * (abs(ahead) + far)) ** 2)
        off = sqrt(one * one + other * other) * width
        if ahead + far > 0.0 and off < CUT * most + far:
            jets.met[count] = t
            look(jet, count, t, x, jets)
            count += 1
    return count


def look(jet: int, k: int, t: int, x: Floats, jets: Jets) -> None:
    """Set what is known of a triangle within a jet."""
    face, frame, side = jets.faces[k], jets.frame, jets.side[t]
    h, i, j = 3 * jets.corners[t, 0], 3 * jets.corners[t, 1], 3 * jets.corners[t, 2]
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
    turned = jets.struck[t] and (side == 0 or side * slope < 0.0)
    part = 0.5 * size / (jets.shares_end[t] - jets.shares_start[t])
    face[4] = abs(slope)
    face[5] = part * slope * slope if turned else 0.0
    face[6] = rise(abs(slope) / STEEP)
    mean = 0.0
    place = 7
    for c in (h, i, j):
        p0, p1, p2 = float(x[c]), float(x[c + 1]), float(x[c + 2])
        _, width, one, other = way(jet, p0, p1, p2, jets)
        face[place], face[place + 1] = one, other
        mean += width / 3.0
        place += 2
    face[13] = (face[7] + face[9] + face[11]) / 3.0
    face[14] = (face[8] + face[10] + face[12]) / 3.0
    reach = 0.0
    for place in range(7, 13, 2):
        far = (face[place] - face[13]) ** 2 + (face[place + 1] - face[14]) ** 2
        reach = max(reach, far)
    face[15], face[16] = SLACK * sqrt(reach), jets.blur[t] / mean


def sort(count: int, jets: Jets) -> float:
    """Enter triangles into cells; return the size of these in ξ."""
    reach = span = 0.0
    for k in range(count):
        reach = max(reach, jets.faces[k, 15])
        span = max(span, jets.faces[k, 15] + jets.faces[k, 16])
    side = max(reach + span, 2.0 * CUT / GRID)
    for c in range(GRID * GRID):
        jets.head[c] = -1
    for k in range(count):
        i, j = cell(k, side, jets)
        jets.link[k] = jets.head[GRID * i + j]
        jets.head[GRID * i + j] = k
    return side


def cell(k: int, side: float, jets: Jets) -> tuple[int, int]:
    """Return where a triangle stands among cells of a size."""
    one, other = jets.faces[k, 13], jets.faces[k, 14]
    i, j = int((one + CUT) / side), int((other + CUT) / side)
    return min(max(i, 0), GRID - 1), min(max(j, 0), GRID - 1)


def divide(jet: int, k: int, speed: float, x: Floats, v: Floats, jets: Jets) -> None:
    """Set the elements of a triangle, as nothing shades them.

    Args:
        speed: On the axis, times b [m²/s].
    """
    frame, shares, t = jets.frame, jets.shares, jets.met[k]
    h, i, j = 3 * jets.corners[t, 0], 3 * jets.corners[t, 1], 3 * jets.corners[t, 2]
    start = jets.shares_start[t]
    for p in range(jets.shares_end[t] - start):
        s = start + p
        a, b, c = shares[s, 0], shares[s, 1], shares[s, 2]
        point = jets.points[p]
        away = 0.0
        for m in range(3):
            point[m] = a * x[h + m] + b * x[i + m] + c * x[j + m]
            away += frame[3 + m] * (a * v[h + m] + b * v[i + m] + c * v[j + m])
        p0, p1, p2 = float(point[0]), float(point[1]), float(point[2])
        ahead, width, one, other = way(jet, p0, p1, p2, jets)
        point[3], point[4], point[5] = ahead, one, other
        here = speed / width * exp(-(one * one + other * other))
        slower = min(away, here)
        left = here * (here - 2.0 * slower) + max(slower, 0.0) ** 2
        near = rise(ahead / (NEAR * jets.bore[jet]))
        point[6] = jets.density[jet] * left * near * jets.faces[k, 5]


def before(k: int, side: float, x: Floats, jets: Jets) -> int:
    """List the triangles that may shade one; return how many there are."""
    face, found = jets.faces[k], 0
    row, column = cell(k, side, jets)
    for i in range(max(row - 1, 0), min(row + 2, GRID)):
        for j in range(max(column - 1, 0), min(column + 2, GRID)):
            other = int(jets.head[GRID * i + j])
            while other >= 0:
                shade = jets.faces[other]
                one, two = face[13] - shade[13], face[14] - shade[14]
                span = face[15] + shade[15] + shade[16]
                if one * one + two * two < span * span and stands_before(k, other, x, jets):
                    jets.shades[found] = other
                    found += 1
                other = int(jets.link[other])
    return found


def stands_before(k: int, other: int, x: Floats, jets: Jets) -> bool:
    """Tell whether a corner of triangle k is behind another one, without a corner of both."""
    shade, corners = jets.faces[other], jets.corners
    t, u = jets.met[k], jets.met[other]
    behind = -inf
    for c in range(3):
        for d in range(3):
            if corners[t, c] == corners[u, d]:
                return False
        i = 3 * corners[t, c]
        level = shade[0] * x[i] + shade[1] * x[i + 1] + shade[2] * x[i + 2]
        behind = max(behind, level - shade[3])
    return bool(behind > FLAT * jets.blur[u])


def dim(jet: int, k: int, shades: int, jets: Jets) -> None:
    """Take from the forces on a triangle's elements what triangles before them take away."""
    t = jets.met[k]
    near = NEAR * jets.bore[jet]
    for p in range(jets.shares_end[t] - jets.shares_start[t]):
        point, covered = jets.points[p], 0.0
        for n in range(shades):
            other = jets.shades[n]
            shade = jets.faces[other]
            deep = point[0] * shade[0] + point[1] * shade[1] + point[2] * shade[2] - shade[3]
            start = point[3] * shade[4] - deep
            if deep > 0.0 and start > 0.0:
                cover = shade[6] * within(point, shade)
                if cover > 0.0:
                    cover *= rise(deep / (DEEP * jets.blur[jets.met[other]]))
                    covered += cover * rise(start / (shade[4] * near))
        point[6] *= 1.0 - rise((covered - LIT) / (DARK - LIT))


def within(point: Floats, shade: Floats) -> float:
    """Return how far an element is within the blurred edges of a triangle."""
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


def push(k: int, v: Floats, f: Floats, jets: Jets) -> float:
    """Add the forces on the elements of a triangle; return their power [W]."""
    face, t = jets.faces[k], jets.met[k]
    h, i, j = 3 * jets.corners[t, 0], 3 * jets.corners[t, 1], 3 * jets.corners[t, 2]
    one = two = three = 0.0
    start = jets.shares_start[t]
    for p in range(jets.shares_end[t] - start):
        s = start + p
        one += jets.shares[s, 0] * jets.points[p, 6]
        two += jets.shares[s, 1] * jets.points[p, 6]
        three += jets.shares[s, 2] * jets.points[p, 6]
    power = 0.0
    for m in range(3):
        f[h + m] += one * face[m]
        f[i + m] += two * face[m]
        f[j + m] += three * face[m]
        power += face[m] * (one * v[h + m] + two * v[i + m] + three * v[j + m])
    return power
