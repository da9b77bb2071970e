"""What is allowed at a place in a statement: by its block, first words and open brackets."""

from collections.abc import Iterator

from tissuec.core import units
from tissuec.core.units import Dimension
from tissuec.lsp import study
from tissuec.lsp import vocabulary as v
from tissuec.lsp.expected import Expected, argument, measured, number
from tissuec.lsp.forms import first_places, fitting, forms_of, together
from tissuec.lsp.prefix import Prefix
from tissuec.lsp.terms import VARIABLE, Terms, plain
from tissuec.lsp.vocabulary import entries
from tissuec.scene.reading.parts import PARTS, REPEAT
from tissuec.scene.tissues.evidence import KNOWN


def named_with(prefix: Prefix) -> Expected:
    """Return the completions right after the first words of a part or entry."""
    if prefix.subject == KNOWN:
        return Expected((v.KNOWN_TERMS,))
    return together(first_places(forms_of(prefix.block.kind, prefix.subject)))


def objects(prefix: Prefix) -> tuple[str, ...]:
    """Return the kinds of names that a verb takes as its subject."""
    forms = (one for one in forms_of("script", prefix.head) if one.literal == prefix.object)
    return together(first_places(forms)).names


def choices(prefix: Prefix) -> Expected:
    """Return the completions after "is"."""
    kind, subject = prefix.block.kind, prefix.subject
    if prefix.has("where"):
        return Expected(names=("region",)) if subject == "region" else Expected()
    if kind == "rules" and prefix.head == "if":
        return Expected(scale=subject)
    if subject == "otherwise":
        return Expected(scale=prefix.block.member)
    known = entries(prefix.block).get(subject)
    if known is None:
        return Expected(scale=subject)
    if known.choices:
        return Expected((known.choices,))
    clauses = (clause for form in forms_of(kind, subject) for clause in form.clauses)
    return next((one.expected for one in clauses if one.word == "is"), Expected())


def expected_in(prefix: Prefix) -> Expected:
    """Return the completions later in a statement."""
    last = prefix.last
    assert last is not None
    kind, head, call = prefix.block.kind, prefix.head, prefix.call
    if REPEAT in (head, prefix.subject) and call == "[":
        return Expected(declares="let")
    if last.text == "table" and head != "table":
        return Expected(files="table")
    if prefix.in_measure and call not in v.functions():
        return argument(prefix)
    if kind == "study" and (found := study.of_study(prefix)) is not None:
        return found
    if kind == "rules" and head == "if":
        if prefix.clause:
            return number()
        return Expected(names=("quantity",) if prefix.has("then") else ("property",))
    if call in v.HEDGE_TERMS and prefix.commas[-1]:
        return Expected((v.DIRECTION_TERMS,))
    if prefix.has("where"):
        return number(_conditions(prefix))
    if kind in ("tissue", "law") and prefix.subject in v.FORMULAS:
        return _formula(prefix)
    if prefix.clause or prefix.has("="):
        return in_clause(prefix)
    if prefix.has_verb and call == "[":
        return Expected((), objects(prefix))
    return _plain(prefix)


def _plain(prefix: Prefix) -> Expected:
    """Return the completions after ``=`` and similar signs."""
    match prefix.block.kind, prefix.head or prefix.subject:
        case "", "expect":
            return measured(v.errors())
        case "script", "when":
            return measured()
        case "", head if head in PARTS and PARTS[head].sentences:
            return together(first_places(forms_of("", head)))
        case _:
            return number()


def _formula(prefix: Prefix) -> Expected:
    """Return the variables of a formula of a law, or the terms that it may contain."""
    called, texts = prefix.subject, prefix.texts
    if "=" not in texts:
        return Expected((v.FORMULAS[called],), declares="variable")
    between = prefix.tokens[texts.index("of") + 1 : texts.index("=")] if "of" in texts else []
    own = plain(VARIABLE, [part.text for part in between if part.is_name])
    meant = set(v.ARGUMENTS[called]) - set(own)
    known = {key: term for key, term in v.FORMULAS[called].items() if key not in meant}
    return number(own, known)


def _conditions(prefix: Prefix) -> Terms:
    """Return the criteria of nodes or springs that may follow at this place."""
    texts = prefix.texts
    while len(texts) > 1 and texts[-1] == "(":
        texts.pop()
    since = max((n for n, text in enumerate(texts) if text == "between"), default=-1)
    is_limit = texts[-1] == "and" and since >= 0 and "and" not in texts[since:-1]
    begins = texts[-1] in ("where", "and", "or", "not") and not is_limit
    found = v.conditions(of_springs="springs" in texts, are_tests=begins)
    if prefix.block.kind == "body":  # regions are there before ids are
        return {key: term for key, term in found.items() if key != "id"}
    return found


# --- numbers ----------------------------------------------------------------------------------


def behind_number(prefix: Prefix) -> Expected:
    """Return the completions right after a number."""
    if prefix.block.kind == "study" and prefix.clause == "in":
        return Expected((study.STEPS_TERMS,))
    varied = prefix.object if prefix.subject == "vary" else ""
    return Expected(unit=True, dimension=_dimension(prefix), like=varied)


def _dimension(prefix: Prefix) -> Dimension | None:
    """Return the dimension of numbers at a place, as far as it is known."""
    if prefix.has("where"):
        return units.LENGTH
    if prefix.clause or (prefix.block.kind == "script" and not prefix.has_verb):
        of_clause = in_clause(prefix).dimension
        if of_clause is not None or prefix.has_verb:
            return of_clause
    if prefix.subject == "vary" and (term := study.entry_of(prefix.object)) is not None:
        return term.dimension
    is_known = prefix.subject == KNOWN
    known = v.KNOWN_TERMS if is_known else entries(prefix.block)
    term = known.get(prefix.object if is_known else prefix.subject)
    if term is not None and term.dimension is not None:
        return term.dimension
    return prefix.dimension


def in_clause(prefix: Prefix) -> Expected:
    """Return the completions after a joining word or "=", or later in that clause."""
    if prefix.block.kind == "script" and not prefix.has_verb:
        time = number()._replace(dimension=units.TIME)
        return measured() if prefix.head == "when" else time
    if prefix.clause == "in" and prefix.block.kind == "script":
        return Expected(unit=True, dimension=units.LENGTH)
    expected = together(_contents(prefix))
    last = prefix.last
    is_first = last is not None and last.text == prefix.clause
    is_name = any((*expected[:2], expected.declares, expected.files, expected.unit))
    if (prefix.has_verb and not is_first) or not is_name:
        several = number(*expected.terms)
        every = tuple(dict.fromkeys((*expected.names, *several.names)))
        return several._replace(names=every, dimension=expected.dimension)
    return expected


def _contents(prefix: Prefix) -> Iterator[Expected]:
    """Yield what can stand in a clause, from the forms of its sentence."""
    clause = prefix.clause or "="
    count = prefix.openers.count(clause)
    for form in fitting(prefix):
        found = [one.expected for one in form.clauses if one.word == clause]
        yield from found[count - 1 : count] or found
