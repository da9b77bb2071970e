"""Jets on surfaces, as scalar loops; what they do stands in ``tissuec.jets``.

Scratch of a triangle (``faces``): normal along the jet, what it makes of its middle, the middle
beside the axis over b, how far elements and bumps reach from there, A cos² θ and A cos θ of an
element. Of an element (``points``): its place, the same beside the axis over b, the radius of its
bump over b, what it covers, and what pushes it.
"""

from math import exp, inf, pi, sqrt

from tissuec.kernels.acts import total
from tissuec.kernels.records import Acts, Floats, Jets

CUT = 4.5
DEEP = 0.25
LIT, DARK = 0.25, 0.75
STEEP = 0.2
NEAR = 0.5
FLAT = 1e-6
GRID = 32  # cells along each side of the field in which triangles are sorted


def blow(time: float, x: Floats, v: Floats, f: Floats, acts: Acts, jets: Jets) -> float:
    """Add the forces of jets to those on nodes; return the power that they put in [W]."""
    power = 0.0
    for jet in range(jets.bore.size):
        flow, _, _, _, _, _ = total(jets.act[jet], time, acts)
        if flow > 0.0:
            thrust = jets.density[jet] * flow * flow / (0.25 * pi * jets.bore[jet] ** 2)
            power += recoil(jet, thrust, x, v, f, jets)
            count = survey(jet, x, jets)
            speed = sqrt(2.0 * thrust / (pi * jets.density[jet]))
            side = divide(jet, count, speed, x, v, jets)
            sort(count, side, jets)
            power += push(count, side, x, v, f, jets)
    return power


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
    # Any two directions across the jet, to sort triangles by.
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
) -> tuple[float, float, float, float, float]:
    """Return how far ahead a point is [m], b there [m], and its place beside the axis over b."""
    frame = jets.frame
    e0, e1, e2 = float(frame[3]), float(frame[4]), float(frame[5])
    r0, r1, r2 = float(p0 - frame[0]), float(p1 - frame[1]), float(p2 - frame[2])
    ahead = r0 * e0 + r1 * e1 + r2 * e2
    width = sqrt(jets.width[jet] ** 2 + (jets.growth[jet] * ahead) ** 2)
    r0, r1, r2 = r0 - ahead * e0, r1 - ahead * e1, r2 - ahead * e2
    return ahead, width, r0 / width, r1 / width, r2 / width


def rise(part: float) -> float:
    """Return a smooth step from 0 at 0 to 1 at 1."""
    part = min(max(part, 0.0), 1.0)
    return part * part * (3.0 - 2.0 * part)


def survey(jet: int, x: Floats, jets: Jets) -> int:
    """List the triangles within a jet, and return how many there are."""
    frame, corners, faces = jets.frame, jets.corners, jets.faces
    count = 0
    for t in range(jets.first[jet], jets.first[jet + 1]):
        i, j, k = 3 * corners[t, 0], 3 * corners[t, 1], 3 * corners[t, 2]
        m0 = (x[i] + x[j] + x[k]) / 3.0
        m1 = (x[i + 1] + x[j + 1] + x[k + 1]) / 3.0
        m2 = (x[i + 2] + x[j + 2] + x[k + 2]) / 3.0
        far = 0.0
        for c in (i, j, k):
            far = max(far, (x[c] - m0) ** 2 + (x[c + 1] - m1) ** 2 + (x[c + 2] - m2) ** 2)
        far = sqrt(far)
        ahead, width, b0, b1, b2 = way(jet, m0, m1, m2, jets)
        most = sqrt(jets.width[jet] ** 2 + (jets.growth[jet] * (abs(ahead) + far)) ** 2)
        off = sqrt(b0 * b0 + b1 * b1 + b2 * b2)
        if ahead + far <= 0.0 or off * width >= CUT * most + far:
            continue
        p0, p1, p2 = x[j] - x[i], x[j + 1] - x[i + 1], x[j + 2] - x[i + 2]
        q0, q1, q2 = x[k] - x[i], x[k + 1] - x[i + 1], x[k + 2] - x[i + 2]
        n0, n1, n2 = p1 * q2 - p2 * q1, p2 * q0 - p0 * q2, p0 * q1 - p1 * q0
        size = sqrt(n0 * n0 + n1 * n1 + n2 * n2)
        inverse = 1.0 / size if size > 0.0 else 0.0
        slope = (n0 * frame[3] + n1 * frame[4] + n2 * frame[5]) * inverse
        if slope < 0.0:
            inverse = -inverse
        face, side = faces[count], jets.side[t]
        face[0], face[1], face[2] = n0 * inverse, n1 * inverse, n2 * inverse
        face[3] = face[0] * m0 + face[1] * m1 + face[2] * m2
        face[4], face[5], face[6] = b0, b1, b2
        part = 0.5 * size / (jets.shares_end[t] - jets.shares_start[t])
        turned = jets.struck[t] and (side == 0 or side * slope < 0.0)
        face[9] = part * slope * slope if turned else 0.0
        face[10] = part * abs(slope) * rise(abs(slope) / STEEP)
        face[10] *= 3.0 / (pi * jets.blur[t] ** 2)
        jets.met[count] = t
        count += 1
    return count


def divide(jet: int, count: int, speed: float, x: Floats, v: Floats, jets: Jets) -> float:
    """Set the elements of all triangles within a jet.

    Args:
        speed: On the axis, times b [m²/s].

    Returns:
        How far from one to another a triangle may shade, beside the axis over b.
    """
    frame, shares, points = jets.frame, jets.shares, jets.points
    widest = furthest = 0.0
    for k in range(count):
        t, face = jets.met[k], jets.faces[k]
        h, i, j = 3 * jets.corners[t, 0], 3 * jets.corners[t, 1], 3 * jets.corners[t, 2]
        reach = span = 0.0
        p = jets.begin[t]
        for s in range(jets.shares_start[t], jets.shares_end[t]):
            a, b, c = shares[s, 0], shares[s, 1], shares[s, 2]
            point = points[p]
            away = 0.0
            for m in range(3):
                point[m] = a * x[h + m] + b * x[i + m] + c * x[j + m]
                away += frame[3 + m] * (a * v[h + m] + b * v[i + m] + c * v[j + m])
            ahead, width, b0, b1, b2 = way(jet, point[0], point[1], point[2], jets)
            point[3], point[4], point[5] = b0, b1, b2
            point[6] = jets.blur[t] / width
            near = rise(ahead / (NEAR * jets.bore[jet]))
            point[7] = near * face[10]
            here = speed / width * exp(-(b0 * b0 + b1 * b1 + b2 * b2))
            slower = min(away, here)
            left = here * (here - 2.0 * slower) + max(slower, 0.0) ** 2
            point[8] = jets.density[jet] * left * near * face[9]
            off = sqrt((b0 - face[4]) ** 2 + (b1 - face[5]) ** 2 + (b2 - face[6]) ** 2)
            reach, span = max(reach, off), max(span, off + point[6])
            p += 1
        face[7], face[8] = reach, span
        widest, furthest = max(widest, reach), max(furthest, span)
    return max(widest + furthest, 2.0 * CUT / GRID)


def cell(k: int, side: float, jets: Jets) -> tuple[int, int]:
    """Return where a triangle stands among cells of a size."""
    face, frame = jets.faces[k], jets.frame
    one = face[4] * frame[6] + face[5] * frame[7] + face[6] * frame[8]
    other = face[4] * frame[9] + face[5] * frame[10] + face[6] * frame[11]
    i, j = int((one + CUT) / side), int((other + CUT) / side)
    return min(max(i, 0), GRID - 1), min(max(j, 0), GRID - 1)


def sort(count: int, side: float, jets: Jets) -> None:
    """Enter triangles into cells."""
    for c in range(GRID * GRID):
        jets.head[c] = -1
    for k in range(count):
        i, j = cell(k, side, jets)
        jets.link[k] = jets.head[GRID * i + j]
        jets.head[GRID * i + j] = k


def push(count: int, side: float, x: Floats, v: Floats, f: Floats, jets: Jets) -> float:
    """Add the forces on the triangles within a jet; return their power [W]."""
    power = 0.0
    for k in range(count):
        face, t = jets.faces[k], jets.met[k]
        if face[9] == 0.0:
            continue
        shades = before(k, side, x, jets)
        h, i, j = 3 * jets.corners[t, 0], 3 * jets.corners[t, 1], 3 * jets.corners[t, 2]
        p = jets.begin[t]
        for s in range(jets.shares_start[t], jets.shares_end[t]):
            size = jets.points[p, 8]
            if shades and size > 0.0:
                size *= light(k, p, shades, jets)
            a, b, c = jets.shares[s, 0], jets.shares[s, 1], jets.shares[s, 2]
            for m in range(3):
                force = size * face[m]
                f[h + m] += a * force
                f[i + m] += b * force
                f[j + m] += c * force
                power += force * (a * v[h + m] + b * v[i + m] + c * v[j + m])
            p += 1
    return power


def before(k: int, side: float, x: Floats, jets: Jets) -> int:
    """List the triangles that may shade one; return how many there are."""
    face, found = jets.faces[k], 0
    row, column = cell(k, side, jets)
    for i in range(max(row - 1, 0), min(row + 2, GRID)):
        for j in range(max(column - 1, 0), min(column + 2, GRID)):
            other = jets.head[GRID * i + j]
            while other >= 0:
                shade = jets.faces[other]
                d0, d1, d2 = face[4] - shade[4], face[5] - shade[5], face[6] - shade[6]
                span = face[7] + shade[8]
                if d0 * d0 + d1 * d1 + d2 * d2 < span * span:
                    least = FLAT * jets.blur[jets.met[other]]
                    behind = height(k, other, 1.0, x, jets) > least
                    if behind and height(other, k, -1.0, x, jets) > least:
                        jets.shades[found] = other
                        found += 1
                other = jets.link[other]
    return found


def height(k: int, other: int, sign: float, x: Floats, jets: Jets) -> float:
    """Return how far a corner of triangle k is behind the plane of another, or before it [m]."""
    plane, t, most = jets.faces[other], jets.met[k], -inf
    for c in range(3):
        i = 3 * jets.corners[t, c]
        level = plane[0] * x[i] + plane[1] * x[i + 1] + plane[2] * x[i + 2] - plane[3]
        most = max(most, sign * level)
    return most


def light(k: int, p: int, shades: int, jets: Jets) -> float:
    """Return the part of the jet that comes to an element of triangle k."""
    face, points = jets.faces[k], jets.points
    point, covered = points[p], 0.0
    for n in range(shades):
        other = jets.shades[n]
        shade, t = jets.faces[other], jets.met[other]
        depth = DEEP * jets.blur[t]
        start = jets.begin[t]
        for q in range(start, start + jets.shares_end[t] - jets.shares_start[t]):
            one = points[q]
            d0, d1, d2 = point[3] - one[3], point[4] - one[4], point[5] - one[5]
            gap = (d0 * d0 + d1 * d1 + d2 * d2) / (one[6] * one[6])
            if gap < 1.0:
                d0, d1, d2 = point[0] - one[0], point[1] - one[1], point[2] - one[2]
                deep = rise((d0 * shade[0] + d1 * shade[1] + d2 * shade[2]) / depth)
                deep *= rise((d0 * face[0] + d1 * face[1] + d2 * face[2]) / depth)
                covered += one[7] * deep * (1.0 - gap) ** 2
    return 1.0 - rise((covered - LIT) / (DARK - LIT))
