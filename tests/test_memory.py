"""A memory forgets what has not been used for longest; statements and colours share it."""

from tissuec.core.keeping import Memory
from tissuec.core.source import Source
from tissuec.lang import known_statements
from tissuec.lang.grammar import StatementParser
from tissuec.lang.known_statements import KnownStatements
from tissuec.lang.parser import parse_tree
from tissuec.lang.tree_builder import tree_of
from tissuec.lsp import semantic_tokens
from tissuec.lsp.semantic_tokens import tokens_of


def test_the_least_recently_used_result_is_forgotten_first():
    memory, made = Memory(2), list[str]()

    def recall(key):
        return memory.recall(key, lambda: made.append(key) or key)

    for key in "abac":
        assert recall(key) == key
    assert made == ["a", "b", "c"]
    assert (memory.get("a"), memory.get("b"), memory.get("c")) == ("a", None, "c")
    memory.keep("a", "new")
    memory.keep("d", "d")
    assert (memory.get("a"), memory.get("c")) == ("new", None)


def test_a_statement_of_every_text_is_read_once(monkeypatch):
    monkeypatch.setattr(known_statements, "MOST_STATEMENTS", 3)
    known, words, read = KnownStatements(), Memory(3), list[str]()
    parse, kinds = StatementParser.parse, semantic_tokens._words

    def parsed(self, tokens, rule="statement"):
        read.append(" ".join(token.text for token in tokens))
        return parse(self, tokens, rule)

    def coloured(statement, block):
        read.append("".join(part.text for part in statement.parts))
        return kinds(statement, block)

    monkeypatch.setattr(StatementParser, "parse", parsed)
    monkeypatch.setattr(semantic_tokens, "_words", coloured)
    for number in range(2, 9):
        tree = tree_of(Source("a.tis", f"language 1\nlet a = 1\nlet a = {number}\n"))
        parse_tree(tree, known=known)
        tokens_of(tree, words)
    assert sorted(one for one in read if one.endswith("1") and "let" in one) == [
        "let a = 1",
        "leta=1",
    ]
