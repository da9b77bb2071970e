"""The grammar itself: free of conflicts, in step with the table of words, kept on disk."""

import re
import subprocess
import sys

import pytest
from lark import Lark
from lark.exceptions import LarkError

from tissuec.core import keeping
from tissuec.lang import grammar, parse_table
from tissuec.lang.builder import Builder
from tissuec.lang.words import CONTINUING, RESERVED, STARTING


def terminals(parser):
    return {t.pattern.value: t.name for t in parser.terminals if t.pattern.type == "str"}


@pytest.fixture(scope="module")
def strict():
    return Lark(grammar.grammar_text(), strict=True, **grammar.OPTIONS)


def test_grammar_has_no_conflicts_and_no_colliding_terminals(strict):
    assert strict.parser is not None


def test_strict_mode_would_notice_a_conflict():
    doubled = grammar.grammar_text() + "\nstatement2: name | sentence\n"
    options = grammar.OPTIONS | {"start": ["statement", "heading", "statement2"]}
    with pytest.raises(LarkError):
        Lark(doubled, strict=True, **options)


def test_keywords_of_the_grammar_are_the_reserved_words(strict):
    keywords = {text for text in terminals(strict) if text.isalpha()}
    assert keywords == RESERVED


def test_each_keyword_is_one_terminal_named_after_it(strict):
    assert all(
        name == text.upper() for text, name in terminals(strict).items() if text.isalpha()
    )


def test_continuing_and_starting_words_are_reserved_and_disjoint():
    assert set(CONTINUING) < RESERVED
    assert STARTING < RESERVED
    assert not STARTING & set(CONTINUING)


def test_no_name_of_a_force_mesh_or_integrator_is_in_the_grammar():
    assert not re.search(
        r"gravity|forceps|tube|lattice|verlet|stiffness", grammar.grammar_text()
    )


def test_every_rule_has_a_method_of_the_builder(strict):
    names = {r.alias or r.origin.name for r in strict.rules if not r.options.expand1 or r.alias}
    names -= {n for n in names if n.startswith("_")}
    # Rules with "?" call their method only when they have more than one part.
    names |= {"conjunction", "disjunction", "sum", "product", "power"}
    assert {name for name in names if not hasattr(Builder, name)} == set()


@pytest.fixture
def built(monkeypatch):
    """Let no table be shipped."""
    monkeypatch.setattr(parse_table, "read", lambda: {"digest": ""})


def test_the_shipped_table_is_that_of_the_grammar():
    table = parse_table.read()
    expected = parse_table.digest(grammar.grammar_text(), table["version"])
    assert table["digest"] == expected, "run python -m tissuec.lang.parse_table"


def test_a_table_is_read_as_it_was_written(tmp_path, monkeypatch):
    monkeypatch.setattr(parse_table, "PATH", tmp_path / "table")
    parse_table.write()
    loaded = grammar.load_parser(Builder())
    assert isinstance(loaded, parse_table.StoredParser)
    assert terminals(loaded) == terminals(Lark(grammar.grammar_text(), **grammar.OPTIONS))


def test_a_corrupt_cache_file_is_built_anew(tmp_path, monkeypatch, built):
    monkeypatch.setattr(keeping, "cache_folder", lambda: tmp_path)
    grammar.load_parser(Builder())
    (path,) = tmp_path.iterdir()
    whole = path.read_bytes()
    for damaged in (b"", whole[:-100], whole[:65] + b"garbage"):
        path.write_bytes(damaged)
        assert grammar.load_parser(Builder()).terminals
        assert path.read_bytes() != damaged


def test_without_a_cache_folder_the_grammar_is_built_in_memory(monkeypatch, built):
    monkeypatch.setattr(keeping, "cache_folder", lambda: None)
    assert grammar.load_parser(Builder()).terminals


def test_a_changed_grammar_has_another_cache_file(tmp_path, monkeypatch, built):
    monkeypatch.setattr(keeping, "cache_folder", lambda: tmp_path)
    grammar.load_parser(Builder())
    text = grammar.grammar_text() + "\n// changed\n"
    monkeypatch.setattr(grammar, "grammar_text", lambda: text)
    grammar.load_parser(Builder())
    assert len(list(tmp_path.iterdir())) == 2


def test_parsing_and_formatting_import_no_heavy_libraries():
    code = (
        "import sys, tissuec.lang.printer, tissuec.lang.tables\n"
        "print([m for m in ('scipy', 'numba', 'h5py') if m in sys.modules])"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert result.stdout.strip() == "[]", result.stderr
