"""Every shape of sentence and expression becomes its node, with true places."""

import gc
import re
import threading
from pathlib import Path

import pytest

from tests.every import every
from tests.growth import effort
from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.lang.characters import normalise
from tissuec.lang.parser import parse

EXAMPLES = Path(__file__).parent / "examples"


def parsed(text):
    return parse(normalise(f"language 1\n{text}", "test.tis"))


def item(text):
    (only,) = parsed(text).items
    return only


def value(text):
    return item(f"let a = {text}").value


def condition(text):
    return item(f"expect {text}").condition


def name(text):
    return s.Name(text, None, ANYWHERE)


def number(n):
    return s.Number(float(n), ANYWHERE)


ANYWHERE = Span(normalise("", "nowhere"), 0, 0)
X, Y, Z = name("x"), name("y"), name("z")


def span_free(kind, *parts):
    """Return a node whose place does not matter."""
    places = sum(name in ("span", "head", "rows_span") for name in kind.__struct_fields__)
    return kind(*parts, *[ANYWHERE] * places)


# --- expressions ------------------------------------------------------------------------------


@every(
    ("text", "expected"),
    [
        ("1", number(1)),
        ("2.5e-3", number(0.0025)),
        ("x", X),
        ("Half  way", name("Half way")),
        ('tissue "head of pancreas"', span_free(s.Name, "tissue", "head of pancreas")),
        ('"x"', span_free(s.Name, "", "x")),
        ('table "f.csv"', span_free(s.Name, "table", "f.csv")),
        ("3mm", span_free(s.Quantity, 3.0, "mm")),
        ("3 \t mm", span_free(s.Quantity, 3.0, "mm")),
        ("3 N·s/m", span_free(s.Quantity, 3.0, "N*s/m")),
        ("3 µm", span_free(s.Quantity, 3.0, "um")),
        ("3 μm", span_free(s.Quantity, 3.0, "um")),
        ("5 %", span_free(s.Quantity, 5.0, "%")),
        ("-x", span_free(s.Signed, X)),
        ("+x", X),
        ("-(+x)", span_free(s.Signed, X)),
        ("-0.1", span_free(s.Signed, number(0.1))),
        ("x^2", span_free(s.Power, X, number(2))),
        ("x^-2", span_free(s.Power, X, span_free(s.Signed, number(2)))),
        ("-x^2", span_free(s.Signed, span_free(s.Power, X, number(2)))),
        ("x + y - z", span_free(s.Sum, X, (("+", Y), ("-", Z)))),
        ("x * y / z", span_free(s.Product, X, (("*", Y), ("/", Z)))),
        ("x * -y", span_free(s.Product, X, (("*", span_free(s.Signed, Y)),))),
        ("x - (y + z)", span_free(s.Sum, X, (("-", span_free(s.Sum, Y, (("+", Z),))),))),
        ("(x, y, z)", span_free(s.Vector, (X, Y, Z), None)),
        ("(x, y, z) mm", span_free(s.Vector, (X, Y, Z), "mm")),
        ("(x, y, z) m/s^2", span_free(s.Vector, (X, Y, Z), "m/s^2")),
        ("[x, y]", span_free(s.Listing, (X, Y))),
        ("[x, y,]", span_free(s.Listing, (X, Y))),
        ("[]", span_free(s.Listing, ())),
        ("f(x)", span_free(s.Call, name("f"), (span_free(s.Argument, X, ()),))),
        ("f()", span_free(s.Call, name("f"), ())),
    ],
)
def test_values_become_nodes(text, expected):
    assert value(text) == expected


def test_products_bind_tighter_than_sums_and_powers_tighter_than_both():
    product = span_free(s.Product, Y, (("*", span_free(s.Power, Z, number(2))),))
    assert value("x + y * z^2") == span_free(s.Sum, X, (("+", product),))


def test_a_unit_ends_where_its_symbols_end():
    cube = span_free(s.Power, name("e"), number(3))
    expected = span_free(s.Product, span_free(s.Quantity, 40.0, "N/m^3"), (("*", cube),))
    assert value("40 N/m^3 * e^3") == value("40 N/m^3*e^3") == expected


def test_a_function_after_a_unit_is_no_unit():
    """A minute is written as "min", too."""
    product = value("2 N*min(3, 4)")
    ((sign, function),) = product.rest
    assert (product.first.unit, sign, function.function.text) == ("N", "*", "min")
    assert value("2 N*min").unit == "N*min"


def test_an_argument_may_carry_clauses():
    argument = span_free(s.Argument, X, (span_free(s.Clause, "to", Y),))
    assert value("distance(x to y)") == span_free(s.Call, name("distance"), (argument,))


def test_vectors_of_two_parts_parse_too():
    assert value("(x, y)") == span_free(s.Vector, (X, Y), None)


# --- conditions -------------------------------------------------------------------------------


def phrase(kind, *words):
    return span_free(s.Predicate, kind, tuple(name(word) for word in words))


@every(
    ("text", "expected"),
    [
        ("x < y", span_free(s.Compare, X, "<", Y)),
        ("x == y", span_free(s.Compare, X, "==", Y)),
        ("x != y", span_free(s.Compare, X, "!=", Y)),
        ("x is very soft", span_free(s.Is, X, phrase("word", "very soft"))),
        ("x is not soft", span_free(s.Is, X, phrase("not", "soft"))),
        ("x is between a and b", span_free(s.Is, X, phrase("between", "a", "b"))),
        ("x between y and z", span_free(s.Between, X, Y, Z)),
        ("x within y of z", span_free(s.Within, X, Y, Z)),
        ("within y of z", span_free(s.Within, None, Y, Z)),
        ("not x", span_free(s.Not, X)),
        ("not not x", X),
        ("not not not x", span_free(s.Not, X)),
        ("x and y and z", span_free(s.And, (X, Y, Z))),
        ("x or y and z", span_free(s.Or, (X, span_free(s.And, (Y, Z))))),
        ("(x or y) and z", span_free(s.And, (span_free(s.Or, (X, Y)), Z))),
        ("x is a and y", span_free(s.And, (span_free(s.Is, X, phrase("word", "a")), Y))),
    ],
)
def test_conditions_become_nodes(text, expected):
    assert condition(text) == expected


# --- sentences --------------------------------------------------------------------------------


@pytest.mark.parametrize("keyword", ["", "param", "let", "set"])
def test_assignments_hold_keyword_name_value_bounds_and_clauses(keyword):
    node = item(f"{keyword} a b = x between y and z in x where x < y")
    assert isinstance(node, s.Assign)
    assert (node.keyword, node.name, node.value) == (keyword, name("a b"), X)
    assert node.bounds == span_free(s.Bounds, Y, Z)
    assert [clause.word for clause in node.clauses] == ["in", "where"]


def test_sentences_hold_name_phrase_and_clauses():
    node = item("tissue scar is soft like x")
    assert node == span_free(
        s.Sentence,
        name("tissue scar"),
        phrase("word", "soft"),
        (span_free(s.Clause, "like", X),),
    )


def test_blocks_hold_items_and_the_place_of_their_head():
    node = item("mesh is tube on x { a = 1; b\n c { } }")
    assert isinstance(node, s.Block)
    assert [type(inner) for inner in node.items] == [s.Assign, s.Sentence, s.Block]
    assert node.head.text == "mesh is tube on x"
    assert node.span.text.endswith("c { } }")


@pytest.mark.parametrize("head", ["table nodes of net in mm", "nodes is table of net in mm"])
def test_tables_hold_their_rows_untouched_by_the_grammar(head):
    node = item(head + ' {\n  1 0\t0 # first\n\n 2 "a b"; 3 - ;\n}')
    assert isinstance(node, s.Table)
    assert node.name == name("nodes")
    assert [clause.word for clause in node.clauses] == ["of", "in"]
    assert node.rows == '1 0 0\n2 "a b"\n3 -'
    assert node.rows_span.text.startswith("\n  1 0\t0 # first")


def test_rules_hold_condition_conclusions_and_clauses():
    node = item("if x is soft\n then y is not low\n and z is between a and b weighing 0.5")
    assert isinstance(node, s.Rule)
    assert [c.quantity for c in node.conclusions] == [Y, Z]
    assert [c.phrase.kind for c in node.conclusions] == ["not", "between"]
    assert node.clauses == (span_free(s.Clause, "weighing", number(0.5)),)


def test_timed_sentences_hold_times_or_a_trigger():
    during = item("from 1 s to 2 s every x: move y by z")
    assert [clause.word for clause in during.times] == ["from", "to", "every"]
    assert during.trigger is None
    assert during.head.text == "from 1 s to 2 s every x:"
    once = item("when force(x) > 2 N: release y")
    assert once.times == ()
    assert isinstance(once.trigger, s.Compare)


def test_a_timed_group_holds_all_its_items():
    node = item("at 1 s: {\n fix x\n after 2 s: free x\n}")
    assert [type(inner) for inner in node.body] == [s.Sentence, s.Timed]
    assert node.span.text.endswith("}")
    assert len(item("at 1 s: law is y { a = 1 }").body) == 1


def test_expectations_hold_condition_and_clauses():
    node = item("expect not ruptured(x) until cut time")
    assert isinstance(node.condition, s.Not)
    assert [clause.word for clause in node.clauses] == ["until"]


def test_line_breaks_and_semicolons_separate_alike():
    assert parsed("a\nb\n").items == parsed("a;b;").items == parsed("\n;;a ;\n; b\n;").items


# --- places -----------------------------------------------------------------------------------


@every(
    ("text", "marked"),
    [("x + y ", "x + y"), ("(x + y) ", "(x + y)"), ("- x", "- x"), ("(1, 2)  mm", "(1, 2)  mm"),
     ("f(x , y)", "f(x , y)"), ('a "b c"', 'a "b c"'), ("[1 ]", "[1 ]"), ("x ^ 2", "x ^ 2")],
)  # fmt: skip
def test_spans_cover_what_was_written(text, marked):
    assert value(text).span.text == marked


def test_spans_know_line_and_column():
    span = parsed("a\n\n  b = ééé + 3 mm").items[1].value.rest[0][1].span
    assert (span.line, span.column, span.text) == (4, 13, "3 mm")


# --- examples, size and surroundings ----------------------------------------------------------


@pytest.mark.parametrize(
    ("file", "count"),
    [("soft_tissue", 13), ("fallopian_tube", 3), ("sterilisation", 21), ("indentation", 14),
     ("learn", 6)],
)  # fmt: skip
def test_examples_parse(file, count):
    raw = (EXAMPLES / f"{file}.tis").read_bytes()
    assert len(parse(normalise(raw, file)).items) == count


def test_long_sums_are_flat():
    total = value(" + ".join(["1"] * 20_000))
    assert len(total.rest) == 19_999


def test_a_table_of_many_rows_is_fast():
    rows = "".join(f" {i} 0.{i} 0.5 1e-3\n" for i in range(50_000))
    source = normalise("language 1\ntable nodes {\n" + rows + "}", "x")
    parse(normalise("language 1", "x"))
    cell = re.compile(r"[-+]?\d*\.?\d+(e[-+]?\d+)?")
    # It takes about a fifth of what one regular expression per cell would.
    one_by_one = min(effort(lambda: list(map(cell.fullmatch, rows.split()))) for _ in range(3))
    assert min(effort(lambda: parse(source)) for _ in range(3)) < 0.5 * one_by_one


def test_garbage_collection_is_left_as_it_was():
    assert gc.isenabled()
    parsed("a")
    assert gc.isenabled()
    gc.disable()
    try:
        parsed("a")
        assert not gc.isenabled()
    finally:
        gc.enable()


def test_threads_do_not_mix_their_texts():
    texts = {f"a{n}": "\n".join(f"a{n} = {n} mm" for _ in range(200)) for n in range(8)}
    found = {}

    def work(key):
        found[key] = {(i.name.words, i.span.source.name) for i in parsed(texts[key]).items}

    threads = [threading.Thread(target=work, args=(key,)) for key in texts]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == {key: {(key, "test.tis")} for key in texts}
