"""The sentences and settings of a study block, for checks, editors and the reference."""

from typing import Annotated

from msgspec import Struct

from tissuec.core.fields import OneOf, Whole
from tissuec.core.units import TIME
from tissuec.lang import syntax as s
from tissuec.scene.reading.block_sentences import FileWords, SentenceKind
from tissuec.scene.reading.spellings import AGGREGATES
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import (
    SPRINGS,
    ChoiceClause,
    LimitsClause,
    MeasureClause,
    NameClause,
    NumberClause,
    Placeholder,
    ValueClause,
)

#: Name of the source of sentences that options of commands stand for.
OPTIONS = "options"
VARY, ROWS, MEASURE, EVENT = "vary", "rows", "measure", "time"

GRID, LIST, ONE_AT_A_TIME = "grid", "list", "one at a time"
LATIN, SOBOL, INDICES = "latin hypercube", "sobol", "sobol indices"
#: Designs of values that are listed, and of values that are drawn.
LISTED, DRAWN = (GRID, LIST, ONE_AT_A_TIME), (LATIN, SOBOL, INDICES)
DESIGNS = {
    GRID: "every combination of the values of all factors",
    LIST: "the first values of all factors, then the second ones, and so on",
    ONE_AT_A_TIME: "the unchanged scene, then each value of one factor, all others unchanged",
    LATIN: "random points, of which each part of each range has one",
    SOBOL: "evenly spread random points (Sobol sequence); runs should be a power of two",
    INDICES: "points for Sobol indices of sensitivity: runs times two more than the factors",
}
DISTRIBUTIONS = {
    "uniform": "uniform(low, high)",
    "normal": "normal(mean, standard deviation)",
    "lognormal": "lognormal(median, factor)",
    "triangular": "triangular(low, mode, high)",
}
#: Kinds of events whose time can be measured.
EVENTS = (
    "rupture", "slip", "cut", "grasp", "release", "trigger", "leak", "tie", "fix", "free",
    "hold", "move", "turn", "push", "press", "tighten", "inflate", "irrigate", "preserve",
    "change", "settle", "seize", "stroke", "stop", "end", "end the run", "note",
)  # fmt: skip
NOTHING, RESULTS = "nothing", "results"
OVER_TIME = (*AGGREGATES, EVENT)
EVENT_KIND = Placeholder("EVENT", words=EVENTS, about="The first event of this kind.")
VARIED, OWNER = Placeholder("VARIED", ("param", "property")), Placeholder("OWNER")
COLUMN = Placeholder("NAME", new="column")
EVERY = NumberClause("every", TIME, "positive", what="time between samples")


class Varied(VerbSentence, frozen=True):
    """A param that varies within its limits."""

    what: Annotated[s.Name, NameClause("", what="param or entry", places=(VARIED,))]
    owner: Annotated[s.Name | None, NameClause("of", what="block", places=(OWNER,))]

    @property
    def target(self) -> str:
        """The param, or the entry with its block."""
        if self.what.quoted is not None and not self.what.words:
            return " ".join(self.what.quoted.split())
        of = "" if self.owner is None else f" of {self.owner.span.text}"
        return " ".join(f"{self.what.span.text}{of}".split())


class VariedRange(Varied, frozen=True):
    """A range of numbers, in steps or for random designs."""

    low: Annotated[s.Expression, ValueClause("=", what="start of the range")]
    high: Annotated[s.Expression, ValueClause("to", what="end of the range")]
    steps: Annotated[s.Expression | None, ValueClause("in", what="number of steps")]
    by: Annotated[s.Expression | None, ValueClause("by", what="distance of values")]


class VariedValues(Varied, frozen=True):
    """Values one by one, or a distribution that can be cut off between limits."""

    values: Annotated[s.Expression, ValueClause("=", what="values")]
    limits: Annotated[s.Bounds | None, LimitsClause("between", what="limits")]


class MeasuredWords(VerbSentence, frozen=True):
    """What is measured, which can be called by a name."""

    name: Annotated[s.Name | None, NameClause("", what="column", places=(COLUMN,))]


class MeasuredEvent(MeasuredWords, frozen=True):
    """The time of the first event of a kind, and of something that it must concern."""

    value: Annotated[str, ChoiceClause("=", {EVENT: "The time of the first event."})]
    event: Annotated[
        tuple[s.Name, ...],
        NameClause("of", what="kind of event", places=(EVENT_KIND,), owners=(SPRINGS,)),
    ]


class MeasuredOver(MeasuredWords, frozen=True):
    """A number from the values over time; in parentheses, also the time of an event."""

    value: Annotated[s.Call, MeasureClause("=", what="measure", functions=OVER_TIME)]
    over: Annotated[str | None, ChoiceClause("over", {"run": "The whole run."})]
    start: Annotated[s.Expression | None, ValueClause("from", dimension=TIME)]
    stop: Annotated[s.Expression | None, ValueClause("to", dimension=TIME)]
    until: Annotated[s.Expression | None, ValueClause("until", dimension=TIME)]
    every: Annotated[float | None, EVERY]


class MeasuredAt(MeasuredWords, frozen=True):
    """The value at a time."""

    value: Annotated[s.Expression, MeasureClause("=", what="measure")]
    at: Annotated[s.Expression, ValueClause("at", dimension=TIME)]


class MeasuredCurve(MeasuredWords, frozen=True):
    """Values at regular times; without one, at the time that it names itself."""

    value: Annotated[s.Expression, MeasureClause("=", what="measure")]
    every: Annotated[float | None, EVERY]


SENTENCES: dict[str, SentenceKind] = {
    VARY: SentenceKind(
        (VariedRange, VariedValues, Varied),
        "A factor: a param, or an entry of a block, and its values. ``in 9 steps`` gives 9"
        " values with both ends. A range without steps, a distribution, or a param alone"
        " (uniform within its limits) is for random designs.",
        examples=(
            "vary lift = 2 mm to 10 mm in 9 steps",
            "vary lift = 2 mm to 10 mm by 1 mm",
            "vary lift = [2 mm, 5 mm]",
            "vary lift = normal(5 mm, 1 mm) between 2 mm and 8 mm",
            "vary lift",
            "vary hardness of TISSUE = [soft, slightly hard]",
            "vary tissue of BODY = [healthy, cirrhotic]",
            "vary tolerance = [1e-3, 1e-4]",
        ),
    ),
    ROWS: SentenceKind(
        (FileWords,),
        "A CSV file with one row for each run and a column for each factor, with its unit in"
        " the head: ``lift [mm]``. Commas, semicolons or tabs"
        " separate columns.",
        is_single=True,
    ),
    MEASURE: SentenceKind(
        (MeasuredOver, MeasuredEvent, MeasuredAt, MeasuredCurve),
        "A column of the table: the largest (``max``), smallest (``min``), ``mean``, ``first``"
        " or ``last`` value of a measure; the ``slope`` of one over another; its value at a"
        " time; the time of the first event of a kind; or with ``every`` the whole curve.",
        examples=(
            "measure pull = max(force(forceps A))",
            "measure height = position(tip along (0, 0, 1)) at 0.3 s",
            "measure tear = time of rupture",
            "measure curve = force(forceps A) every 1 ms",
            "measure early = mean(force(forceps A)) from 0 s to 0.1 s",
            "measure stiffness = slope(force(A), distance(A, B)) until 0.1 s",
        ),
        is_needed=True,
    ),
}  # fmt: skip


class StudySettings(Struct, frozen=True):
    """Settings of a study.

    Attributes:
        design: how values are combined; without it, follows from the values
        runs: number of runs of a random design
        seed: seed of random numbers
        keep: what is kept of each run besides its row
        error_estimate: leaves out the second run with smaller steps, which by default shows
            whether a run keeps its tolerance
    """

    design: Annotated[str, OneOf(DESIGNS)] = ""
    runs: Annotated[int, Whole(at_least=1, at_most=10_000_000)] = 100
    seed: Annotated[int, Whole(at_least=0)] = 0
    keep: Annotated[str, OneOf((NOTHING, RESULTS))] = NOTHING
    error_estimate: Annotated[str, OneOf({"off": "without the second run"})] = ""
