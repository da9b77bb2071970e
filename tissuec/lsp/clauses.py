"""What may follow the joining words of sentences: ``of``, ``with``, ``along``."""

from collections.abc import Iterator

from tissuec.core import units
from tissuec.lsp.expected import Expected, number
from tissuec.lsp.forms import fitting, together
from tissuec.lsp.measured import measured
from tissuec.lsp.prefix import Prefix


def in_clause(prefix: Prefix) -> Expected:
    """Return the completions after a joining word or "=", or later in that clause."""
    if prefix.block.kind == "script" and not prefix.has_verb:
        time = number()._replace(dimension=units.TIME)
        return measured() if prefix.head == "when" else time
    if prefix.clause == "in" and prefix.block.kind in ("mesh", "script"):
        return Expected(unit=True, dimension=units.LENGTH)
    expected = together(_contents(prefix))
    last = prefix.last
    is_first = last is not None and last.text == prefix.clause
    is_name = expected.names or expected.terms or expected.unit or expected.files
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
