"""Velocity Verlet once more, with matrices of NumPy's long doubles: 64 bits of mantissa."""

import numpy as np
from scipy import sparse

LONG = np.longdouble


def positions(schedule, numbers, steps_of, times):
    """Return the places of all nodes at the ends of steps, shape (time, node, 3).

    Args:
        schedule: Legs, of which only what is frozen is used.
        numbers: Long doubles by name: mass, stiffness, damping, rest, position, velocity.
        steps_of: How many equal steps each leg has.
        times: Of samples, each at the end of a step [s].
    """
    x, v = numbers["position"].reshape(-1, 3), numbers["velocity"].reshape(-1, 3)
    found = [x] if times[0] == 0.0 else []
    for leg, count in zip(schedule.legs, steps_of, strict=True):
        x, v = _leg(leg, numbers, count, x, v, times, found)
    return np.array(found)


def _leg(leg, numbers, count, x, v, times, found):
    factors = {name: change.factor for name, change in leg.changes.items()}
    ends = leg.network.springs.ends[leg.alive]
    size, springs = len(x), len(leg.alive)
    rows = np.repeat(np.arange(springs), 2)
    signs = np.tile(np.array([-1.0, 1.0], dtype=LONG), springs)
    reach_of = sparse.csr_matrix((signs, (rows, ends.ravel())), shape=(springs, size))
    onto = sparse.csr_matrix(reach_of.T)
    c, d, rest = (
        (numbers[name] * factors.get(name, 1.0))[leg.alive]
        for name in ("stiffness", "damping", "rest")
    )
    free = ~leg.held
    grid = np.linspace(leg.start, leg.stop, count + 1)
    h = LONG((leg.stop - leg.start) / count)
    inside = np.clip(grid, leg.start + 1e-12 * h, leg.stop - 1e-12 * h).astype(float)

    def acceleration(x, v, time):
        reach = reach_of @ x
        length = np.sqrt((reach**2).sum(axis=1))
        n = reach / length[:, None]
        closing = (n * (reach_of @ v)).sum(axis=1)
        force = -(onto @ ((c * (length - rest) + d * closing)[:, None] * n))
        for load in leg.loads:
            np.add.at(force, load.nodes, load.at(time).astype(LONG))
        a = (force - leg.drag * v) / numbers["mass"][:, None] + leg.gravity
        return np.where(free[:, None], a, LONG(0.0))

    start = {m: m.at(inside[0])[0] for m in leg.motions}
    v = np.where(leg.stopped[:, None], leg.given.astype(LONG), v)
    begun, a = x, acceleration(x, v, inside[0])
    for row in range(count):
        time = inside[row + 1]
        x_end = np.where(free[:, None], x + h * v + h * h / 2 * a, x)
        guess = np.where(free[:, None], v + h * a, LONG(0.0))
        for motion in leg.motions:
            place, speed = motion.at(time)
            x_end[motion.nodes] = begun[motion.nodes] + (place - start[motion])
            guess[motion.nodes] = speed
        a_end = acceleration(x_end, guess, time)
        v = np.where(free[:, None], v + h / 2 * (a + a_end), guess)
        x, a = x_end, a_end
        if (np.abs(times - grid[row + 1]) < 1e-9 * h).any():
            found.append(x)
    return x, v
