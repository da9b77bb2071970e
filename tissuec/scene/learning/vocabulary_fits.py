"""Learn blocks that fit words to numbers of tissues: ``fit = Young's modulus of liver``."""

from collections.abc import Iterator, Sequence
from math import log
from typing import Literal, NoReturn

from tissuec.core.errors import Note
from tissuec.core.hints import Hint, alternatives
from tissuec.core.source import Source, Span
from tissuec.core.structs import replace
from tissuec.fuzzy.rulebase import Inference
from tissuec.fuzzy.scale import OutOfRange
from tissuec.lang import syntax as s
from tissuec.scene.learning.entries import LearnSettings
from tissuec.scene.learning.items import LearnItems
from tissuec.scene.learning.model import ADJUST, FIT, VocabularyFit, WordTarget
from tissuec.scene.learning.sentences import (
    ALL_TISSUES,
    FitTissueWords,
    TissueHeld,
    TissuesHeld,
)
from tissuec.scene.model import KnownQuantity, Tissue
from tissuec.scene.program.declarations import Declared
from tissuec.scene.program.resolved import ResolvedProgram
from tissuec.scene.tissues.conclusions import why
from tissuec.scene.tissues.quantities import QUANTITIES
from tissuec.script.fit_problem import WEIGHTS, WORDS

QUANTITY = "Young's modulus"  # in examples
#: Standard deviation of a written number: of its logarithm, and on a linear scale as a part of
#: the scale. Evidence has half its range, if that is wider.
DEVIATION, LINEAR_DEVIATION = log(1.1), 0.025
FEW = 5  # of the tissues without a number, in the report
#: Sentences and settings about measured data and motion.
OF_DATA = ("data", "time", "displacement", "against column", "revise rules")
SETTINGS = ("passes", "tolerance")
APART = (
    "write a learn block for the numbers of tissues, and another one for the data; the first "
    "one has fit, adjust words of …, adjust weights of …, hold out, write, passes and tolerance"
)


def fits_words(declared: Declared) -> bool:
    """Return whether a learn block fits the words for numbers of tissues."""
    assert isinstance(declared.item, s.Block)
    return any(map(_fits_tissues, declared.item.items))


def _fits_tissues(item: s.Item) -> bool:
    if not isinstance(item, s.Assign) or item.name.key != FIT:
        return False
    if not isinstance(item.value, s.Name):
        return False
    clauses = [clause.word for clause in item.clauses]
    is_known = item.value.key in QUANTITIES
    return is_known or ("of" in clauses and "using" not in clauses)


class VocabularyFitReader(LearnItems):
    """Reads one learn block that fits words to numbers of tissues."""

    def __init__(self, declared: Declared, words: ResolvedProgram, sources: Sequence[Source]):
        super().__init__(declared, words.constants, sources)
        self.words, self.vocabulary = words, words.vocabulary
        self.targets: dict[tuple[str, str], WordTarget] = {}
        self.held: dict[str, Span] = {}
        self.adjusted: dict[tuple[str, str], Span] = {}
        self.left_out: list[str] = []

    def read(self) -> VocabularyFit:
        """Return the block, as far as it is valid."""
        failures = self.findings.failures
        for item in self.block.items:
            with self.findings.item():
                self._read(item)
        if self.findings.failures == failures:
            if not self.adjusted:
                self.need(ADJUST, self.block.head, f"{ADJUST} {WORDS} of {QUANTITY}")
            with self.findings.item():
                self._hold_out()
        settings = LearnSettings(**self.values)  # type: ignore[arg-type]
        return VocabularyFit(
            self.name.text,
            tuple(self.targets.values()),
            tuple(key for what, key in self.adjusted if what == WORDS),
            tuple(key for what, key in self.adjusted if what == WEIGHTS),
            tuple(dict.fromkeys(self.left_out)),
            settings.passes,
            settings.tolerance,
            self.write,
            (),
            self.findings.failures == failures,
            self.block.head,
        )

    def _read(self, item: s.Item) -> None:
        entry = self.entry(item)
        match entry, item:
            case None, _:
                self._refuse_setting(item)
            case "fit", s.Assign():
                self.places.setdefault(FIT, item.span)
                self._fit(item)
            case "adjust", s.Sentence():
                self._adjust(item)
            case "hold out", _:
                self._hold(item)
            case "write", _:
                self.read_write(item)
            case ("adjust", _):
                self._only_words(item.span)
            case _ if entry in OF_DATA:
                self._refuse_data(item.span, f'"{entry}" belongs to fits of measured data')
            case _:
                self.reader(entry or "", item).reject_form()

    def _refuse_setting(self, item: s.Item) -> None:
        assert isinstance(item, s.Assign | s.Sentence | s.Block)
        if item.name.key not in SETTINGS:
            self._refuse_data(item.span, f'"{item.name.key}" belongs to fits of measured data')

    def _refuse_data(self, span: Span, message: str) -> NoReturn:
        fits = (item for item in self.block.items if _fits_tissues(item))
        notes = (Note("this block fits numbers of tissues", next(fits).span),)
        self.findings.reject("TIS306", message, span, hint=APART, notes=notes)

    # --- targets ------------------------------------------------------------------------------

    def _fit(self, item: s.Assign) -> None:
        if not _fits_tissues(item) or not isinstance(item.value, s.Name):
            self._refuse_data(item.span, "this fit is of measured data")
        said = self.reader(FIT, item).get(FitTissueWords)
        key, of = item.value.key, said.tissues
        concluding = [
            rules for rules in self.vocabulary.rules.values() if key in rules.concluded
        ]
        if not concluding:
            self._refuse_quantity(item.value)
        if of is None:
            self.findings.reject(
                "TIS304", f"the tissue whose {item.value.text} is fitted is missing", item.span,
                hint=f"write: fit = {item.value.text} of TISSUE",
            )  # fmt: skip
        weight = 1.0 if said.weight is None else said.weight
        if of[0].key == ALL_TISSUES:
            self._fit_all(key, weight, item)
            return
        with self.findings.together():
            for name in of:
                with self.findings.item():
                    tissue = self._tissue(name)
                    problem = self._problem(tissue, key)
                    if problem is not None:
                        self.findings.reject(
                            problem[0], problem[1], name.span, hint=problem[2],
                            notes=(Note(f"the tissue {tissue.name}", tissue.span),),
                        )  # fmt: skip
                    self._enter(self._target(tissue, key, weight, name.span))

    def _fit_all(self, key: str, weight: float, item: s.Assign) -> None:
        """Enter all tissues that have words and a number; others are listed in the report."""
        described = [one for one in self.words.tissues.values() if one.vocabulary]
        without_number = [one for one in described if self._problem(one, key) is not None]
        for tissue in described:
            if tissue not in without_number:
                self._enter(self._target(tissue, key, weight, item.span))
        if without_number:
            names = [tissue.name for tissue in without_number]
            more = [f"{len(names) - FEW} more"] if len(names) > FEW + 1 else []
            listed = ", ".join([*names[: FEW if more else None], *more])
            self.left_out.append(f"without a number for their {QUANTITIES[key].name}: {listed}")
        if len(without_number) == len(described):
            self.findings.pass_over_doubtful(ALL_TISSUES)
            self.findings.reject(
                "TIS304",
                f"no tissue has words, and a number or evidence for its {QUANTITIES[key].name}",
                item.span,
                hint='use files with tissues, for example: use "matter/liver"',
            )  # fmt: skip

    def _refuse_quantity(self, name: s.Name) -> NoReturn:
        known = sorted({key for one in self.vocabulary.rules.values() for key in one.concluded})
        names = [QUANTITIES[key].name for key in known if key in QUANTITIES]
        if not self.vocabulary.rules and self.words.declarations.of("rules"):
            self.findings.stop()  # the rules have errors
        self.findings.reject(
            "TIS802", f"no rule concludes {name.text}, so words cannot be fitted to it",
            name.span,
            hint=alternatives(name.text, names, what="quantities that rules conclude")
            or 'use a vocabulary, for example: use "fuzzy/soft_matter"',
        )  # fmt: skip

    def _tissue(self, name: s.Name) -> Tissue:
        self.words.declarations.find("tissue", name, self.findings)
        tissue = self.words.tissues.get(name.key)
        if tissue is None:
            self.findings.stop()  # it has errors
        return tissue

    def _problem(self, tissue: Tissue, key: str) -> tuple[str, str, Hint | str] | None:
        """Return code, message and hint if words cannot be fitted to a number of a tissue."""
        what = f"{QUANTITIES[key].name} of {tissue.name}"
        if not tissue.vocabulary:
            hint = f"describe it: described in …, or remove {tissue.name} from the fit"
            return "TIS802", f"{tissue.name} is not described in words", hint
        rules = self.vocabulary.rules[s.key_of(tissue.vocabulary)]
        if key not in rules.concluded:
            hint = f"use the quantities that {rules.name} concludes, or add a rule"
            return "TIS802", f"no rule of {rules.name} concludes the {what}", hint
        answer = rules.base.conclude(key, {one.property: one.number for one in tissue.facts})
        if not isinstance(answer, Inference):
            hint = f"describe {tissue.name} with a property that the rules use"
            return "TIS802", f"words do not give the {what}: {why(rules, answer)}", hint
        if answer.source != "rules":
            hint = f"describe {tissue.name} with a property that the rules use"
            return "TIS802", f'words do not give the {what}, only its "otherwise" does', hint
        number, evidence = _number(tissue, key), _evidence(tissue, key)
        if number is None and evidence is None:
            hint = f"write a number or known {QUANTITIES[key].name} … in the tissue"
            return "TIS304", f"no number and no evidence is written for the {what}", hint
        if number is not None and evidence is not None:
            low, high = evidence
            if not low <= number <= high:
                show = QUANTITIES[key].show
                hint = "change the number or the evidence"
                return (
                    "TIS207",
                    f"the {what}, {show(number)}, contradicts its evidence, {show(low)} to "
                    f"{show(high)}",
                    hint,
                )
        axis = self.vocabulary.quantities[key].named.scale.axis
        for value in (number,) if number is not None else (evidence or ()):
            try:
                axis.to_scale(value)
            except (OutOfRange, ValueError):
                show = QUANTITIES[key].show
                return (
                    "TIS308",
                    f"the {what}, {show(value)}, is outside the range of its words, "
                    f"from {show(axis.low)} to {show(axis.high)}",
                    f"widen the range of the quantity, or remove {tissue.name} from the fit",
                )
        return None

    def _target(self, tissue: Tissue, key: str, weight: float, span: Span) -> WordTarget:
        axis = self.vocabulary.quantities[key].named.scale.axis
        number, evidence = _number(tissue, key), _evidence(tissue, key)
        low, high = axis.bounds
        deviation = DEVIATION if axis.log else LINEAR_DEVIATION * (high - low)
        how: Literal["written", "evidence"] = "written"
        if number is None and evidence is not None:
            ends = [axis.coordinate(end) for end in evidence]
            deviation = max(deviation, 0.5 * (ends[1] - ends[0]))
            number, how = _middle(tissue, key, axis.from_scale(sum(ends) / 2)), "evidence"
        assert number is not None
        return WordTarget(
            s.key_of(tissue.name), key, number, deviation, how, weight, False, span
        )

    def _enter(self, target: WordTarget) -> None:
        key = target.tissue, target.quantity
        if key in self.targets:
            what = f"the {target.quantity} of {target.tissue}"
            self.findings.refuse_second(what, target.span, self.targets[key].span)
        self.targets[key] = target

    # --- what is adjusted ---------------------------------------------------------------------

    def _adjust(self, item: s.Sentence) -> None:
        reader = self.reader(ADJUST, item)
        if reader.object.key not in (WORDS, WEIGHTS):
            self._only_words(item.span)
        said = reader.get()
        with self.findings.together():
            for name in said.owners:
                with self.findings.item():
                    self._adjust_one(said.literal, name)

    def _adjust_one(self, what: str, name: s.Name) -> None:
        if what == WEIGHTS:
            self.words.declarations.find("rules", name, self.findings)
            if name.key not in self.vocabulary.rules:
                self.findings.stop()
        else:
            scales = {key: one.named.name for key, one in self.vocabulary.quantities.items()}
            scales |= {key: one.name for key, one in self.vocabulary.properties.items()}
            if name.key not in scales:
                self.findings.pass_over_doubtful(name.key)
                self.findings.reject(
                    "TIS202",
                    f'"{name.text}" is not a quantity or property with words in the vocabulary',
                    name.span,
                    hint=alternatives(name.text, list(scales.values()), what="scales"),
                )
        if (what, name.key) in self.adjusted:
            first = self.adjusted[what, name.key]
            self.findings.refuse_second(f"{what} of {name.text}", name.span, first)
        self.adjusted[what, name.key] = name.span

    def _only_words(self, span: Span) -> NoReturn:
        self.findings.reject(
            "TIS801", "only words and weights of rules can be adjusted here", span,
            hint=f"write: adjust {WORDS} of QUANTITY",
        )  # fmt: skip

    # --- what is held out ---------------------------------------------------------------------

    def _hold(self, item: s.Item) -> None:
        with self.findings.together():
            for name in self._held_names(item):
                with self.findings.item():
                    key = s.key_of(self._tissue(name).name)
                    if key in self.held:
                        what = f'"hold out {key}"'
                        self.findings.refuse_second(what, name.span, self.held[key])
                    self.held[key] = name.span

    def _held_names(self, item: s.Item) -> Iterator[s.Name]:
        if isinstance(item, s.Assign) and not isinstance(item.value, s.Name | s.Listing):
            self._refuse_held(item.value.span)
        reader = self.reader("hold out", item)
        reader.texts = ["hold out = [skin, liver]"]
        form = TissuesHeld if isinstance(item, s.Assign) else TissueHeld
        for name in reader.get(form).held:
            if name.quoted is not None:
                self._refuse_held(name.span)
            yield name

    def _refuse_held(self, span: Span) -> NoReturn:
        self.findings.reject(
            "TIS312", "tissues are held out by their names", span,
            hint="for example: hold out skin or hold out = [skin, liver]",
        )  # fmt: skip

    def _hold_out(self) -> None:
        """Mark what is held out; something must be left to learn from."""
        with self.findings.together():
            for key, span in self.held.items():
                with self.findings.item():
                    names = sorted({target.tissue for target in self.targets.values()})
                    if key not in names:
                        self.findings.reject(
                            "TIS301", f"no number of {key} is fitted, so nothing is held out",
                            span, hint=alternatives(key, names, what="fitted tissues"),
                        )  # fmt: skip
        for key, target in self.targets.items():
            self.targets[key] = replace(target, held_out=target.tissue in self.held)
        if self.targets and all(target.held_out for target in self.targets.values()):
            self.findings.reject(
                "TIS306", "all tissues are held out, so there is nothing to learn from",
                next(iter(self.held.values())), hint="leave some tissues to learn from",
            )  # fmt: skip


def _number(tissue: Tissue, key: str) -> float | None:
    """Return a number that does not follow from words."""
    given = tissue.given.get(key)
    if given is None or given.how != "written" or given.value == given.quantity.none:
        return None
    return given.value


def _known(tissue: Tissue, key: str) -> list[KnownQuantity]:
    return [one for one in tissue.known if s.key_of(one.quantity.name) == key]


def _middle(tissue: Tissue, key: str, middle: float) -> float:
    """Return the number that evidence states, or else the middle of its range."""
    single = (one.stated[0] for one in _known(tissue, key) if len(one.stated) == 1)
    return next(single, middle)


def _evidence(tissue: Tissue, key: str) -> tuple[float, float] | None:
    """Return the intersection of the ranges of all evidence on a quantity."""
    known = _known(tissue, key)
    if not known:
        return None
    return max(one.low for one in known), min(one.high for one in known)
