"""All scenes of the stress test against all methods, and the map of what came of them."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from msgspec import Struct

from benchmarks.stability.cells import Cell
from benchmarks.stability.verdict import Court, Kind, Verdict
from tissuec.core.data import as_data
from tissuec.core.markdown import code, fenced, table
from tissuec.engine.integrators import INTEGRATORS
from tissuec.script.plan import AUTOMATIC, RELAXATION

SIGNS: dict[Kind, tuple[str, str]] = {
    "good": ("ok", "as promised"),
    "energy": ("ok*", "chaotic, no reference, or a fixed step: energy and momentum hold"),
    "measured": ("1e-2", "error of a method that promises nothing, at a step that suits it"),
    "warned": ("warned", "a warning was given, and the result is off"),
    "refused": ("refused", "the text or the run was refused with a sentence"),
    "slow": ("slow", "longer than the budget"),
    "none": ("-", "not for this method: another one took over"),
    "wrong": ("WRONG", "silently wrong"),
    "crash": ("CRASH", "tissuec itself failed"),
}
BAD: tuple[Kind, ...] = ("wrong", "crash")
METHODS = (AUTOMATIC, *INTEGRATORS, RELAXATION)


class Stress(Struct, frozen=True):
    """The verdicts of a stress test.

    Attributes:
        methods: In the order of the columns.
        verdicts: Of all scenes in their order, each with all methods.
    """

    methods: tuple[str, ...]
    verdicts: tuple[Verdict, ...]

    @property
    def bad(self) -> tuple[Verdict, ...]:
        """Return what is silently wrong, or crashed."""
        return tuple(verdict for verdict in self.verdicts if verdict.kind in BAD)

    @property
    def rows(self) -> list[tuple[str, ...]]:
        """Return axis, value and a sign for each method, one row for each scene."""
        width = len(self.methods)
        groups = [self.verdicts[i : i + width] for i in range(0, len(self.verdicts), width)]
        return [
            (group[0].axis, group[0].value, *(sign_of(v) for v in group)) for group in groups
        ]

    @property
    def heads(self) -> tuple[str, ...]:
        """Return what the columns of ``rows`` are."""
        return ("axis", "value", *self.methods)


def sign_of(verdict: Verdict) -> str:
    """Return what stands in the map."""
    return SIGNS[verdict.kind][0] if verdict.error is None else f"{verdict.error:.0e}"


def stress(
    cells: Iterable[Cell],
    *,
    methods: Sequence[str],
    budget: float,
    tell: Callable[[str], None],
) -> Stress:
    """Return the verdicts on scenes.

    Args:
        methods: Names; none means all.
        budget: Time of the processor for a run [s].
        tell: Told which scene is tried, and what came of it.
    """
    names = tuple(methods) or METHODS
    verdicts: list[Verdict] = []
    for cell in cells:
        tell(f"{cell.axis} {cell.value} …")
        court = Court(cell, budget)
        found = [court.judge(name) for name in names]
        tell("  " + ", ".join(f"{each.method} {sign_of(each)}" for each in found))
        verdicts += found
    return Stress(names, tuple(verdicts))


def as_markdown(stress: Stress) -> str:
    """Return the map, how often each sign stands in it, and what is bad with its scene."""
    counts = Counter(verdict.kind for verdict in stress.verdicts)
    meanings = [
        (sign, str(counts[kind]), meaning)
        for kind, (sign, meaning) in SIGNS.items()
        if counts[kind]
    ]
    bad = [
        f"{one.axis} {one.value}, {code(one.method)}: {one.why}\n\n{fenced(one.scene)}"
        for one in stress.bad
    ]
    parts = [table(stress.heads, stress.rows), table(("sign", "times", "means"), meanings)]
    return "\n\n".join([*parts, *(bad or ["Nothing is silently wrong, and nothing crashed."])])


def as_dict(stress: Stress) -> dict[str, Any]:
    """Return all verdicts, and what their kinds are called and mean."""
    return {
        "methods": list(stress.methods),
        "bad": len(stress.bad),
        "signs": {kind: list(sign) for kind, sign in SIGNS.items()},
        "verdicts": [as_data(verdict) for verdict in stress.verdicts],
    }
