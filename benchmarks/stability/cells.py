"""The scenes of the stress test, as a user would write them, along one axis each."""

from collections.abc import Callable, Iterator
from math import pi, sqrt

from msgspec import Struct

TOLERANCE = 1e-4
STIFFNESS, MASS = 400.0, 1e-3  # c [N/m], m [kg] of what is not varied
SWING = sqrt(STIFFNESS / MASS)  # ω of one mass on one spring [1/s]
DAMPING = 0.063  # d [N s/m]: a damping ratio of 0.05
FRAMES = 20


class Cell(Struct, frozen=True):
    """One scene.

    Attributes:
        axis: What is varied.
        value: How far, in words or as a number.
        scene: The text but for ``simulate``.
        duration: [s].
        step: Fixed step [s]; None for the tolerance.
        rests: Whether there may be a state in which it comes to rest.
    """

    axis: str
    value: str
    scene: str
    duration: float
    step: float | None = None
    rests: bool = True

    def text(self, method: str) -> str:
        """Return the scene, to be run by a method."""
        name = method if "-" not in method else f'"{method}"'
        limit = f"tolerance = {TOLERANCE!r}" if self.step is None else f"step = {self.step!r} s"
        return f"""language 1
{self.scene}
simulate {{ duration = {self.duration!r} s; integrator is {name}; {limit} }}
output {{ trajectory every {self.duration / FRAMES!r} s }}
"""


Axis = Callable[[bool], Iterator[Cell]]


def all_cells(*, small: bool) -> Iterator[Cell]:
    """Yield the cells of all axes; a few of each if they shall be ``small``."""
    for axis in AXES:
        yield from axis(small)


def stiffness_ratio(small: bool) -> Iterator[Cell]:
    """One ring of a tube harder than the rest."""
    for ratio in (1e4,) if small else (1.0, 1e2, 1e4, 1e6, 1e8):
        scene = tube(ring=f"spring constant = {STIFFNESS * ratio!r} N/m")
        yield Cell("stiffness ratio", f"{ratio:g}", scene, 0.2)


def mass_ratio(small: bool) -> Iterator[Cell]:
    """One ring of a tube lighter than the rest."""
    for ratio in (1e3,) if small else (1.0, 1e2, 1e4, 1e6):
        scene = tube(ring=f"mass = {MASS / ratio!r} kg")
        yield Cell("mass ratio", f"{ratio:g}", scene, 0.2)


def damping_ratio(small: bool) -> Iterator[Cell]:
    """All springs of a tube with stronger dashpots."""
    for ratio in (0.0, 10.0) if small else (0.0, 0.1, 1.0, 10.0, 100.0, 1000.0):
        viscosity = 2.0 * ratio * sqrt(STIFFNESS * MASS)
        yield Cell("damping ratio", f"{ratio:g}", tube(viscosity=viscosity), 0.2)


def frame_length(small: bool) -> Iterator[Cell]:
    """The time between two frames against the swinging of one mass."""
    for turns in (1e-3, 1e2) if small else (1e-3, 1e-1, 1e1, 1e3, 1e4, 1e6):
        yield Cell("frame × ω", f"{turns:g}", tube(), FRAMES * turns / SWING)


def compression(small: bool) -> Iterator[Cell]:
    """A free tube that is drawn smaller than its springs would be."""
    for percent in (50,) if small else (20, 50, 80, 99):
        scene = tube(wall=f"prestress = {-percent} %", fixed=False)
        yield Cell("pre-compression", f"-{percent} %", scene, 0.2)


def coincident_nodes(small: bool) -> Iterator[Cell]:
    """Nodes at one place, or on their way through each other."""
    scenes = {
        "no rest length": net(("0 0 0 0", "1 0 0 0", "2 10 0 0"), ("0 1 0", "1 2 10")),
        "a rest length": net(("0 0 0 0", "1 0 0 0", "2 10 0 0"), ("0 1 5", "1 2 10")),
        "all at one place": net(("0 0 0 0", "1 0 0 0", "2 0 0 0"), ("0 1 5", "1 2 5")),
        "through each other": net(
            ("0 0 0 0", "1 10 0 0"), ("0 1 10",), speeds=(0.0, -20.0), gravity=0.0
        ),
        "past each other": net(
            ("0 0 0 0", "1 10 1e-6 0"), ("0 1 10",), speeds=(0.0, -20.0), gravity=0.0
        ),
    }
    names = ("a rest length", "through each other") if small else tuple(scenes)
    for name in names:
        yield Cell("coincident nodes", name, scenes[name], 0.1)


def mechanisms(small: bool) -> Iterator[Cell]:
    """Nets that can move without any spring being stretched."""
    beads = [f"{i} {10 * i} 0 0" for i in range(8)]
    links = [f"{i} {i + 1} 10" for i in range(7)]
    scenes = {
        "pendulum": net(("0 0 0 0", "1 10 0 0"), ("0 1 10",), held=True, stiffness=4e4),
        "chain": net(beads, links, held=True),
        "sheet without diagonals": SHEET,
        "a node without springs": net(("0 0 0 0", "1 10 0 0", "2 20 0 0"), ("0 1 10",)),
        "spinning": tube(extra="spin = (30, 20, 10) rad/s", fixed=False, viscosity=0.0),
    }
    names = ("pendulum", "spinning") if small else tuple(scenes)
    for name in names:
        yield Cell("mechanisms", name, scenes[name], 0.3)


def force(small: bool) -> Iterator[Cell]:
    """A push on the free end of a tube."""
    for size in (1e-6, 1e6) if small else (1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9):
        scene = tube(orders=f"push far with (0, {size!r}, 0) N", gravity=0.0)
        yield Cell("force", f"{size:g} N", scene, 0.1)


def resonance(small: bool) -> Iterator[Cell]:
    """A mass without damping, driven at the frequency at which it swings."""
    hertz = SWING / (2.0 * pi)
    # So weak that the spring keeps some length even after a thousand periods.
    ways = {
        "pushed": f"push bob with (0.1, 0, 0) mN using sine of {hertz!r} Hz",
        "moved": f"move wall by (1, 0, 0) um using sine of {hertz!r} Hz",
    }
    for name, order in ways.items():
        for periods in (10,) if small else (10, 100, 1000):
            duration = periods / hertz
            when = f"from 0 s to {duration!r} s: {order}"
            scene = net(
                ("0 0 0 0", "1 10 0 0"), ("0 1 10",), held=name == "pushed", viscosity=0.0,
                gravity=0.0, orders=when,
            )  # fmt: skip
            yield Cell("resonance", f"{name}, {periods} periods", scene, duration, rests=False)


def fixed_step(small: bool) -> Iterator[Cell]:
    """A step that is written instead of a tolerance."""
    for turns in (0.1, 10.0) if small else (0.01, 0.1, 1.0, 3.0, 10.0, 100.0, 1e4):
        step = turns / SWING
        yield Cell("step × ω", f"{turns:g}", tube(), max(0.2, 50.0 * step), step)


def law(small: bool) -> Iterator[Cell]:
    """Springs whose force has corners, or grows steeply."""
    laws = {
        "tension only": "tension only",
        "dead band": "dead band { slack = 0.5 mm }",
        "toe": "toe { strain = 2 % }",
        "curve": "curve { elongations = [-1 mm, 0 mm, 1 mm, 2 mm]; "
        "forces = [-0.4 N, 0 N, 0.2 N, 1 N] }",
        "exponential": "exponential { stiffening = 12 }",
    }
    for name in ("dead band",) if small else tuple(laws):
        yield Cell("law", name, tube(wall=f"spring law is {laws[name]}"), 0.2)


AXES: tuple[Axis, ...] = (
    stiffness_ratio,
    mass_ratio,
    damping_ratio,
    frame_length,
    compression,
    coincident_nodes,
    mechanisms,
    force,
    resonance,
    fixed_step,
    law,
)


def tube(
    *,
    viscosity: float = DAMPING,
    ring: str = "",
    wall: str = "",
    extra: str = "",
    fixed: bool = True,
    gravity: float = 9.81,
    orders: str = "",
) -> str:
    """Return a tube of 24 nodes, held at one end.

    Args:
        ring: Numbers of its third ring.
        wall, extra: Further numbers of all its tissue, and entries of the body.
        orders: Of 0 s.
    """
    region = "region odd where x between 19 mm and 21 mm { tissue is odd }" if ring else ""
    odd = f"tissue odd like wall {{ {ring} }}" if ring else ""
    at_once = "; ".join(part for part in ("fix near" if fixed else "", orders) if part)
    near = "set near = nodes of tube where x < 1 mm" if fixed else ""
    far = "set far = nodes of tube where x > 29 mm" if "far" in orders else ""
    return f"""
tissue wall {{ spring constant = {STIFFNESS!r} N/m; viscosity = {viscosity!r} N*s/m
  mass = {MASS!r} kg; {wall} }}
{odd}
body tube {{
  mesh is tube {{ axis from (0, 0, 0) mm to (30, 0, 0) mm; radius = 6 mm; rings = 4
    sides = 6; interior is crossed }}
  tissue is wall; interface is softer
  {region}
  {extra}
}}
{near}
{far}
environment {{ gravity = (0, 0, {-gravity!r}) m/s^2 }}
{f"script {{ at 0 s: {{ {at_once} }} }}" if at_once else ""}"""


def net(
    nodes: tuple[str, ...] | list[str],
    springs: tuple[str, ...] | list[str],
    *,
    speeds: tuple[float, ...] = (),
    held: bool = False,
    stiffness: float = STIFFNESS,
    viscosity: float = 0.0,
    gravity: float = 9.81,
    orders: str = "",
) -> str:
    """Return a net of tables in mm; ``held`` fixes node 0, ``speeds`` are along x [m/s]."""
    rows = zip(nodes, speeds or (0.0,) * len(nodes), strict=True)
    listed = "\n  ".join(f"{node} {speed!r}" for node, speed in rows)
    lines = ["at 0 s: fix wall"] * held + [orders] * bool(orders)
    wall = "set wall = nodes of net where id == 0" if held or "wall" in orders else ""
    bob = "set bob = nodes of net where id == 1" if "bob" in orders else ""
    body = "\n  ".join(lines)
    return f"""
tissue cord {{ spring constant = {stiffness!r} N/m; viscosity = {viscosity!r} N*s/m
  mass = {MASS!r} kg }}
body net {{ mesh is explicit; tissue is cord }}
table nodes of net in mm with columns "id x y z vx in m/s" {{
  {listed}
}}
table springs of net in mm with columns "a b rest length" {{ {"; ".join(springs)} }}
{wall}
{bob}
environment {{ gravity = (0, 0, {-gravity!r}) m/s^2 }}
{f"script {{ {body} }}" if body else ""}"""


SHEET = f"""
tissue cloth {{ spring constant = {STIFFNESS!r} N/m; viscosity = {DAMPING!r} N*s/m
  mass = {MASS!r} kg }}
body sheet {{
  mesh is sheet {{ corner = (0, 0, 0) mm; first edge = (30, 0, 0) mm
    second edge = (0, 30, 0) mm; columns = 4; rows = 4 }}
  tissue is cloth
}}
set corner = nodes of sheet where x < 1 mm and y < 1 mm
environment {{ gravity = (0, 0, -9.81) m/s^2 }}
script {{ at 0 s: fix corner }}"""
