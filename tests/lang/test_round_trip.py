"""What holds for every text: random modules, random characters, and damaged scenes."""

from pathlib import Path
from random import Random

from hypothesis import example, given, settings
from hypothesis import strategies as st

from tests.every import every
from tests.examples import examples
from tissuec.core.errors import CompileError, as_dict, render
from tissuec.core.units import SYMBOLS
from tissuec.lang.characters import normalise
from tissuec.lang.parser import parse
from tissuec.lang.printer import format_source
from tissuec.lang.syntax import Module
from tissuec.lang.tree_builder import tree_of
from tissuec.lang.words import CONTINUING, JOINING_WORDS, TIME_WORDS

EXAMPLES = sorted((Path(__file__).parent / "examples").glob("*.tis"))

# --- texts that are valid by construction -----------------------------------------------------

NL = "\n"
WORDS = [
    "radius",
    "x",
    "Forceps",
    "A",
    "größe",
    "tableau",
    "iffy",
    "within_",
    "e3",
    "µ",
    "Ω",
    "m",
    "s",
]
QUOTED = ['"head of pancreas"', '"a # b; {c} (d"', '""', '"“ — ”"']
NUMBERS = ["0", "1", "2.50", "1e-3", "7E+2", "0.1"]
UNITS = [*sorted(SYMBOLS), "N*s/m", "N·s/m", "m/s^2", "kg/m^3", "s^-1", "µm/s"]
CELLS = ["1", "-2.5e3", "-", "stiff", '"dead band"']
BLANKS = [" ", "  ", "\t"]
LINE_ENDS = ["\n", "\n\n\n", "  # a remark\n", ";\n", "\n# own line\n", " ; ; \n"]


class Writer:
    """Writes random modules as lists of tokens; ``depth`` bounds how much may still nest."""

    def __init__(self, random):
        self.random = random

    def one(self, *choices):
        return self.random.choice(choices)

    def some(self, make, least, most, separator=None):
        """Return tokens of several parts with separators between them."""
        parts = [make() for _ in range(self.random.randint(least, most))]
        between = [] if separator is None else [separator]
        return [t for i, part in enumerate(parts) for t in ([*between, *part] if i else part)]

    def name(self):
        words = [self.one(*WORDS) for _ in range(self.random.randint(1, 3))]
        return self.one(words, words, [*words[1:], self.one(*QUOTED)])

    def quantity(self):
        return [self.one(*NUMBERS) + self.one("", " ", "\t ") + self.one(*UNITS)]

    def atom(self, depth):
        plain = [self.name, self.quantity, lambda: [self.one(*NUMBERS)]]
        plain.append(lambda: ["table", '"forces.csv"'])
        if not depth:
            return self.one(*plain)()
        value = lambda: self.sum(depth - 1)  # noqa: E731
        unit = f") {self.one(*UNITS)}"
        return self.one(
            *plain,
            lambda: ["(", *self.condition(depth - 1), ")"],
            lambda: ["(", *self.some(value, 2, 3, ","), self.one(")", unit)],
            lambda: ["[", *self.some(value, 0, 3, ","), "]"],
            lambda: ["[", *self.some(value, 1, 3, ","), ",", "]"],
            lambda: [
                *self.name(),
                "(",
                *self.some(lambda: self.argument(depth), 0, 2, ","),
                ")",
            ],
        )()

    def argument(self, depth):
        return self.condition(depth - 1) + self.clauses(0)

    def signs(self):
        return self.one([], [], ["-"], ["+"])

    def power(self, depth):
        exponent = self.one([], [], ["^", *self.signs(), *self.atom(depth)])
        return [*self.signs(), *self.atom(depth), *exponent]

    def product(self, depth):
        return self.some(lambda: self.power(depth), 1, self.one(1, 2), self.one("*", "/"))

    def sum(self, depth):
        sign = self.one("+ ", "- ")  # with a space, for a sign may follow
        return self.some(lambda: self.product(depth), 1, self.one(1, 2), sign)

    def phrase(self):
        name = self.name()
        return self.one(name, ["not", *name], ["between", *name, "and", *self.name()])

    def test(self, depth):
        value = self.sum(depth)
        return ["not"] * self.random.randint(0, 2) + self.one(
            lambda: value,
            lambda: [*value, self.one("<", "<=", ">", ">=", "==", "!="), *self.sum(depth)],
            lambda: [*value, "is", *self.phrase()],
            lambda: [*value, "between", *self.sum(depth), "and", *self.sum(depth)],
            lambda: [*self.one([], value), "within", *self.sum(depth), "of", *self.sum(depth)],
        )()

    def condition(self, depth):
        both = lambda: self.some(lambda: self.test(depth), 1, self.one(1, 2), "and")  # noqa: E731
        return self.some(both, 1, self.one(1, 2), "or")

    def clauses(self, depth):
        clause = lambda: [self.one(*TIME_WORDS, *JOINING_WORDS), *self.sum(depth)]  # noqa: E731
        return self.some(clause, 0, 2) + self.one([], [], ["where", *self.condition(0)])

    def head(self):
        return [*self.name(), *self.one([], ["is", *self.phrase()]), *self.clauses(1)]

    def assign(self):
        bounds = self.one([], [], ["between", *self.sum(0), "and", *self.sum(1)])
        keyword = self.one([], ["param"], ["let"], ["set"])
        return [
            *keyword,
            *self.name(),
            "=",
            *self.sum(self.one(0, 1, 2)),
            *bounds,
            *self.clauses(0),
        ]

    def rule(self):
        conclusions = self.some(lambda: [*self.name(), "is", *self.phrase()], 1, 2, "and")
        return ["if", *self.condition(1), "then", *conclusions, *self.clauses(0)]

    def table(self):
        row = lambda: [self.one(*CELLS) for _ in range(self.random.randint(1, 3))]  # noqa: E731
        head = self.one(["table", *self.name()], [*self.name(), "is", "table"])
        rows = self.some(row, 0, 3, NL)
        return [*head, *self.clauses(1), "{", NL, *rows, NL, "}"]

    def body(self, depth):
        return ["{", NL, *self.some(lambda: self.item(depth), 0, 3, NL), NL, "}"]

    def timed(self, depth):
        moment = self.one([self.one(*TIME_WORDS), *self.sum(1)], ["when", *self.condition(1)])
        return [*moment, ":", *self.one(self.head(), self.body(depth))]

    def item(self, depth=2):
        plain = [self.assign, self.head, self.rule, self.table]
        plain.append(lambda: ["expect", *self.condition(1), *self.clauses(1)])
        if depth:
            plain.append(lambda: [*self.head(), *self.body(depth - 1)])
            plain.append(lambda: self.timed(depth - 1))
        return self.one(*plain)()

    def module(self):
        """Return the text of a module with random blanks, line ends and comments."""
        pieces = ["language 1", self.one(*LINE_ENDS)]
        depth = 0
        for token in self.some(self.item, 0, 4, NL):
            depth += (token in ("(", "[")) - (token[0] in ")]")
            if token == NL:
                token = self.one(*LINE_ENDS)
            elif token in CONTINUING and not depth:
                token = self.one(token, token, f"\n {token}", f" # why\n\n{token}")
            pieces += (
                token,
                self.one(" ", "\n", "  # inside ) ]\n") if depth else self.one(*BLANKS),
            )
        return "".join(pieces)


# A seed and not a strategy for each choice, which takes fifty times as long.
modules = st.integers(0, 2**63).map(lambda seed: Writer(Random(seed)).module())


def comments_of(source):
    return [comment.text.rstrip() for comment in tree_of(source).comments]


@settings(max_examples=examples(200))
@given(modules)
def test_formatting_keeps_meaning_and_comments_and_is_idempotent(text):
    source = normalise(text, "random.tis")
    printed = normalise(format_source(source), "random.tis")
    assert parse(printed) == parse(source)
    assert comments_of(printed) == comments_of(source)
    assert format_source(printed) == printed.text


@settings(max_examples=examples(100))
@given(modules)
def test_formatted_text_has_no_needless_blanks_and_lines(text):
    printed = format_source(normalise(text, "random.tis"))
    assert "\n\n\n" not in printed
    assert printed.rstrip() + "\n" == printed
    assert all(line == line.rstrip() and "\t" not in line for line in printed.split("\n"))


@every("path", EXAMPLES)
def test_examples_survive_formatting(path):
    source = normalise(path.read_bytes(), path.name)
    printed = normalise(format_source(source), path.name)
    assert parse(printed) == parse(source)
    assert comments_of(printed) == comments_of(source)
    assert format_source(printed) == printed.text


# --- texts that are probably not valid --------------------------------------------------------


def assert_module_or_findings(text):
    """Parse a text and demand a module, or findings that lie inside the text and render."""
    try:
        module = parse(normalise(text, "fuzz.tis"))
    except CompileError as error:
        findings = error.diagnostics
    else:
        assert isinstance(module, Module)
        return
    assert 1 <= len(findings) <= 10
    starts = [finding.span.start for finding in findings]
    assert starts == sorted(starts)
    for finding in findings:
        for span in (finding.span, *(note.span for note in finding.notes)):
            assert 0 <= span.start <= span.end <= len(span.source.text)
        assert finding.message
        assert "^" in render(finding, color=True)
        assert as_dict(finding)["line"] >= 1


@settings(max_examples=examples(300))
@given(st.text())
@example("))\x1f\x1f\x08\x08\x08\x08[\x08")
@example("language 1\n)table x {\n1\n}")
@example("language 1\n“table x { 1 }")
@example("language 1\nx is table { } }{")
@example("language 1\n\ud800")
@example("language 1\ntable x {")
@example("language 1\nat 0 s: {{")
def test_any_text_gives_a_module_or_findings(text):
    assert_module_or_findings(text)
    assert_module_or_findings("language 1\n" + text)


@settings(max_examples=examples(300))
@given(st.binary())
def test_any_bytes_give_a_module_or_findings(raw):
    assert_module_or_findings(raw)


KEYWORDS = ["==", "if", "then", "is", "at", "3", "mm", "x", "table", "and"]
SIGNS = [*'\n;{}()[],:=<+-^"#%.', *KEYWORDS]


@settings(max_examples=examples(300))
@given(st.lists(st.sampled_from(SIGNS), max_size=40))
def test_any_tokens_give_a_module_or_findings(tokens):
    assert_module_or_findings("language 1\n" + " ".join(tokens))


@settings(max_examples=examples(200))
@given(st.data())
def test_damaged_scenes_give_a_module_or_findings(data):
    text = data.draw(st.sampled_from(EXAMPLES)).read_text(encoding="utf-8")
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(0, max(len(text) - 1, 0)))
        kind = data.draw(st.sampled_from(["delete", "double", "insert", "cut"]))
        if kind == "delete":
            text = text[:place] + text[place + 1 :]
        elif kind == "double":
            text = text[:place] + text[place : place + 20] + text[place:]
        elif kind == "insert":
            text = (
                text[:place] + data.draw(st.sampled_from('{}()[]";:=,.\n9“mA^#')) + text[place:]
            )
        else:
            text = text[: max(place, 1)]
    assert_module_or_findings(text)
