"""What a learn block may change: ``adjust spring constant of fat from 1 N/m to 1 kN/m``."""

from collections.abc import Sequence
from math import inf
from typing import cast

import numpy as np

from tissuec.compiler.learning.adjust_limits import Found, limited
from tissuec.compiler.learning.adjust_targets import Target, Targets
from tissuec.compiler.learning.laws import LawConstant, calls_functions, constants_of, uses
from tissuec.core.errors import Note
from tissuec.core.fields import Real
from tissuec.core.hints import Edit, Hint, alternatives
from tissuec.core.names import key_of
from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.scene.learning.clauses import LearnReader
from tissuec.scene.learning.entries import (
    ADJUSTED,
    BREAKING,
    DIMENSIONS,
    DIVIDED,
    PARTED,
    PLACED,
)
from tissuec.scene.learning.sentences import AdjustListed, AdjustScales, AdjustWords
from tissuec.scene.model import Tissue, WrittenForce
from tissuec.scene.reading.entries import entries_of
from tissuec.scene.reading.graded import graded_by
from tissuec.scene.tissues.quantities import LISTED, QUANTITIES, STIFFENING
from tissuec.script.fit_problem import (
    START_POSITION,
    START_VELOCITY,
    WEIGHTS,
    WORDS,
    Adjust,
    Per,
)

ADJUST = "adjust"
NONE = np.zeros(0, dtype=np.int64)


class AdjustReader:
    """Reads the ``adjust`` entries of one learn block.

    Args:
        fit_problem: Name of the block, used for a tissue or force where none is named.
    """

    def __init__(self, targets: Targets, fit_problem: s.Name):
        self.targets, self.fit_problem = targets, fit_problem
        self.scene, self.findings = targets.scene, targets.findings
        self.scope = targets.scene.constants

    def read(self, item: s.Assign | s.Sentence) -> list[Adjust]:
        """Return what an entry lets change, or reject it."""
        reader = LearnReader(ADJUST, item, self.scope)
        if isinstance(item, s.Assign):
            found: list[Adjust] = []
            for name in reader.get(AdjustListed).listed:
                with self.findings.item():
                    found.append(limited(self._own(name, None), reader, name.span))
            return found
        name = reader.object
        if name.key == WORDS:
            return [self._words(one, item) for one in reader.get(AdjustScales).owners]
        if name.key == WEIGHTS:
            self.findings.reject(
                "TIS801", "weights of rules are not adjusted to measured data", item.span,
                hint="adjust words of a quantity, or fit numbers of tissues in a block of its "
                "own: fit = QUANTITY of TISSUE",
            )  # fmt: skip
        said = reader.get(AdjustWords, is_last=False)
        found_one = (
            self._found(name, said.owners, said.per)
            if said.owners
            else self._own(name, said.per)
        )
        return [limited(found_one, reader, item.span)]

    # --- what, and of what --------------------------------------------------------------------

    def _words(self, owner: s.Name, item: s.Sentence) -> Adjust:
        """Return the words of a quantity or property of the vocabulary."""
        vocabulary = self.scene.vocabulary
        quantities = {key: scale.named for key, scale in vocabulary.quantities.items()}
        scales = {**vocabulary.properties, **quantities}
        if owner.key not in scales:
            self.findings.pass_over_doubtful(owner.key)
            known = [scale.name for scale in scales.values()]
            self.findings.reject(
                "TIS202",
                f'"{owner.text}" is not a quantity or property with words in the vocabulary',
                owner.span,
                hint=alternatives(owner.text, known, what="scales")
                or "the scene has no vocabulary",
            )
        scale = scales[owner.key]
        return Adjust(
            WORDS, scale.name, "word", NONE, None, scale.dimension, -inf, inf, None, item.span
        )

    def _own(self, name: s.Name, per: s.Name | None) -> Found:
        """Return something of the tissue or force that the block has the name of."""
        tissue = None if name.key in PLACED else self.targets.tissue(self.fit_problem)
        if tissue is None and (force := self.targets.force(self.fit_problem)) is not None:
            return self._of_force(name, force, per)
        self._refuse_breaking(name)
        if tissue is None:
            self.findings.pass_over_doubtful(self.fit_problem.key)
            why = f"no tissue or force has the name of the block, {self.fit_problem.text}"
            if name.key in PLACED:
                why = f"a {name.key} belongs to a set, body or region"
            self.findings.reject(
                "TIS304", f"the owner of the {name.text} is missing: {why}", name.span,
                hint=f"write: adjust {name.text} of …",
            )  # fmt: skip
        self._refuse_per(per, f"{tissue.name} is a tissue")
        return self._of_tissue(name, tissue)

    def _found(self, name: s.Name, names: Sequence[s.Name], per: s.Name | None) -> Found:
        """Return something of a tissue or force, or of nodes and springs."""
        is_tissue = len(names) == 1 and not per and name.key not in PLACED
        tissue = self.targets.tissue(names[0]) if is_tissue else None
        force = self.targets.force(names[0]) if len(names) == 1 and tissue is None else None
        if force is not None:
            return self._of_force(name, force, per)
        self._refuse_breaking(name)
        if tissue is not None:
            return self._of_tissue(name, tissue)
        target = self.targets.group(names)
        if target is None:
            self._refuse_tissue(name, names, per)
            self.targets.unknown(names, with_tissues=name.key not in PLACED)
        return self._of_target(name, target, per)

    def _refuse_breaking(self, name: s.Name) -> None:
        if name.key in BREAKING:
            self.findings.reject(
                "TIS801",
                f"the {name.key} cannot be learned: a rupture is not differentiable",
                name.span,
                hint="compare runs with different values instead",
            )

    def _refuse_per(self, per: s.Name | None, what: str) -> None:
        """Reject a division of what has one number."""
        if per:
            self.findings.reject(
                "TIS801",
                f"per {per.text} belongs to a set, body or region; {what}",
                per.span,
                hint=Hint("remove it", Edit("", _clause("per", per))),
            )

    def _refuse_tissue(self, name: s.Name, names: Sequence[s.Name], per: s.Name | None) -> None:
        """Reject a tissue where a set or body belongs."""
        if len(names) > 1 or names[0].key not in self.scene.declarations.of("tissue"):
            return
        why, hint = f"per {per.text}" if per else f"a {name.key}", "name a set or a body"
        if name.key == "rest length":
            hint += f", or write: adjust prestress of {names[0].text}"
        message = f"{why} belongs to a set, body or region; {names[0].text} is a tissue"
        self.findings.reject("TIS801", message, names[0].span, hint=hint)

    def _of_tissue(self, name: s.Name, tissue: Tissue) -> Found:
        """Return a quantity of a tissue, or a constant of its laws."""
        if calls_functions(tissue, self.scene):
            self.findings.reject(
                "TIS801",
                f"a law of {tissue.name} calls functions of the scene, which a preset cannot "
                "contain",
                name.span,
                hint="write the formula of the law without functions",
            )
        key = name.key
        given = tissue.given.get(key)
        if key == STIFFENING and given is not None and given.value == given.quantity.none:
            given = None
        constants = constants_of(tissue, self.scene)
        if key in QUANTITIES and not (given is None and key in constants):
            if given is None or np.isinf(given.value):
                reason, called = tissue.missing.get(key, ""), QUANTITIES[key].name
                hint: Hint | str = f"write {called} = … in the tissue as the initial value"
                if (instead := _given_instead(tissue, key)) is not None:
                    text = f"{tissue.name} has the {instead}: adjust {instead}"
                    hint = Hint(text, Edit(instead, name.span))
                self.findings.reject(
                    "TIS801",
                    f"{tissue.name} has no {called} as a number" + (reason and f": {reason}"),
                    name.span,
                    hint=hint,
                )
            if (one := graded_by(self.scene.bodies.values(), tissue.name, key)) is not None:
                self.findings.reject(
                    "TIS801",
                    f"the {key} of {tissue.name} depends on the place and cannot be adjusted",
                    name.span,
                    hint="compare runs with different formulas instead, for example by a study",
                    notes=(Note("the formula", one.span),),
                )
            if (law := uses(tissue, key)) is not None:
                self.findings.reject(
                    "TIS801",
                    f"the {law} of {tissue.name} does not use its {key}",
                    name.span,
                )
            return Found(key, tissue.name, "tissue", NONE, QUANTITIES[key].limits)
        if key not in constants:
            quantities = (one for one in LISTED if key_of(one) in ADJUSTED)
            known = (*quantities, *constants)
            self.findings.pass_over_doubtful(key)
            self.findings.reject(
                "TIS301",
                f'{tissue.name} has no adjustable quantity called "{name.text}"',
                name.span,
                hint=alternatives(key, known, what="it has"),
            )
        found: LawConstant = constants[key]
        if found.kind is None:
            message = f"{name.text} is not a single number and cannot be adjusted"
            self.findings.reject("TIS801", message, name.span)
        return Found(found.name, tissue.name, "tissue", NONE, found.kind)

    def _of_force(self, name: s.Name, force: WrittenForce, per: s.Name | None) -> Found:
        """Return a number of a force."""
        entries = entries_of(type(force.entries))
        self._refuse_per(per, f"{force.name} is a force")
        numbers = [key for key, entry in entries.items() if isinstance(entry.kind, Real)]
        if name.key not in entries:
            self.findings.pass_over_doubtful(name.key)
            self.findings.reject(
                "TIS301",
                f'{force.name} has no adjustable number called "{name.text}"',
                name.span,
                hint=alternatives(name.key, numbers, what="it has")
                or f"a {force.kind} has no numbers",
            )
        entry = entries[name.key]
        if not isinstance(entry.kind, Real):
            message = f"{name.text} is not a single number and cannot be adjusted"
            self.findings.reject("TIS801", message, name.span)
        if getattr(force.entries, entry.field) is None:
            self.findings.reject(
                "TIS801",
                f"{force.name} has no {name.text} as a number",
                name.span,
                hint=f"write {entry.name} = … in the force as the initial value",
            )
        return Found(entry.name, force.name, "force", NONE, entry.kind)

    def _of_target(self, name: s.Name, target: Target, per: s.Name | None) -> Found:
        """Return something of nodes or springs."""
        key = name.key
        if key not in PARTED:
            self.findings.reject(
                "TIS801" if key in QUANTITIES else "TIS301",
                f"{name.text} can be adjusted only for a tissue; {target.name} is not a tissue"
                if key in QUANTITIES
                else f'"{name.text}" cannot be adjusted here',
                name.span,
                hint=alternatives(key, PARTED, what="of sets, bodies and regions"),
            )
        division = self._division(key, target, per)
        members = target.springs if "spring" in PARTED[key] else target.nodes
        if members is None or not len(members):
            if self.findings.errors:
                self.findings.stop()  # such as a table of springs that was found wrong
            needed = "springs" if "spring" in PARTED[key] else "nodes"
            message = f"{target.name} has no {needed}, to which a {key} belongs"
            self.findings.reject("TIS801", message, name.span)
        kind = Real(DIMENSIONS[key])
        if key in QUANTITIES:
            kind = QUANTITIES[key].limits
        elif key not in (START_POSITION, START_VELOCITY):
            kind = Real(DIMENSIONS[key], above=0.0)
        return Found(key, target.name, division, np.unique(members), kind)

    def _division(self, key: str, target: Target, per: s.Name | None) -> Per:
        """Return the unit of division: each gets its own number."""
        if per is None:
            return "set"
        if per.key not in PARTED[key]:
            is_known = per.key in DIVIDED
            self.findings.reject(
                "TIS801" if is_known else "TIS305",
                f"a {key} cannot be adjusted per {per.text}",
                per.span,
                hint=alternatives(per.key, PARTED[key], what="choices after per"),
            )
        if per.key == "region" and (
            target.body is None or not target.body.drawing.body.regions
        ):
            kind = "has no regions" if target.body is not None else "is not a body with regions"
            message = f"{target.name} {kind} and cannot be adjusted per region"
            edit = Edit("", _clause("per", per))
            hint = Hint("remove it: one factor then applies to all", edit)
            self.findings.reject("TIS801", message, per.span, hint=hint)
        return cast(Per, per.key)


def _given_instead(tissue: Tissue, key: str) -> str | None:
    """Return the name of a quantity that a tissue gives in place of another, if any."""
    array = QUANTITIES[key].array
    names = (
        one.quantity.name
        for one in tissue.given.values()
        if array and one.quantity.array == array and np.isfinite(one.value)
    )
    return next(names, None)


def _clause(word: str, name: s.Name) -> Span:
    """Return the place of a word and the name after it, with the blanks before both."""
    text = name.span.source.text[: name.span.start].rstrip()
    return Span(name.span.source, len(text.removesuffix(word).rstrip()), name.span.end)
