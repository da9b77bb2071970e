"""The tissues of a preset, and which of their numbers were learnt."""

from collections.abc import Iterator

from msgspec import Struct, field

from tissuec.core.names import key_of
from tissuec.core.units import Dimension
from tissuec.learn.fit.outcome import Estimates, Learnt
from tissuec.learn.vocabulary.used import used_tissues
from tissuec.scene.model import Body, Scene, Tissue
from tissuec.scene.tissues.quantities import QUANTITIES

LEARNED = "learned"


class LearntNumber(Struct, frozen=True):
    """A number that was learnt, in SI units, with its interval."""

    value: float
    low: float
    high: float
    start: float
    identified: bool
    dimension: Dimension


class Draft(Struct):
    """A tissue that is to be written.

    Attributes:
        remark: Which part of a body it is for; empty where it is for all of its original.
        numbers: Quantities that were learnt, by name.
        constants: Constants of its laws that were learnt, by name.
    """

    name: str
    original: Tissue
    remark: str
    numbers: dict[str, LearntNumber] = field(default_factory=dict[str, LearntNumber])
    constants: dict[str, LearntNumber] = field(default_factory=dict[str, LearntNumber])

    def add(self, what: str, number: LearntNumber) -> None:
        """Enter a number that was learnt."""
        # A law has a stiffening, too.
        is_given = what in QUANTITIES and what in self.original.given
        (self.numbers if is_given else self.constants)[what] = number


def drafts_of(learnt: Learnt, scene: Scene) -> list[Draft]:
    """Return the tissues for which something was learnt, in the order of the entries.

    Where words moved, these are all tissues that are described in them and are used.
    """
    found: dict[tuple[str, str], Draft] = {}
    for estimates in learnt.estimates:
        if estimates.adjust.per == "tissue":
            original = scene.tissues[key_of(estimates.adjust.of)]
            draft = found.setdefault((key_of(original.name), ""), Draft("", original, ""))
            draft.add(estimates.adjust.what, number_of(estimates, 0))
    for estimates in learnt.estimates:
        if estimates.adjust.per == "region":
            _add_parts(found, estimates, scene)
    if learnt.words:
        for use in used_tissues(scene):
            found.setdefault((use.key, ""), Draft("", use.tissue, ""))
    _name_all(list(found.values()), learnt.fit_problem.name, scene)
    return list(found.values())


def number_of(estimates: Estimates, place: int) -> LearntNumber:
    """Return one of the numbers of an entry."""
    return LearntNumber(
        float(estimates.value[place]),
        float(estimates.low[place]),
        float(estimates.high[place]),
        float(estimates.start[place]),
        bool(estimates.identified[place]),
        estimates.adjust.dimension,
    )


def _add_parts(found: dict[tuple[str, str], Draft], estimates: Estimates, scene: Scene) -> None:
    """Enter numbers of the parts of a body, each on top of what its tissue learnt."""
    body = scene.bodies[key_of(estimates.adjust.of)]
    for place, part in enumerate(estimates.parts):
        name, tissue = _part(body, str(part))
        key = key_of(tissue.name), f"{key_of(body.name)}/{key_of(name)}"
        if key not in found:
            whole = found.get((key[0], ""))
            numbers = dict(whole.numbers) if whole else {}
            constants = dict(whole.constants) if whole else {}
            remark = f"{name} of {body.name}" if name else body.name
            found[key] = Draft(name or body.name, tissue, remark, numbers, constants)
        found[key].add(estimates.adjust.what, number_of(estimates, place))


def _part(body: Body, text: str) -> tuple[str, Tissue]:
    """Return the region that is meant, "" for the body itself, and its tissue."""
    name = text.removesuffix(f" of {body.name}")
    regions = {key_of(region.name): region for region in body.regions}
    region = regions.get(key_of(name))
    tissue = (region.tissue if region else None) or body.tissue
    assert tissue is not None, "a body without a tissue has nothing to adjust"
    return (region.name if region else ""), tissue


def _name_all(drafts: list[Draft], fit_problem: str, scene: Scene) -> None:
    """Give each draft a name that nothing else has.

    A single one is called like the fit problem, unless a tissue of the scene is called so.
    """
    taken: set[str] = set(scene.declarations.of("tissue")) | set(scene.tissues)
    for draft in drafts:
        wanted = _wanted(draft, fit_problem, alone=len(drafts) == 1)
        draft.name = next(name for name in wanted if key_of(name) not in taken)
        taken.add(key_of(draft.name))


def _wanted(draft: Draft, fit_problem: str, *, alone: bool) -> Iterator[str]:
    if alone:
        yield fit_problem
    base = draft.name or draft.original.name
    yield f"{LEARNED} {base}"
    if draft.remark and draft.name:
        yield f"{LEARNED} {draft.original.name} of {draft.remark}"
    number = 2
    while True:
        yield f"{LEARNED} {base} {number}"
        number += 1
