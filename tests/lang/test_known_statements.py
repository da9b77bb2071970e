"""What is made of known statements is what the parser makes of a text, at the same places."""

import random

import pytest

from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.lang import known_statements
from tissuec.lang.known_statements import KnownStatements
from tissuec.lang.parser import parse_tree, readable_part
from tissuec.lang.tree_builder import tree_of
from tissuec.lang.walk import walk


def places(module):
    """Return all nodes with where they stand, and in which text."""
    return [
        (node, getattr(node, "span", None) and (node.span.start, node.span.end, node.span.text))
        for node in walk(module)
    ]


def outcome(tree, **options):
    """Return the module of a text, or its diagnostics."""
    try:
        return parse_tree(tree, **options)
    except CompileError as error:
        return error.diagnostics


def same(text: str, known: KnownStatements) -> None:
    source = Source("scene.tis", text)
    tree = tree_of(source)
    assert places(readable_part(tree, known)) == places(readable_part(tree))
    fresh, reused = outcome(tree), outcome(tree, known=known)
    if isinstance(fresh, tuple):
        assert reused == fresh
        return
    assert places(reused) == places(fresh)
    spans = [node.span for node in walk(reused) if hasattr(node, "span")]
    assert spans and all(span.source is source for span in spans)


@pytest.mark.parametrize("name", ["sterilisation", "bladder", "published_net"])
def test_a_text_that_is_edited_is_read_as_if_it_were_new(name, repository):
    text = (repository / f"library/scenes/{name}.tis").read_text(encoding="utf-8")
    known, chance = KnownStatements(), random.Random(name)
    same(text, known)
    for _ in range(8):
        place, length = chance.randrange(len(text)), chance.choice((0, 0, 1, 9, 60))
        new = chance.choice(("", " ", "\n", "5 mm", "}", "x = 3 N", text[place - 40 : place]))
        same(text[:place] + new + text[place + length :], known)


def test_equal_statements_are_parsed_once():
    known = KnownStatements()
    text = "language 1\n" + "param a = 3 mm\n" * 20
    parse_tree(tree_of(Source("a", text)), known=known)
    assert len(known._nodes._found) == 2


def test_no_more_statements_are_kept_than_a_few_long_texts_have(monkeypatch):
    monkeypatch.setattr(known_statements, "MOST_STATEMENTS", 5)
    known = KnownStatements()
    text = "language 1\n" + "".join(f"param a{n} = {n} mm\n" for n in range(20))
    same(text, known)
    assert len(known._nodes._found) <= 5
