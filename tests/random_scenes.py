"""Random scenes as text: a seed makes a net, a script, outputs and a tolerance.

Everything that tables and sentences can say is drawn from: lines, planes and spaces, sizes from
micrometres to kilometres, masses from a microgram to a ton, spring constants over four decades,
parallel springs, springs of no length, nodes without springs, several bodies, every verb and
profile, conditions, ruptures, events at equal times, at 0 s and at the end. Numbers are drawn
in units of the scene's own length, mass and duration, so that every scene moves by a part of
its size in a few periods and runs within a second.
"""

import numpy as np
from msgspec import Struct, field

AXES = ("x", "y", "z")
UNITS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "km": 1e3}
PROFILES = ("smooth profile", "constant speed", "ramp")


class View(Struct, frozen=True):
    """The same scene in other coordinates, units and order of rows.

    Attributes:
        rotation: Of everything about the origin, shape (3, 3).
        shift: Of everything after that, in lengths of the scene, shape (3,).
        unit: Of the tables of nodes and springs; None draws one.
        shuffle: Seed of another order of the rows of tables; None keeps it.
    """

    rotation: np.ndarray = field(default_factory=lambda: np.eye(3))
    shift: np.ndarray = field(default_factory=lambda: np.zeros(3))
    unit: str | None = None
    shuffle: int | None = None

    def direction(self, vector):
        return _written(self.rotation @ vector)

    def point(self, place, length):
        return _written(self.rotation @ place + self.shift * length)

    def rows(self, rows):
        if self.shuffle is None:
            return rows
        order = np.random.default_rng(self.shuffle).permutation(len(rows))
        return [rows[row] for row in order]


def _written(vector):
    return "(" + ", ".join(repr(float(part)) for part in vector) + ")"


class Draft(Struct):
    """A scene under way; ``length`` [m], ``mass`` [kg] and ``time`` [s] are its units.

    Attributes:
        count: Nodes of each body.
        pairs: Springs of each body as numbers of nodes from 0.
        stretch: A tension that its springs come to [N].
        wild: Whether springs may be pressed, or have no length: a motion that may be chaotic.
    """

    random: np.random.Generator
    dimension: int
    length: float
    mass: float
    time: float
    wild: bool
    view: "View"
    count: list[int] = field(default_factory=list)
    pairs: list[list[tuple[int, int]]] = field(default_factory=list)
    sets: list[str] = field(default_factory=list)
    spring_sets: list[str] = field(default_factory=list)
    lines: list[str] = field(default_factory=list)
    stretch: float = 0.0

    # --- draws --------------------------------------------------------------------------------

    def chance(self, share):
        return bool(self.random.random() < share)

    def pick(self, options):
        return options[int(self.random.integers(len(options)))]

    def decades(self, low, high):
        return float(10.0 ** self.random.uniform(low, high))

    def vector(self, size):
        """Return the text of a vector in as many directions as the scene has."""
        drawn = np.zeros(3)
        drawn[: self.dimension] = self.random.normal(size=self.dimension) * size
        return self.view.direction(drawn)

    def point(self, size):
        """Return the text of a point, as ``vector`` does [m]."""
        drawn = np.zeros(3)
        drawn[: self.dimension] = self.random.normal(size=self.dimension) * size
        return self.view.point(drawn, self.length)

    def moment(self):
        """Return a time [s]: at the start, at the end, on a coarse grid or anywhere."""
        kind = self.random.random()
        if kind < 0.15:
            return 0.0
        if kind < 0.2:
            return self.time
        if kind < 0.6:
            return self.time * int(self.random.integers(1, 10)) / 10
        return self.time * float(self.random.random())

    def interval(self):
        first, second = sorted((self.moment(), self.moment()))
        if second - first < 0.02 * self.time:
            second = first + 0.31 * self.time  # which may lie behind the end
        return f"from {first!r} s to {second!r} s:"


def random_scene(seed, *, extra_output="", view=None):
    """Return the text of the scene that a seed stands for.

    Args:
        extra_output: Further lines of the output block.
        view: How the same scene is written down otherwise.
    """
    random = np.random.default_rng(seed)
    draft = Draft(
        random,
        dimension=int(random.choice([1, 2, 3, 3])),
        length=float(10.0 ** random.uniform(-6, 3)),
        mass=float(10.0 ** random.uniform(-9, 3)),
        time=float(10.0 ** random.uniform(-4, 3)),
        wild=bool(random.random() < 0.15),
        view=view or View(),
    )
    bodies = [_body(draft, f"body {name}") for name in "ab"[: 1 + draft.chance(0.3)]]
    _sets(draft)
    fixed = [f"at 0 s: fix {draft.pick(draft.sets)}"] if draft.chance(0.6) else []
    script = script_of(draft, fixed, 8)
    return "\n".join(
        [
            "language 1",
            *bodies,
            *draft.lines,
            "tool forceps A { kind is forceps }",
            "tool shears { kind is scissors }",
            _environment(draft),
            script,
            _simulate(draft),
            output_of(draft, extra_output),
            "",
        ]
    )


# --- nets -------------------------------------------------------------------------------------


def _body(draft, name):
    random, count = draft.random, int(draft.random.integers(1, 9))
    place = np.zeros((count, 3))
    place[:, : draft.dimension] = random.normal(size=(count, draft.dimension))
    if draft.dimension == 1:  # in order, so that springs need not run through one another
        place[:, 0] = np.cumsum(random.uniform(0.3, 1.0, count))
    if draft.chance(0.3):
        place[:, : draft.dimension] += 3.0 * random.normal(size=draft.dimension)
    if draft.wild and count > 2 and draft.chance(0.3):
        place[-1] = place[0]
    pairs = _pairs(draft, place)
    draft.count.append(count)
    draft.pairs.append(pairs)
    key = name.removeprefix("body ")
    unit = draft.pick(list(UNITS))
    unit = draft.view.unit or unit
    scale = UNITS[unit]
    start = 0.0 if draft.chance(0.5) else 0.3 * draft.length / draft.time
    speed = np.zeros((count, 3))
    speed[:, : draft.dimension] = random.normal(size=(count, draft.dimension)) * start
    mass = draft.mass * 10.0 ** random.uniform(-1, 1, count)
    turned, view = draft.view.rotation.T, draft.view
    seen, moving = (place @ turned + view.shift) * draft.length / scale, speed @ turned
    nodes = [
        " ".join(map(_number, (number + 1, *seen[number], mass[number], *moving[number])))
        for number in range(count)
    ]
    springs = _springs(draft, place, mass, pairs)
    motion = []
    if draft.chance(0.25):
        motion.append(f"velocity = {draft.vector(0.3 * draft.length / draft.time)} m/s")
    if draft.dimension > 1 and draft.chance(0.25):
        turns = random.normal() * 2.0 / draft.time
        motion.append(f"spin = {view.direction(np.array([0, 0, turns]))} rad/s")
    rupture = "allowed" if draft.chance(0.5) else "not allowed"
    table = [
        f'table springs of {key} in {unit} with columns "id a b spring constant in N/m '
        'viscosity in N*s/m rest length breaking force in N" {',
        *(
            " ".join([*row[:5], _number(float(row[5]) / scale), row[6]])
            for row in view.rows(springs)
        ),
        "}",
    ]
    return "\n".join(
        [
            f"{name} {{ mesh is explicit; rupture is {rupture}; {'; '.join(motion)} }}",
            f'table nodes of {key} in {unit} with columns "id x y z mass in kg vx in m/s '
            'vy in m/s vz in m/s" {',
            *view.rows(nodes),
            "}",
            *(table if springs else []),
        ]
    )


def _number(value):
    return str(value) if isinstance(value, int) else repr(float(value))


def _pairs(draft, place):
    """Return a tree of the nodes, further springs, and doubles of some."""
    random, count = draft.random, len(place)
    pairs = []
    for node in range(1, count):
        if draft.chance(0.06):
            continue  # another piece, or a node without springs
        others = [node - 1] if draft.dimension == 1 else list(range(node))
        pairs.append((draft.pick(others), node))
    if count > 2 and draft.dimension > 1:
        for _ in range(int(random.integers(0, 2 * count))):
            a, b = (int(i) for i in random.choice(count, 2, replace=False))
            pairs.append((a, b))
    if pairs and draft.chance(0.2):
        a, b = draft.pick(pairs)
        pairs.append((b, a))
    no_length = [p for p in pairs if np.array_equal(place[p[0]], place[p[1]])]
    return [p for p in pairs if draft.wild or p not in no_length]


def _springs(draft, place, mass, pairs):
    """Return the rows of the table, as texts."""
    random = draft.random
    fastest = random.uniform(3.0, 60.0) / draft.time
    ratio = draft.pick([0.0, 0.5, 2.0, 4.0])
    damped = draft.pick([None, (-3.0, -0.5), (-0.5, 0.6)])
    rows = []
    for number, (a, b) in enumerate(pairs, start=1):
        light = min(mass[a], mass[b])
        constant = light * fastest**2 * 10.0 ** random.uniform(-ratio, 0.0)
        viscosity = 0.0
        if damped is not None and draft.chance(0.8):
            viscosity = 2.0 * 10.0 ** random.uniform(*damped) * np.sqrt(constant * light)
        drawn = float(np.linalg.norm(place[b] - place[a])) * draft.length
        press = random.uniform(-0.5, 0.3) if draft.wild else random.uniform(-0.03, 0.25)
        rest = drawn * (1.0 - press)
        if draft.wild and draft.chance(0.1):
            rest = 0.0
        strength = constant * (drawn + 0.1 * draft.length) * 10.0 ** random.uniform(-1.0, 0.5)
        draft.stretch = max(draft.stretch, 0.1 * constant * draft.length)
        numbers = (constant, viscosity, rest, strength)
        rows.append([str(number), str(a + 1), str(b + 1), *(repr(float(n)) for n in numbers)])
    return rows


def _sets(draft):
    for body, (count, pairs) in enumerate(zip(draft.count, draft.pairs, strict=True)):
        key = "ab"[body]
        for number in range(int(draft.random.integers(1, 4))):
            size = int(draft.random.integers(1, max(2, count // 2 + 1)))
            nodes = sorted(int(i) + 1 for i in draft.random.choice(count, size, replace=False))
            draft.sets.append(f"{key}{number}")
            draft.lines.append(f"set {key}{number} = nodes of {key} in {nodes}")
        if pairs:
            size = int(draft.random.integers(1, len(pairs) + 1))
            ids = sorted(int(i) + 1 for i in draft.random.choice(len(pairs), size, False))
            draft.spring_sets.append(f"bars {key}")
            draft.lines.append(f"set bars {key} = springs of {key} in {ids[:3]}")


# --- what happens -----------------------------------------------------------------------------


def _environment(draft):
    pull = draft.vector(draft.pick([0.0, 0.0, 0.5]) * draft.length / draft.time**2)
    drag = draft.pick([0.0, 0.0, 1.0]) * draft.mass / draft.time
    return f"environment {{ gravity = {pull} m/s^2; contact is off; damping = {drag!r} N*s/m }}"


def script_of(draft, lines, most):
    """Return the text of a script of given lines and of less than so many others."""
    lines = [*lines, *(_timed(draft) for _ in range(int(draft.random.integers(0, most))))]
    if draft.chance(0.35):
        # What follows is one order at once and one later.
        inner = f"{{ {_order(draft)}; after {0.1 * draft.time!r} s: {_order(draft)} }}"
        lines.append(f"when {_condition(draft)}: {inner}")
    return "script {\n  " + "\n  ".join(lines) + "\n}"


def _timed(draft):
    kind = draft.random.random()
    if kind < 0.35:
        return f"at {draft.moment()!r} s: {_order(draft)}"
    if kind < 0.45:
        first, every = draft.moment(), draft.random.uniform(0.05, 0.3) * draft.time
        return f"from {first!r} s to {first + 0.4 * draft.time!r} s every {every!r} s: " + (
            f"{{ after 0 s: {_order(draft)}; after {0.5 * every!r} s: {_order(draft)} }}"
        )
    return f"{draft.interval()} {_lasting(draft)}"


def _holder(draft):
    return draft.pick([*draft.sets, "forceps A"])


def _lasting(draft):
    """Return an order for an interval."""
    target, profile = _holder(draft), draft.pick(PROFILES)
    match int(draft.random.integers(5)):
        case 0 | 1:
            by = draft.vector(0.2 * draft.length)
            wave = f"sine of {draft.random.uniform(0.5, 4.0) / draft.time!r} Hz"
            return f"move {target} by {by} m using {draft.pick([profile, wave])}"
        case 2:
            through = ""
            if draft.chance(0.4):
                through = f"through {draft.point(draft.length)} m"
            angle = draft.random.normal() * 40.0
            axis = np.array([0, 0, 1] if draft.dimension == 2 else [1, 0.3, -0.2])
            around = draft.view.direction(axis)
            if draft.dimension == 1:
                return f"hold {draft.pick(draft.sets)}"
            return f"turn {target} by {angle!r} deg around {around} {through} using {profile}"
        case 3:
            return f"hold {draft.pick(draft.sets)}"
    profile = draft.pick(
        [
            "using constant",
            "using ramp",
            "using smooth profile",
            f"using sine of {draft.random.uniform(0.5, 4.0) / draft.time!r} Hz",
        ]
    )
    return f"push {draft.pick(draft.sets)} with {_force(draft)} {profile}"


def _force(draft):
    size = draft.mass * draft.length / draft.time**2
    return f"{draft.vector(size * draft.decades(-1.0, 1.0))} N"


def _order(draft):
    """Return an order for one moment."""
    group = draft.pick(draft.sets)
    match int(draft.random.integers(13)):
        case 0:
            return f"fix {group}"
        case 1:
            return f"free {group}"
        case 2:
            return f"hold {group}"
        case 3 | 4:
            return f"grasp {group} with forceps A"
        case 5:
            return draft.pick([f"release {group}", "release forceps A"])
        case 6:
            return f"push {group} with {_force(draft)}"
        case 7:
            return f"stop {draft.pick(['pushing', 'moving', 'turning'])} {group}"
        case 8 | 9:
            return _cut(draft)
    return _change(draft)


def _cut(draft):
    key = draft.pick("ab"[: len(draft.count)])
    if draft.spring_sets and draft.chance(0.4):
        return f"cut {draft.pick(draft.spring_sets)}"
    place = f"{draft.point(0.7 * draft.length)} m"
    if draft.dimension < 3 or draft.chance(0.5):
        return f"cut {key} along plane through {place} facing {draft.vector(1.0)} with shears"
    sweep = draft.view.direction(np.array([0.1, 1.0, 2.0]) * draft.length)
    return f"cut {key} along stroke from {place} to {draft.point(draft.length)} m by {sweep} m"


def _change(draft):
    group, key = draft.pick(draft.sets), draft.pick("ab"[: len(draft.count)])
    speed = draft.length / draft.time
    options = [
        f"gravity to {draft.vector(speed / draft.time)} m/s^2",
        f"damping to {draft.mass / draft.time * draft.random.uniform(0.0, 2.0)!r} N*s/m",
        f"mass of {group} by {draft.random.uniform(0.5, 2.0)!r}",
        f"velocity of {group} to {draft.vector(0.3 * speed)} m/s",
    ]
    if draft.dimension > 1:
        spin = np.array([0, 0, draft.random.normal() / draft.time])
        options.append(f"spin of {key} to {draft.view.direction(spin)} rad/s")
    if draft.spring_sets:
        bars = draft.pick(draft.spring_sets)
        factor = draft.random.uniform(0.5, 2.0)
        options += [
            f"{what} of {bars} by {factor!r}"
            for what in ("spring constant", "viscosity", "rest length", "breaking force")
        ]
    return f"change {draft.pick(options)}"


def _condition(draft):
    key, group = draft.pick("ab"[: len(draft.count)]), draft.pick(draft.sets)
    speed = 0.5 * draft.length / draft.time
    ahead = draft.view.rotation @ np.array([1.0, 0.0, 0.0])
    start = float(ahead @ draft.view.shift) * draft.length
    along = f"along {_written(ahead)}"
    options = [
        f"speed({key}) > {speed!r} m/s",
        f"position({group} {along}) > {start + 0.3 * draft.length!r} m",
        f"force({group}) > {float(max(draft.stretch, 1e-30))!r} N",
        f"ruptured({key})",
        f"position({group} {along}) < {start!r} m and speed({key}) > {0.2 * speed!r} m/s",
    ]
    return draft.pick(options)


# --- how it is run ----------------------------------------------------------------------------


def _simulate(draft):
    tolerance = draft.decades(-9.0, -3.0)
    method = draft.pick(["automatic", "automatic", "dop853", "velocity verlet"])
    if method == "velocity verlet" or draft.chance(0.1):
        tolerance = draft.decades(-4.0, -1.5)
    return (
        f"simulate {{ duration = {draft.time!r} s; integrator is {method}; "
        f"tolerance = {tolerance!r} }}"
    )


def output_of(draft, extra):
    """Return the text of the output block, with further lines."""
    every = draft.time / draft.random.uniform(5.0, 60.0)
    if draft.chance(0.3):
        every = draft.time / int(draft.random.integers(3, 40))
    group = draft.pick(draft.sets)
    lines = [f"trajectory every {every!r} s"]
    if draft.chance(0.5):
        lines.append(f"force of {group} every {draft.time / 17.3!r} s")
    if draft.chance(0.3):
        lines.append(f"speed of {group} every {draft.time / 7!r} s")
    return "output {\n  " + "\n  ".join([*lines, *([extra] if extra else [])]) + "\n}"
