"""Random scenes of bodies that meet tools, one another and themselves, as text.

They extend ``tests.random_scenes`` by what has a shape: solids, walls, balls, tubes and
threads, of matter or of springs, tools, friction, preserved volumes and jets. Sizes, speeds and
times are drawn in units of the length of a body and of the time that a wave takes through it,
so that each scene meets something within a few periods and runs within a second.
"""

from math import sqrt

import numpy as np
from msgspec import field

from tests.random_scenes import PROFILES, Draft, View, output_of, script_of

WALLS = ("sheet", "ball", "tube")
SHAPES = ("block", "block", *WALLS, "thread", "cloud")
CRYSTALS = ("sodium chloride", "caesium chloride", "diamond", "braced cubes")
#: How a body comes to touch something: it is thrown or falls on a tool, a tool comes down on
#: it, or it is thrown on another body.
MEETINGS = ("thrown", "falling", "pressed", "on another", "on another")
UP = np.array([0.0, 0.0, 1.0])
THICKNESS = 0.1  # of contact, in lengths


class Touching(Draft, kw_only=True):
    """A scene under way, upright.

    Attributes:
        modulus: Young's modulus of its matter [Pa].
        speed: Of waves through it [m/s].
        height: Of all that lies one on top of the other so far [m].
        shells: Volumes of balls [m³], by name.
        is_surface: Whether all bodies have one.
    """

    modulus: float
    speed: float
    height: float = 0.0
    shells: dict[str, float] = field(default_factory=dict)
    is_surface: bool = True

    @property
    def middle(self):
        """Return a place near the axis of the bodies, at height 0 [m]."""
        return np.array([0.5, 0.5, 0.0]) * self.length + self.across(0.1 * self.length)

    def about(self, low, high):
        """Return a number between two, evenly by its logarithm."""
        return self.decades(np.log10(low), np.log10(high))

    def across(self, size):
        """Return a horizontal vector."""
        return np.array([*self.random.normal(size=2) * size, 0.0])


def touching_scene(seed, *, extra_output=""):
    """Return the text of the scene that a seed stands for.

    Args:
        seed: If it is odd, contact begins during the run, otherwise at 0 s.
        extra_output: Further lines of the output block.
    """
    random = np.random.default_rng([seed, 1])
    length, modulus = 10.0 ** random.uniform(-3.0, -1.0), 10.0 ** random.uniform(3.0, 6.0)
    speed = sqrt(modulus / 1000.0)
    draft = Touching(
        random=random,
        dimension=3,
        length=length,
        mass=1000.0 * length**3,
        time=random.uniform(2.0, 6.0) * length / speed,
        wild=False,
        view=View(),
        modulus=modulus,
        speed=speed,
    )
    meeting = draft.pick(MEETINGS)
    approach = draft.about(0.05, 0.2) * speed
    # The way of the gap takes up to a third of the run.
    later = approach * draft.time * random.uniform(0.05, 0.3)
    gap = later if seed % 2 else -0.03 * length
    bodies, lines, gravity = _met(draft, meeting, gap, approach)
    lines = [*lines, *_fluids(draft)]
    if draft.chance(0.2):
        lines.append(f"at 0 s: fix {draft.pick(draft.sets)}")
    return "\n".join(
        [
            "language 1",
            *bodies,
            *draft.lines,
            "tool forceps A { kind is forceps }",
            "tool shears { kind is scissors }",
            _environment(draft, gravity),
            script_of(draft, lines, 3),
            f"simulate {{ duration = {draft.time!r} s; "
            f"tolerance = {draft.pick(['1e-3', '1e-4', '1e-5'])} }}",
            output_of(draft, extra_output),
            "",
        ]
    )


def _met(draft, meeting, gap, approach):
    """Return texts of bodies, sentences that move them, and gravity [m/s²]."""
    thrown = draft.across(0.5 * approach) - approach * UP
    fall = 2.0 * max(gap, 0.02 * draft.length) / (0.3 * draft.time) ** 2
    match meeting:
        case "thrown":
            _obstacle(draft)
            return [_body(draft, "a", gap, thrown)], [], 0.0
        case "falling":
            _obstacle(draft)
            return [_body(draft, "a", gap, draft.across(approach))], [], fall
        case "pressed":
            body = _body(draft, "a")
            return [body], [_held(draft), *_press(draft, gap)], 0.0
    lower, held = _body(draft, "a", shapes=SHAPES[:-1]), _held(draft)
    upper = _body(draft, "b", gap + THICKNESS * draft.length, thrown)
    return [lower, upper], [held], fall * draft.chance(0.3)


def _held(draft):
    """Return the sentence that holds the only body so far, but not the whole of it."""
    is_flat = draft.height < 0.3 * draft.length
    return f"at 0 s: fix {'a0' if is_flat else draft.pick(['base a', 'a0'])}"


def _written(vector):
    return "(" + ", ".join(repr(float(part)) for part in vector) + ")"


# --- tools ------------------------------------------------------------------------------------


def _obstacle(draft):
    """Add a tool below height 0, where it just does not touch a body."""
    normal = UP + draft.across(0.2)
    shape = draft.pick(["plane", "plane", "ball", "rod"])
    draft.lines.append(f"tool anvil {{ {_tool(draft, shape, -UP, 0.0, normal)} }}")


def _press(draft, gap):
    """Add a tool above all; return sentences that press and stroke with it."""
    shape = draft.pick(["plane", "ball", "rod", "hook"])
    draft.lines.append(f"tool press {{ {_tool(draft, shape, UP, draft.height + gap, -UP)} }}")
    start, middle = 0.1 * draft.time * draft.random.random(), draft.time * 0.6
    down = -(gap + draft.random.uniform(0.05, 0.25) * draft.length) * UP
    profile, stroke = draft.pick(PROFILES), draft.across(0.2 * draft.length)
    yield f"from {start!r} s to {middle!r} s: move press by {_written(down)} m using {profile}"
    if draft.chance(0.6):
        yield (
            f"from {middle!r} s to {draft.time!r} s: move press by {_written(stroke)} m "
            "using smooth profile"
        )


def _tool(draft, shape, behind, height, normal):
    """Return entries of a tool that reaches to a height [m] from the side ``behind`` it."""
    radius = draft.about(0.3, 2.0) * draft.length
    centre = draft.middle + height * UP + radius * behind
    along = draft.across(1.0)
    along *= 2.0 * draft.length / np.linalg.norm(along)
    start, end = _written(centre - along), _written(centre + along)
    match shape:
        case "plane":  # through the corner of a square around the bodies, whichever is nearest
            low = draft.length * np.maximum(-normal[:2], 0.0).sum()
            point = _written((height - low * (normal[2] > 0.0)) * UP)
            return f"kind is plane; point = {point} m; normal = {_written(normal)}"
        case "ball":
            return f"kind is probe; radius = {radius!r} m; centre = {_written(centre)} m"
        case "rod":
            return f"kind is probe; radius = {radius!r} m; axis from {start} m to {end} m"
    handle = _written(centre - along + 3.0 * draft.length * behind)
    shaft = f"shaft from {handle} m to {start} m; bend = {end} m"
    return f"kind is hook; radius = {radius!r} m; {shaft}"


# --- bodies -----------------------------------------------------------------------------------


def _body(draft, name, gap=0.0, velocity=None, shapes=SHAPES):
    """Return a body above all others, with its tissue."""
    shape, bottom = draft.pick(shapes), draft.height + gap
    is_matter = shape not in ("thread", "cloud") and draft.chance(0.75)
    tissue = _matter(draft, shape) if is_matter else _springs(draft)
    mesh, draft.height = _mesh(draft, name, shape, bottom)
    entries = [f"mesh is {mesh}", f"tissue is {name} tissue"]
    if "breaking" in tissue:
        entries.append("rupture is allowed")
    if shape in WALLS:
        entries.append("bending is stiff" * draft.chance(0.8))
        thickness = draft.random.uniform(0.03, 0.15) * draft.length
        entries.append(f"thickness = {thickness!r} m" * is_matter)
    if velocity is not None:
        spin = draft.random.normal(size=3) * 0.03 * draft.speed / draft.length
        entries.append(f"velocity = {_written(velocity)} m/s")
        entries.append(f"spin = {_written(spin)} rad/s" * draft.chance(0.3))
    draft.count.append(1)
    draft.pairs.append([])
    draft.is_surface &= shape not in ("thread", "cloud")
    low, high = bottom + 0.1 * draft.length, draft.height - 0.1 * draft.length
    middle = low + 0.3 * (draft.height - bottom)
    draft.lines += [
        f"set base {name} = nodes of {name} where z < {middle!r} m",
        f"set {name}0 = nodes of {name} where x < {0.31 * draft.length!r} m",
        f"set {name}1 = nodes of {name} where z > {high!r} m",
    ]
    draft.sets += [f"base {name}", f"{name}0", f"{name}1"]
    table = _cloud(draft, name, bottom) if shape == "cloud" else ""
    kept = "; ".join(filter(None, entries))
    return f"tissue {name} tissue {{ {tissue} }}\nbody {name} {{ {kept} }}\n{table}"


def _mesh(draft, name, shape, bottom):
    """Return the text of a mesh that stands on a height, and its top [m]."""
    side, random = draft.length, draft.random
    low, middle = bottom * UP, np.array([0.5 * side, 0.5 * side, 0.0])
    rise = 0.3 * side * random.random()
    match shape:
        case "block":
            kind = draft.pick(CRYSTALS)
            cells = random.integers(1, 2 if kind == "diamond" else 4, 3)
            cell = float(side / cells[:2].max())
            high = low + cells * cell
            return (
                f"lattice {{ kind is {kind}; reach is second neighbours; "
                f"cell = {cell!r} m; box from {_written(low)} m to {_written(high)} m }}"
            ), float(high[2])
        case "sheet":
            columns, rows = random.integers(3, 5, 2)
            return (
                f"sheet {{ corner = {_written(low)} m; first edge = ({side!r}, 0, {rise!r}) m; "
                f"second edge = (0, {side!r}, 0) m; columns = {columns}; rows = {rows}; "
                "diagonals is both }"
            ), bottom + rise
        case "ball":
            finer, centre = draft.pick([0, 1]), middle + (bottom + 0.5 * side) * UP
            draft.shells[name] = (2.536, 3.659)[finer] * (0.5 * side) ** 3
            return (
                f"sphere {{ centre = {_written(centre)} m; radius = {0.5 * side!r} m; "
                f"subdivisions = {finer} }}"
            ), bottom + side
        case "tube":
            radius = random.uniform(0.2, 0.4) * side
            start = np.array([0.0, 0.5 * side, bottom + radius])
            end = start + np.array([side, 0.0, 0.0])
            rings, sides = random.integers(3, 5), random.integers(5, 8)
            return (
                f"tube {{ axis from {_written(start)} m to {_written(end)} m; "
                f"radius = {radius!r} m; rings = {rings}; sides = {sides}; diagonals is both }}"
            ), bottom + 2.0 * radius
        case "thread":
            thick = random.uniform(0.05, 0.15) * side
            start = np.array([0.0, 0.5 * side, bottom + 0.5 * thick])
            end = start + np.array([side, 0.0, rise])
            return (
                f"thread {{ line from {_written(start)} m to {_written(end)} m; "
                f"pieces = {random.integers(3, 9)}; thickness = {thick!r} m }}"
            ), float(end[2] + 0.5 * thick)
    return "explicit", bottom + side


def _cloud(draft, name, bottom):
    """Return the tables of a few points, each joined to most others."""
    place = draft.random.uniform(0.0, draft.length, (int(draft.random.integers(3, 8)), 3))
    place[[0, -1]] = draft.length * np.array([[0.5, 0.5, 0.0], [0.0, 0.0, 1.0]])
    rows = [" ".join(map(repr, map(float, at + bottom * UP))) for at in place]
    pairs = [(i, j) for i in range(len(place)) for j in range(i) if j == 0 or draft.chance(0.7)]
    return (
        f'table nodes of {name} in m with columns "x y z" {{ {"; ".join(rows)} }}\n'
        f'table springs of {name} with columns "a b" '
        f"{{ {'; '.join(f'{i + 1} {j + 1}' for i, j in pairs)} }}"
    )


def _lag(draft):
    """Return how long dashpots take [s]: not at all, a little, or many periods."""
    ranges = (0.0, 0.0), (1e-3, 1e-1), (1.0, 100.0)
    low, high = draft.pick(ranges)
    return draft.about(low, high) * draft.length / draft.speed if high else 0.0


def _springs(draft):
    """Return entries of a tissue in numbers for each spring and node."""
    constant = 0.3 * draft.modulus * draft.length * draft.about(0.3, 3.0)
    entries = [
        f"spring constant = {constant!r} N/m; viscosity = {constant * _lag(draft)!r} N*s/m",
        f"mass = {0.03 * draft.mass * draft.about(0.3, 3.0)!r} kg",
        "spring law is tension only" * draft.chance(0.15),
        f"prestress = {draft.random.uniform(-3.0, 10.0)!r} %" * draft.chance(0.15),
        f"breaking force = {0.05 * constant * draft.length!r} N" * draft.chance(0.15),
    ]
    return "; ".join(filter(None, entries))


def _matter(draft, shape):
    """Return entries of a tissue with a density, and times for what is viscous."""
    relaxing = draft.about(0.1, 3.0) * draft.length / draft.speed
    entries = [
        f"spring constant = {0.3 * draft.modulus * draft.length * draft.about(0.3, 3.0)!r} N/m",
        "density = 1000 kg/m^3",
        f"retardation time = {_lag(draft)!r} s",
        f"relaxing share = 0.5; relaxation time = {relaxing!r} s" * draft.chance(0.1),
        "breaking strain = 30 %" * draft.chance(0.15),
    ]
    return "; ".join(filter(None, entries))


# --- what acts on them ------------------------------------------------------------------------


def _environment(draft, gravity):
    many = len(draft.count) > 1
    what = draft.pick(["bodies too", "everywhere"] if many else ["tools only", "everywhere"])
    stiff = draft.modulus / draft.length * draft.about(1.0, 30.0)
    rate = draft.about(0.01, 1.0) * draft.speed / draft.length
    entries = [
        f"gravity = (0, 0, {-gravity!r}) m/s^2",
        f"contact is {what}",
        f"contact thickness = {THICKNESS * draft.length!r} m" * (what != "tools only"),
        f"friction = {draft.random.uniform(0.05, 1.0)!r}" * draft.chance(0.8),
        f"contact damping = {draft.about(0.1, 10.0) / draft.speed!r} s/m" * draft.chance(0.4),
        f"contact surface stiffness = {stiff!r} Pa/m" * draft.chance(0.5) * draft.is_surface,
        f"contact layer = {draft.about(0.01, 0.1) * draft.length!r} m" * draft.chance(0.5),
        f"mass damping = {rate!r} Hz" * draft.chance(0.3),
    ]
    return f"environment {{ {'; '.join(filter(None, entries))} }}"


def _fluids(draft):
    """Yield sentences about volumes that are preserved and filled, and about a jet."""
    for name, volume in draft.shells.items():
        if draft.chance(0.6):
            firm = draft.modulus * draft.about(0.1, 3.0)
            yield f"at 0 s: preserve volume of {name} with {firm!r} Pa"
            more = volume * draft.random.uniform(0.9, 1.2)
            filled = f"inflate {name} to {more!r} m^3 using smooth profile"
            yield f"{draft.interval()} {filled}"
    if draft.is_surface and draft.chance(0.15):
        # A flow whose thrust presses a hundredth of the modulus on the area of its bore.
        bore = 0.3 * draft.length
        flow = 0.25 * np.pi * bore**2 * sqrt(0.01) * draft.speed
        draft.lines.append(
            f"tool nozzle {{ kind is nozzle; diameter = {bore!r} m; direction = (0, 0, -1); "
            f"tip = {_written(draft.middle + (draft.height + draft.length) * UP)} m }}"
        )
        yield f"{draft.interval()} irrigate with {flow!r} m^3/s through nozzle"
