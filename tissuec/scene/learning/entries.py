"""The entries of a learn block: one table for checks, editors and the reference."""

from typing import Annotated

from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import OneOf, Real, Whole
from tissuec.engine.integrators import INTEGRATORS, Integrator
from tissuec.scene.reading.block_sentences import Sentences
from tissuec.scene.reading.entries import Entry, with_choices
from tissuec.scene.tissues.quantities import (
    CUTTING_RESISTANCE,
    FIBRE_DISPERSION,
    FIBRE_MODULUS,
    FIBRE_STIFFENING,
    FRICTION,
    POISSONS_RATIO,
    QUANTITIES,
)
from tissuec.script.fit_problem import REST_LENGTH, START_POSITION, START_VELOCITY, WORDS
from tissuec.script.plan import AUTOMATIC

METHODS = ("automatic", "least squares", "l-bfgs-b")
SCALED, ABSOLUTE = "scaled", "absolute"


SENTENCES: dict[str, Sentences] = {
    "data": Sentences(
        (
            'data = ["one.csv", "two.csv"]',
            'data "three.csv" from 12.4 s { NAME = 2 mm }',
        ),
        "Files of measurements beside the scene: tables, results of runs (HDF5), or H5MD. A"
        " block after the name gives the params of the scene that differ in this experiment."
        " ``from`` is the time of the file at which the run begins (by default 0 s); earlier"
        " rows are not used. Needed for fits of measures.",
    ),
    "time": Sentences(
        ('time using column "t_ms" in ms', 'time using column "frame" in 10 ms'),
        "The column of times, or of the numbers of pictures and the time between them. By"
        " default the first column (in TRC files the column of times), in seconds or in the"
        " unit that its name ends with.",
        is_single=True,
    ),
    "displacement": Sentences(
        (
            'displacement of SET using column "u_mm" in mm',
            'displacement of SET along (1, 0, 0) using column "u_mm" in mm',
        ),
        "Instead of a time: the displacement of the set in each row, where the net is in"
        " equilibrium. It counts to where the script moves the set; ``along`` gives it a sign,"
        " for tension and compression in one table.",
        is_single=True,
    ),
    "fit": Sentences(
        (
            'fit = force(SET) using column "force_N" in N every 10 ms to 2 mN weighing 0.5',
            'fit = position(SET) along (1, 0, 0) using column "x_mm" in mm with free zero',
            'fit = positions(SET) using columns "node x y z" in mm',
            "fit = QUANTITY of TISSUE weighing 2",
            "fit = QUANTITY of all tissues",
        ),
        "The measured quantity: a measure, or the positions of all nodes of a set, and its"
        " columns. Results of runs need no columns. ``every`` sets the least interval in time,"
        " ``to`` gives the standard deviation of the measured values, ``weighing`` gives their"
        " weight, and ``with free zero`` allows for an unknown constant offset. Or numbers of"
        " tissues that their words should give: those that are written, or else the evidence;"
        " such a block has no data.",
        is_needed=True,
    ),
    "against column": Sentences(
        ('against column "force_N" in N every 10 ms',),
        "The column of the fit on the line above, if that names none.",
    ),
    "adjust": Sentences(
        (
            "adjust = [spring constant, viscosity]",
            "adjust spring constant of TISSUE from 1 N/m to 1 kN/m around 20 N/m by 30 %",
            "adjust spring constant of SET per spring around initial value by 50 %",
            "adjust start position of SET along (1, 0, 0)",
            "adjust stiffness of FORCE from 1 kPa/m to 1 MPa/m",
            "adjust words of QUANTITY",
            "adjust weights of RULES",
        ),
        "The adjusted parameters: a quantity of a tissue (by default the tissue or force with"
        " the name of the block), a constant of its laws, or a param in their formulas; a"
        " spring constant, viscosity, mass or rest length of a set, body or region by one"
        " factor, or ``per spring``, ``per node`` or ``per region``; where a set starts, and"
        " how fast; a number of a force; or the words of a quantity or property, whose order"
        " is kept; with fits of numbers of tissues, also the weights of rules."
        " ``from … to …`` are limits, ``around … by …`` is the expected value and its"
        " relative deviation (one standard deviation); ``around initial value`` expects each"
        " where it starts.",
        is_needed=True,
    ),
    "revise rules": Sentences(
        ("revise rules of RULES",),
        "Rules that may be changed, added or dropped if this reduces the error of rows that"
        " were not fitted. Words and numbers are fitted again with each candidate.",
    ),
    "hold out": Sentences(
        ('hold out "three.csv"', "hold out = 20 %", "hold out TISSUE"),
        "Data for testing, not for learning: some of the files, the last part of each"
        " experiment, or tissues whose numbers are fitted.",
    ),
    "write": Sentences(
        ('write "learned/fat.tis"',),
        "The file of the preset, or of the vocabulary, relative to the scene.",
        is_single=True,
    ),
}  # fmt: skip


class LearnSettings(Struct, frozen=True):
    """Settings of learning.

    Attributes:
        passes: maximum number of passes of the optimiser
        bootstrap: number of fits to simulated data that give the intervals; by default,
            derivatives give them
        seed: seed of random numbers
        tolerance: relative change of the error at which learning ends
        step: fixed time step of the motion during learning; by default chosen automatically
        integrator: method of time integration during learning
        method: optimisation method; put a name with dashes in quotes
        error: error relative to the noise of the data, or absolute, as in the paper
    """

    passes: Annotated[int, Whole(at_least=1, at_most=1_000_000)] = 100
    bootstrap: Annotated[int | None, Whole(at_least=40, at_most=1_000_000)] = None
    seed: Annotated[int, Whole(at_least=0)] = 0
    tolerance: Annotated[float, Real(units.NUMBER, above=0.0, at_most=0.1)] = 1e-9
    step: Annotated[float | None, Real(units.TIME, above=0.0)] = None
    integrator: Annotated[str, OneOf((AUTOMATIC,))] = AUTOMATIC
    method: Annotated[str, OneOf(METHODS)] = METHODS[0]
    error: Annotated[str, OneOf((SCALED, ABSOLUTE))] = SCALED


def learn_schema() -> dict[str, Entry]:
    """Return the settings of a learn block with the integrators that can be differentiated.

    These are all with a tableau but those for scenes without losses, for what is learnt may be
    a viscosity.
    """
    names = (name for name in INTEGRATORS if _is_differentiated(INTEGRATORS[name]))
    return with_choices(LearnSettings, "integrator", (AUTOMATIC, *names))


def _is_differentiated(member: type[Integrator]) -> bool:
    return member.tableau is not None and not member.conservative


#: What limits forces at which springs break: there is no slope to follow.
BREAKING = ("breaking force", "crushing force", "breaking strain", "strength", "toughness")
#: What a set, body or region can have adjusted, and by what it can be divided.
PARTED: dict[str, tuple[str, ...]] = {
    "spring constant": ("spring", "region"),
    "viscosity": ("spring", "region"),
    "mass": ("node", "region"),
    REST_LENGTH: ("spring", "region"),
    START_POSITION: ("node",),
    START_VELOCITY: ("node",),
}
DIVIDED = ("spring", "node", "region")
#: Of sets alone, for tissues have none.
PLACED = (REST_LENGTH, START_POSITION, START_VELOCITY)
DIMENSIONS = {
    **{name: quantity.dimension for name, quantity in QUANTITIES.items()},
    REST_LENGTH: units.LENGTH,
    START_POSITION: units.LENGTH,
    START_VELOCITY: units.VELOCITY,
}
#: Quantities of matter that are not adjusted.
NOT_LEARNT = (
    *BREAKING, POISSONS_RATIO, FIBRE_MODULUS, FIBRE_STIFFENING, FIBRE_DISPERSION, FRICTION,
    CUTTING_RESISTANCE,
)  # fmt: skip
#: What can be adjusted, beside constants of laws, params and numbers of forces.
ADJUSTED = (
    *(key for key in QUANTITIES if key not in NOT_LEARNT),
    *PLACED,
    WORDS,
)
