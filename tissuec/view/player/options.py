"""Options of a player or a picture."""

from typing import Literal, get_args

from msgspec import Struct

from tissuec.view.section.plane import SectionPlane

Colour = Literal["tension", "strain", "law"]
COLOURS: tuple[Colour, ...] = get_args(Colour)


class Options(Struct, frozen=True):
    """What is shown, and how at first; all of it can be left out.

    Attributes:
        frames: At most so many, evenly chosen; all if None.
        every: At least so long between frames [s].
        nodes: Draw about so many nodes of larger nets; all if None.
        colour: What colours the springs; None where a skin hides them.
        field: Name of what colours the skin, one of ``fields.fields_of``; its tissues if None.
        range: From which to which number the colours of the field lead, in its SI unit; within
            which 98 % of the nodes are if None.
        logarithmic: Whether these colours follow the logarithms of numbers.
        time: Its first time [s]; the start if None.
        view: Azimuth and elevation of who looks [deg]; chosen by the shape if None.
        speed: Playback speed, 1 is real time; chosen automatically if None.
        section: The plane by which everything is cut open at first; None for none.
        cells: Whether filled bodies can be cut open later.
    """

    frames: int | None = None
    every: float | None = None
    nodes: int | None = None
    colour: Colour | None = None
    field: str | None = None
    range: tuple[float, float] | None = None
    logarithmic: bool = False
    time: float | None = None
    view: tuple[float, float] | None = None
    speed: float | None = None
    section: SectionPlane | None = None
    cells: bool = True


DEFAULT = Options()
