"""Learn blocks bound to the network: fits, parameters and expectations."""

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from tissuec.compiler.bodies.drawn import Drawing
from tissuec.compiler.learning.adjust_targets import Targets
from tissuec.compiler.learning.adjusting import AdjustReader
from tissuec.compiler.learning.expectations import demands_of
from tissuec.compiler.learning.targets import FitReader
from tissuec.compiler.measures.conditions import Conditions
from tissuec.core.errors import Note
from tissuec.core.hints import leaving_out
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.lang import syntax as s
from tissuec.matter.elasticity import wall_springs
from tissuec.scene.learning.entries import SCALED
from tissuec.scene.learning.model import VocabularyFit, WrittenFitProblem
from tissuec.scene.model import Scene
from tissuec.scene.reading.findings import Findings
from tissuec.scene.tissues.quantities import OF_MATTER, QUANTITIES
from tissuec.script.fit_problem import (
    REST_LENGTH,
    WORDS,
    Adjust,
    DataAxis,
    Demand,
    Fit,
    FitProblem,
)

#: What changes the same numbers of springs.
_SAME = {"prestress": REST_LENGTH}
#: Directions are one where they differ by less than rounding does.
_PARALLEL = 1.0 - 1e-12


class CompiledLearnBlocks(NamedTuple):
    """The learn blocks of a scene, each kind in the order of the text."""

    fit_problems: tuple[FitProblem, ...] = ()
    vocabulary_fits: tuple[VocabularyFit, ...] = ()


def compile_learn_blocks(
    scene: Scene, conditions: Conditions, expects: Sequence[s.Expect]
) -> CompiledLearnBlocks:
    """Return the learn blocks of a scene that have no errors.

    Args:
        expects: Expectations about errors of learning.
    """
    findings = conditions.findings
    blocks = {**scene.fit_problems, **scene.vocabulary_fits}
    demands = demands_of(conditions.scope, blocks, expects)
    found: list[FitProblem] = []
    if scene.fit_problems:
        targets = Targets(scene, conditions.groups)
        for key, written in scene.fit_problems.items():
            before = findings.failures
            fit_problem = _FitProblemBuilder(written, targets, conditions).build(demands[key])
            if written.is_whole and findings.failures == before:
                found.append(fit_problem)
    of_words = (
        replace(one, demands=tuple(demands[key])) for key, one in scene.vocabulary_fits.items()
    )
    return CompiledLearnBlocks(tuple(found), tuple(of_words))


class _FitProblemBuilder:
    """Binds one learn block."""

    def __init__(self, written: WrittenFitProblem, targets: Targets, conditions: Conditions):
        self.written, self.targets, self.conditions = written, targets, conditions
        self.findings: Findings = conditions.findings

    def build(self, demands: Sequence[Demand]) -> FitProblem:
        """Return the fit problem; where anything of it was rejected, it is not whole."""
        written, settings = self.written, self.written.settings
        axis, fits = self._fits()
        adjusts = self._adjusts()
        if written.write is not None:
            self._warn_of_mesh(adjusts)
        return FitProblem(
            name=written.name.text,
            data=written.data,
            axis=axis,
            fits=tuple(fits),
            adjusts=tuple(adjusts),
            last_part=written.last_part,
            revise=written.revise,
            passes=settings.passes,
            bootstrap=settings.bootstrap,
            seed=settings.seed,
            tolerance=settings.tolerance,
            integrator=settings.integrator,
            step=settings.step,
            method=settings.method,
            scaled=settings.error == SCALED,
            write=written.write,
            demands=tuple(demands),
            span=written.span,
        )

    def _fits(self) -> tuple[DataAxis, list[Fit]]:
        reader, axis = FitReader(self.conditions, self.written.data), None
        with self.findings.item():
            axis = reader.axis(self.written.axis, self.written.span)
        fits: list[Fit] = []
        for item, against in self.written.fits:
            with self.findings.item():
                fits.append(reader.fit(item, against))
        return axis or DataAxis(None, None, self.written.span), fits

    def _adjusts(self) -> list[Adjust]:
        reader = AdjustReader(self.targets, self.written.name)
        found: list[Adjust] = []
        for item in self.written.adjusts:
            with self.findings.item():
                found += reader.read(item)
        for one, other in combinations(found, 2):
            if _is_same(one, other):
                self._twice("TIS307", "is adjusted twice", one.span, other)
                continue
            common = _SAME.get(one.what, one.what) == _SAME.get(other.what, other.what)
            if common and self._overlap(one, other):
                self._twice("TIS804", "is adjusted here and by another line", one.span, other)
        for words, other in _concluded(found, self.targets.scene):
            self._twice("TIS804", "follows from words that are also adjusted", words, other)
        return found

    def _twice(self, code: str, problem: str, first: Span, second: Adjust) -> None:
        self.findings.add(
            code,
            f"{second.what} of {second.of} {problem}",
            second.span,
            hint=""
            if code == "TIS307"
            else leaving_out("remove one of them", second.span, first),
            notes=(Note("first here" if code == "TIS307" else "the other line", first),),
        )

    def _warn_of_mesh(self, adjusts: Sequence[Adjust]) -> None:
        """Tell of numbers in a preset that would mean something else on another mesh."""
        found = [one for one in adjusts if self._depends_on_mesh(one)]
        if not found:
            return
        names = ", ".join(f"{one.what} of {one.of}" for one in found)
        of_matter = dict.fromkeys(QUANTITIES[OF_MATTER[one.what][0]].name for one in found)
        self.findings.add(
            "W801",
            "the preset is valid on this mesh only, because it contains values of single "
            "springs and "
            f"nodes: {names}",
            found[0].span,
            hint=f"write and adjust {', '.join(of_matter)} instead; "
            "tissuec explain --bodies computes them for this mesh",
        )

    def _depends_on_mesh(self, adjust: Adjust) -> bool:
        """Return whether a quantity of a tissue belongs to springs or nodes of a mesh.

        And whether one of matter could take its place.
        """
        if adjust.per not in ("tissue", "region") or not OF_MATTER.get(adjust.what):
            return False
        if adjust.per == "region":
            return _can_be_matter(self.targets.groups.bodies[s.key_of(adjust.of)].drawing)
        tissue = self.targets.scene.tissues[s.key_of(adjust.of)]
        given = tissue.given[adjust.what]
        if given.spread not in ("each spring", "each node"):
            return False
        bodies = self.targets.bodies_of(tissue)
        drawings = [placed.drawing for placed in bodies if _can_be_matter(placed.drawing)]
        # The constant of a piece of a given length is that of every thread.
        return any(one.thread is None or given.length is None for one in drawings)

    def _overlap(self, one: Adjust, other: Adjust) -> bool:
        """Return whether two entries change the same numbers of some node or spring."""
        if "tissue" in (one.per, other.per) and one.per == other.per:
            return False  # springs between two tissues are a mean of both
        if _are_apart(one, other):
            return False
        first, second = self._members(one), self._members(other)
        return bool(np.isin(first, second).any())

    def _members(self, adjust: Adjust) -> np.ndarray:
        if adjust.per != "tissue":
            return adjust.members
        tissue = self.targets.scene.tissues[s.key_of(adjust.of)]
        return self.targets.parts_of(tissue)[0 if adjust.what == "mass" else 1]


def _is_same(one: Adjust, other: Adjust) -> bool:
    """Return whether two entries are about the same, as they are written."""
    return (
        (one.what, one.of, one.per == "tissue") == (other.what, other.of, other.per == "tissue")
        and not _are_apart(one, other)
    )  # fmt: skip


def _are_apart(one: Adjust, other: Adjust) -> bool:
    """Return whether two starts are along different directions."""
    if one.along is None or other.along is None:
        return False
    return abs(float(one.along @ other.along)) < _PARALLEL


def _concluded(adjusts: Sequence[Adjust], scene: Scene) -> Iterator[tuple[Span, Adjust]]:
    """Yield the words from which a quantity follows that is adjusted as a number, too."""
    words = {one.of: one.span for one in adjusts if one.what == WORDS}
    for one in adjusts:
        if one.per != "tissue" or one.what not in QUANTITIES:
            continue
        given = scene.tissues[s.key_of(one.of)].given.get(one.what)  # None: of a law
        if one.what in words and given is not None and given.how != "written":
            yield words[one.what], one


def _can_be_matter(drawing: Drawing) -> bool:
    """Return whether the tissue of a mesh could be in pascals.

    Nets typed in as tables could have a section, but are what they are on purpose.
    """
    mesh = drawing.mesh
    is_tube = mesh.grid is not None and mesh.grid.closed
    if drawing.thread is not None or mesh.volume is not None or is_tube:
        return True
    return bool(len(mesh.skin) and wall_springs(mesh.skin, mesh.ends[: drawing.own]).all())
