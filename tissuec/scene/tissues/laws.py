"""Laws of a tissue: by name with entries, or as a free formula."""

import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from typing import Annotated, Any, cast

import numpy as np
from msgspec import Struct, defstruct

from tissuec.core import units
from tissuec.core.fields import OneOf
from tissuec.core.hints import Edit, Hint, alternatives
from tissuec.core.registry import Family
from tissuec.core.source import Span
from tissuec.core.units import Dimension
from tissuec.lang import syntax as s
from tissuec.lang.walk import names_in
from tissuec.laws import (
    MODULUS,
    SPRING_LAWS,
    VISCOSITY_LAWS,
    SpringLaw,
    ViscosityLaw,
    of_stress,
)
from tissuec.laws.formula import (
    ONE,
    ZERO,
    Constant,
    Formula,
    Quotient,
    Variable,
    apply,
    extent,
    variables,
)
from tissuec.laws.solid import SOLID_LAWS, SolidLaw
from tissuec.scene.model import WrittenLaw, WrittenLaws
from tissuec.scene.program.declarations import Declarations, Declared
from tissuec.scene.reading import schema
from tissuec.scene.reading.block_sentences import SentenceKind, SentenceReader
from tissuec.scene.reading.entries import by_name, entry, written
from tissuec.scene.reading.expressions import InnerScope, Scope
from tissuec.scene.reading.parts import block, declare
from tissuec.scene.reading.values import Value
from tissuec.scene.tissues.quantities import YOUNGS_MODULUS
from tissuec.script.forms import VerbSentence, texts_of_sentences
from tissuec.script.parts import NameClause, Placeholder, ValueClause

TRIED = (1e-4, 1e-2, 0.3)  # of a metre, or metres per second, to either side
AT_REST = 1e-9  # of the largest force tried: one that rounding leaves
#: Parts of a formula, of its derivative, and how deep both are nested; Python's own limit on
#: nested brackets is 200.
MOST_PARTS, MOST_OF_SLOPE, DEEPEST = 4000, 40_000, 150
GROUP = 16  # terms or factors that are joined one after another
Entry = s.Sentence | s.Assign | s.Block | s.Function
SAMPLE = {"c": 1.0, "d": 1.0, "rest": 1.0, MODULUS.name: 1.0}


@cache
def formula_of(*names: str) -> type[VerbSentence]:
    """Return the class of sentences that give a formula of variables with some names."""
    words = dict(zip(names, ("of", "and"), strict=False))
    places = {name: (Placeholder(name, new="variable"),) for name in names}
    arguments = [
        (name, Annotated[s.Name, NameClause(word, what="variable", places=places[name])])
        for name, word in words.items()
    ]
    value = ("value", Annotated[s.Expression, ValueClause("=", place="NUMBER")])
    words_of = defstruct(
        "FormulaWords", [*arguments, value], bases=(VerbSentence,), frozen=True
    )
    return cast(type[VerbSentence], words_of)


class Form(Struct, frozen=True):
    """A free formula of a law.

    Attributes:
        name: "spring force", before the arguments.
        about: What it is, in one sentence.
        dimension: Of what the formula gives.
        arguments: Variable of formulas and dimension of each argument; a
            formula may leave out all but the last.
        names: What else it can use: variable and dimension.
        as_force: Returns what a spring does, from the formula.
    """

    name: str
    about: str
    dimension: Dimension
    arguments: tuple[tuple[str, Dimension], ...]
    names: Mapping[str, tuple[str, Dimension]]
    as_force: Callable[[Formula], Formula] = lambda formula: formula

    @property
    def sentences(self) -> tuple[type[VerbSentence], ...]:
        """The classes of its sentences, the one with fewest arguments first."""
        names = [name for name, _ in self.arguments]
        return tuple(formula_of(*names[-count:]) for count in range(1, len(names) + 1))

    @property
    def heads(self) -> tuple[str, ...]:
        """The left-hand sides of the law, the one with fewest arguments first."""
        texts = texts_of_sentences(self.name, self.sentences)
        return tuple(text.partition(" = ")[0] for text in texts)

    @property
    def entry(self) -> schema.Entry:
        """The entry of a tissue that gives it."""
        begins = f"{self.heads[0].removeprefix(self.name)} = "
        return written(self.name, self.about, *self.sentences, begins=begins)

    def variables(self, item: s.Function) -> dict[str, tuple[str, Dimension]]:
        """Return all that a formula can use: variable and dimension by name."""
        written = [name.key for name in _names(item)]
        meant = self.arguments[-len(written) :]
        return {**self.names, **dict(zip(written, meant, strict=True))}


class LawKind(Struct, frozen=True):
    """Syntax of one of the laws of a tissue: by name after ``word``, or as a formula.

    Attributes:
        family: Of the laws with a name.
        word: Of the entry.
        about: What it is, in one sentence.
        forms: As a formula; there may be none.
        formula: Returns what a law with a name does.
        example: A law with a name, for messages.
    """

    family: Family[type[SpringLaw]] | Family[type[ViscosityLaw]] | Family[type[SolidLaw]]
    word: str
    about: str
    forms: tuple[Form, ...] = ()
    formula: Callable[[Any], Formula] = operator.methodcaller("force")
    example: str = "linear"

    @property
    def entry(self) -> schema.Entry:
        """The entry that chooses it by its name."""
        return entry(self.word, OneOf(self.family, True, self.family), self.about)


_MEANINGS = {"e": "the elongation", "w": "the speed", "strain": "the strain"}
_LENGTHENING = (("e", units.LENGTH),)
_SPEED = (("w", units.VELOCITY),)
_REST = {"rest length": ("rest", units.LENGTH)}
_STIFF = dict.fromkeys(("c", "spring constant"), ("c", units.STIFFNESS))
_VISCOUS = dict.fromkeys(("d", "viscosity"), ("d", units.VISCOSITY))
_MODULUS = {YOUNGS_MODULUS: (MODULUS.name, units.PRESSURE)}
SOLID_LAW = "solid law"
LAW_KINDS = (
    LawKind(
        SPRING_LAWS,
        "spring law",
        "The law of the springs by name, instead of linear springs.",
        (
            Form(
                "spring force",
                "A formula for the force of a spring as a function of its elongation e.",
                units.FORCE, _LENGTHENING, _STIFF | _REST,
            ),
            Form(
                "stress",
                "A formula for the nominal stress of a bar as a function of its strain.",
                units.PRESSURE, (("strain", units.NUMBER),), _MODULUS, of_stress,
            ),
        ),
    ),
    LawKind(
        VISCOSITY_LAWS,
        "viscosity law",
        "The law of the dashpots by name, instead of linear dashpots.",
        (
            Form(
                "viscous force",
                "A formula for the force of a dashpot as a function of its rate of elongation "
                "w, or of its elongation e and w.",
                units.FORCE, _LENGTHENING + _SPEED, _VISCOUS | _REST,
            ),
        ),
    ),
    LawKind(
        SOLID_LAWS,
        SOLID_LAW,
        "The law of bodies made of elements by name, instead of neo-Hookean ones.",
        formula=operator.methodcaller("energy"),
        example="yeoh { second = 0.5 }",
    ),
)  # fmt: skip
#: Every free formula, by what it is called.
FORMS = {form.name: form for kind in LAW_KINDS for form in kind.forms}
#: The entries that choose laws, and those that give them as formulas.
LAW_ENTRIES = by_name(*(one.entry for one in (*LAW_KINDS, *FORMS.values())))
declare(
    "law", "Laws of springs and dashpots for use in rows of a table.", 20,
    block=block(LAW_ENTRIES),
)  # fmt: skip
#: The kind of law that an entry of a tissue writes, by its name.
BY_ENTRY = {
    name: kind
    for kind in LAW_KINDS
    for name in (kind.word, *(form.name for form in kind.forms))
}


def read_laws(declarations: Declarations, scope: Scope) -> dict[str, WrittenLaws]:
    """Return every ``law`` block by lower-case name; a mistake rejects one only."""
    laws = declarations.read_each("law", lambda d: _read_block(d, scope), scope.findings)
    for key, declared in declarations.of("law").items():
        if key not in laws:
            scope.findings.doubt(declared.name)
    return laws


def _read_block(declared: Declared, scope: Scope) -> WrittenLaws:
    """Return the laws of springs and dashpots that a block writes."""
    block, findings = declared.item, scope.findings
    assert isinstance(block, s.Block)
    found: dict[str, WrittenLaw] = {}
    with findings.together():
        for item in block.items:
            with findings.item():
                _read_entry(item, found, scope)
    if not block.items:
        findings.reject(
            "TIS304",
            f"law {declared.name.text} is empty",
            block.head,
            hint=schema.missing("spring law is toe { strain = 3 % }", block.head),
        )
    return found


def _read_entry(item: s.Item, found: dict[str, WrittenLaw], scope: Scope) -> None:
    """Enter one law of a block, or reject it."""
    if not isinstance(item, Entry) or item.name.key not in BY_ENTRY:
        scope.findings.reject(
            "TIS303",
            "this is not allowed in a law",
            item.span,
            hint=f"entries: {', '.join(BY_ENTRY)}",
        )
    kind = BY_ENTRY[item.name.key]
    if kind.word in found:
        scope.findings.refuse_second(f'"{kind.word}"', item.span, found[kind.word].span)
    found[kind.word] = read_law(kind, item, scope)


def read_law(kind: LawKind, item: Entry, scope: Scope) -> WrittenLaw:
    """Return a law from its entry, or reject it.

    Args:
        kind: Which law of the tissue it is.
    """
    if isinstance(item, s.Function) and item.name.key in FORMS:
        return _free(FORMS[item.name.key], item, scope)
    if isinstance(item, s.Sentence | s.Block) and item.name.key == kind.word:
        return _named(kind, item, scope)
    is_word = isinstance(item, s.Assign) and isinstance(item.value, s.Name)
    if is_word and item.name.key == kind.word:
        schema.refuse_sign(item, scope, example=f"{kind.word} is {kind.example}")
    forms = FORMS.get(item.name.key), *kind.forms
    others = [f', or "{form.heads[0]} = …"' for form in forms if form is not None]
    scope.findings.reject(
        "TIS312",
        f"wrong form of {kind.word}",
        item.span,
        hint=f'write "{kind.word} is …"{others[0] if others else ""}',
    )


def _named(kind: LawKind, item: s.Sentence | s.Block, scope: Scope) -> WrittenLaw:
    name = schema.word_of(item, scope, example=f"{kind.word} is {kind.example}")
    if name.key not in kind.family:
        scope.findings.reject(
            "TIS305",
            f'there is no {kind.word} called "{name.text}"',
            name.span,
            hint=alternatives(name.key, kind.family, what=f"{kind.word}s"),
        )
    items = item.items if isinstance(item, s.Block) else ()
    where = item.head if isinstance(item, s.Block) else item.span
    law, _ = schema.build(
        kind.family[name.key], items, scope, what=f"{kind.word} {name.key}", where=where
    )
    return WrittenLaw(name.key, kind.formula(law), item.span, law)


def _free(form: Form, item: s.Function, scope: Scope) -> WrittenLaw:
    _check_arguments(form, item, scope)
    kind = form.sentences[len(item.arguments) - 1]
    node = SentenceReader(form.name, SentenceKind((kind,)), item, scope).get().value
    variables = FormulaScope(scope, form.variables(item))
    value = variables.number(node)
    variables.expect(value, form.dimension, node.span, what=form.name)
    formula = variables.formula(node)
    _limit(form, formula, node.span, scope)
    _try(form, formula, node.span, scope)
    return WrittenLaw(node.span.one_line, form.as_force(formula), item.span)


def _check_arguments(form: Form, item: s.Function, scope: Scope) -> None:
    """Reject arguments that are none, or that mean something else."""
    hint = Hint(f"write {' or '.join(f'{head} = …' for head in form.heads)}")
    first, last = item.arguments[0], item.arguments[-1]
    if first.word != "of":
        scope.findings.reject(
            "TIS312", "a formula must name its variables after of", first.span, hint=hint
        )
    if len(item.arguments) > len(form.arguments):
        scope.findings.reject(
            "TIS312",
            f"a {form.name} has one variable",
            first.span.to(last.span),
            hint=Hint(hint, *_used_alone(item)),
        )
    names = _names(item)
    meant = [own for own, _ in form.arguments[-len(names) :]]
    for number, (name, own) in enumerate(zip(names, meant, strict=True)):
        others = {
            one.key: _MEANINGS[key] for one, key in zip(names[:number], meant, strict=False)
        }
        others |= {key: _MEANINGS[key] for key in meant if key != own}
        others |= dict.fromkeys(form.names, "a quantity of the spring")
        if name.key in others:
            scope.findings.reject(
                "TIS503",
                f'"{name.text}" already denotes {others[name.key]}',
                name.span,
                hint=Hint(
                    f"call it {own}: {form.heads[len(names) - 1]}",
                    *_exchanged(names, meant),
                ),
            )


def _names(item: s.Function) -> list[s.Name]:
    """Return the arguments of a formula; the grammar takes only names."""
    return [cast(s.Name, argument.value) for argument in item.arguments]


def _used_alone(item: s.Function) -> list[Edit]:
    """Return the edit that keeps the one argument that a formula uses, if it is one."""
    names = {part.key for part in names_in(item.value)}
    used = [one.value for one in item.arguments if s.key_of(one.value.span.text) in names]
    return [Edit(f"of {used[0].span.text}")] if len(used) == 1 else []


def _exchanged(names: Sequence[s.Expression], meant: Sequence[str]) -> list[Edit]:
    """Return the edit that puts two arguments in their order, if they only changed places."""
    if len(names) != 2 or {s.key_of(name.span.text) for name in names} != set(meant):
        return []
    first, second = names
    between = first.span.source.text[first.span.end : second.span.start]
    return [Edit(f"{second.span.text}{between}{first.span.text}", first.span.to(second.span))]


def _limit(form: Form, formula: Formula, span: Span, scope: Scope) -> None:
    """Reject a formula that is too long to be compiled, or whose derivative is."""
    (parts, depth), hint = extent(formula), "use a measured curve: spring law is curve { … }"
    if parts <= MOST_PARTS and depth <= DEEPEST:
        slopes = [extent(formula.slope(name)) for name, _ in form.arguments]
        if all(parts <= MOST_OF_SLOPE and depth <= DEEPEST for parts, depth in slopes):
            return
    message = f"the {form.name} is too long or too deeply nested to be compiled"
    scope.findings.reject("TIS116", message, span, hint=hint)


def _try(form: Form, formula: Formula, span: Span, scope: Scope) -> None:
    """Reject a formula that has no value somewhere near rest, or brakes at zero speed."""
    places = np.array([*(-t for t in TRIED), 0.0, *TRIED])
    grid = np.meshgrid(*(places for _ in form.arguments), indexing="ij")
    known = {name: each for (name, _), each in zip(form.arguments, grid, strict=True)}
    with np.errstate(all="ignore"):
        found = np.broadcast_to(formula.at(SAMPLE | known), grid[0].shape)

    def shown(where: np.intp, names: Iterable[str]) -> str:
        parts = [
            units.show(float(known[name].flat[where]), dimension)
            for name, dimension in form.arguments
            if name in names
        ]
        return f" at {' and '.join(parts)}" if parts else ""

    bad = np.isnan(found)
    if bad.any():
        scope.findings.reject(
            "TIS504",
            f'"{span.one_line}" has no value{shown(np.argmax(bad), variables(formula))}',
            span,
            hint="springs are compressed as well as stretched: use max(…, 0) or abs(…)",
        )
    if "w" not in known:
        return
    left = np.where(known["w"] == 0.0, np.abs(found), 0.0)
    if left.max() > AT_REST * np.abs(found[np.isfinite(found)]).max(initial=0.0):
        force = units.show(float(found.flat[np.argmax(left)]), units.FORCE)
        at = shown(np.argmax(left), variables(formula) - {"w"})
        scope.findings.reject(
            "TIS309",
            f"the viscous force at zero speed is {force}{at}",
            span,
            hint="a force at zero speed belongs in the spring force",
        )


class FormulaScope(InnerScope):
    """Scope of a free formula, which builds its tree.

    Args:
        constants: Scope of everything that is not a variable.
        variables: Variable of formulas and dimension, by name in the language.
        exponents: Variables of formulas that are allowed in exponents.
    """

    is_known = False

    def __init__(
        self,
        constants: Scope,
        variables: Mapping[str, tuple[str, Dimension]],
        exponents: Iterable[str] = (),
    ):
        super().__init__(constants)
        self.variables = variables
        self.exponents = frozenset(exponents)
        self.arguments: tuple[Formula, ...] = ()  # of the function whose value this is in

    def name(self, name: s.Name) -> Value:
        """Return a variable as something of its dimension, or a constant."""
        if name.key in self.variables:
            return Value(np.asarray(1.0), self.variables[name.key][1])
        return self.constants.name(name)

    def has(self, name: s.Name) -> bool:
        """Return whether a name denotes a variable or a constant."""
        return name.key in self.variables or self.constants.has(name)

    def names(self) -> Sequence[str]:
        """Return variables and constants."""
        return [*self.variables, *self.constants.names()]

    def formula(self, node: s.Expression) -> Formula:
        """Return the tree of an expression whose dimensions have been checked."""
        match node:
            case s.Name() if node.key in self.variables:
                return Variable(self.variables[node.key][0])
            case s.Number() | s.Quantity() | s.Name():
                return Constant(float(self.evaluate(node).amount))
            case s.Signed():
                return -self.formula(node.operand)
            case s.Sum():
                terms = [("+", node.first), *node.rest]
                return _joined([(sign, self.formula(part)) for sign, part in terms], "+")
            case s.Product():
                factors = [("*", node.first), *node.rest]
                total = _joined([(sign, self.formula(part)) for sign, part in factors], "*")
                self._not_by_zero(total, node)
                return total
            case s.Power():
                exponent = self.formula(node.exponent)
                if not variables(exponent) <= self.exponents:
                    self.findings.reject(
                        "TIS502",
                        "an exponent must be a plain number",
                        node.exponent.span,
                        hint="for a power with a variable exponent, use exp and log",
                    )
                return self.formula(node.base) ** exponent
            case s.FormalParameter():
                return self.arguments[node.number]
            case s.Applied(value=value):
                if value is None:
                    self.findings.stop()
                inside = FormulaScope(self.constants, {}, self.exponents)
                inside.arguments = tuple(map(self.formula, node.arguments))
                return inside.formula(value)
            case s.Call():
                arguments = tuple(self.formula(argument.value) for argument in node.arguments)
                return apply(node.function.key, arguments)
            case _:
                self.findings.reject("TIS312", "a number is needed here", node.span)

    def _not_by_zero(self, formula: Formula, node: s.Product) -> None:
        if isinstance(formula, Quotient) and formula.below == Constant(0.0):
            self.findings.reject(
                "TIS504", f'division by zero: "{node.span.text}"', node.rest[-1][1].span
            )


def _quotient(above: Formula, below: Formula) -> Formula:
    return above / below


_JOIN: Mapping[str, Callable[[Formula, Formula], Formula]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": _quotient,
}  # fmt: skip


def _joined(parts: Sequence[tuple[str, Formula]], sign: str) -> Formula:
    """Return the sum (``sign`` "+") or product ("*") of parts, each after its own sign.

    Long ones are joined group by group, so that the tree is not as deep as they are long.
    """
    while len(parts) > GROUP:
        groups = (parts[start : start + GROUP] for start in range(0, len(parts), GROUP))
        parts = [(sign, _chain(group, sign)) for group in groups]
    return _chain(parts, sign)


def _chain(parts: Sequence[tuple[str, Formula]], sign: str) -> Formula:
    (first, total), *rest = parts
    if first != sign:
        total = _JOIN[first](ZERO if sign == "+" else ONE, total)
    for each, part in rest:
        total = _JOIN[each](total, part)
    return total
