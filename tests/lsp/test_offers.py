"""No offer is one that cannot stand: each is typed in its place, and the text read again."""

import random
import re
from collections.abc import Iterator

import pytest

from tests.every import every
from tests.lsp.editor_documents import GOOD, LIBRARY, asked
from tissuec.core.source import Source
from tissuec.lang.grammar import Refused
from tissuec.lang.parser import accepted_behind, statement_parser
from tissuec.lang.tree_builder import tree_of
from tissuec.lsp.completion import Proposal, complete
from tissuec.lsp.documents import OpenDocuments
from tissuec.lsp.findings import check
from tissuec.lsp.views import View, view_of

SCENES = [*LIBRARY, *GOOD]
#: Longer scenes take long to check, and hold nothing that shorter ones do not.
LONGEST = 6000
SHORT = [path for path in SCENES if len(path.read_text(encoding="utf-8")) < LONGEST]
#: What says that a word is unknown, or is not one of those that can stand in its place.
UNKNOWN = frozenset(
    ("TIS100", "TIS104", "TIS202", "TIS203", "TIS205", "TIS301", "TIS303", "TIS305", "TIS307",
     "TIS314", "TIS404", "TIS405", "TIS601", "TIS701", "TIS702")
)  # fmt: skip
#: What comes behind an offer to make a statement of it, by how it ends.
BEHIND = {
    "region ": "x where x > 1 mm { prestress = 0 N }", "known ": 'density = 1 g/cm^3 by "A"',
    "rupture is ": "allowed", "precision is ": "single", 'use "': 'fuzzy/soft_tissue"',
    "interface ": "from x to y { prestress = 0 N }",
    "distance of ": "x to y every 1 ms", "count(": "nodes of x)", " = [": "x]", " { ": "}",
    " from ": "1 to 2", " every ": "1 ms", " where ": "x > 1 mm { }", ' "': 'x"', " = ": "1",
    "(": "1)", " ": "x",
}  # fmt: skip


def finished(one: Proposal) -> str:
    """Return what an offer types, with what has to come behind it."""
    ends = (end for end in BEHIND if one.insert.endswith(end))
    return one.insert + BEHIND.get(next(ends, ""), "")


# --- syntax -----------------------------------------------------------------------------------


def places(view: View, chance: random.Random, part: float) -> Iterator[tuple[int, int]]:
    """Yield where words of a text begin, or could follow, with where their block begins."""
    for statement in view.structure.statements:
        if any(head.is_table for head in statement.chain) or chance.random() > part:
            continue
        begin = (statement.chain or [statement])[0].start
        for word in statement.parts:
            yield begin, word.start
        if statement.parts and view.source.text[statement.parts[-1].stop :][:1] == " ":
            yield begin, statement.parts[-1].stop + 1


def can_be_read(view: View, begin: int, one: Proposal) -> bool:
    """Return whether the grammar reads a text from a block on to the end of an offer."""
    text = view.source.text[begin : one.start] + one.insert
    is_first = not re.sub(r"#[^\n]*", "", view.source.text[:begin]).strip()
    rule = "heading" if is_first else "statement"
    for statement in tree_of(Source("text", text + _closing(text))).statements:
        if sentence := statement.sentence:
            if statement.is_behind_block:
                return sentence[0].start >= len(text.rstrip())
            try:
                accepted = statement_parser().accepted(sentence, rule)
            except Refused as refused:
                return sentence[refused.place].start >= len(text.rstrip())
            if "$END" not in accepted:
                return statement.stop >= len(text.rstrip())
            rule = "statement"
    return True


def _closing(text: str) -> str:
    """Return the round and square brackets that are still open."""
    waiting: list[str] = []
    for sign in re.sub(r'#[^\n]*|"[^"\n]*"?', "", text):
        if sign in "([":
            waiting.append({"(": ")", "[": "]"}[sign])
        elif sign in ")]" and waiting:
            waiting.pop()
    return "".join(reversed(waiting))


@pytest.mark.parametrize("part", [0.02, pytest.param(1.0, marks=pytest.mark.slow)])
@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_the_grammar_reads_every_offer(path, part):
    view, chance = view_of(OpenDocuments(), path), random.Random(path.stem)
    wrong = {
        (view.source.text[max(begin, one.start - 40) : one.start], one.insert)
        for begin, offset in places(view, chance, part)
        for one in complete(view, offset)
        if not can_be_read(view, begin, one)
    }
    assert wrong == set()


# --- meaning ----------------------------------------------------------------------------------


def typed(view: View, phrase, one: Proposal) -> str | None:
    """Return a scene with an offer in the place of a phrase, None if its rest cannot follow.

    At the beginning of a statement an entry takes the place of all of it.
    """
    text, statement = view.source.text, phrase.statement
    if phrase.start == statement.parts[0].start and phrase.block.kind != "script":
        end = statement.close if statement.is_head else statement.stop
        return text[: one.start] + finished(one) + text[end:]
    behind = text[phrase.stop :]
    written = one.insert.rstrip()
    if behind.startswith("("):
        if not written.endswith("("):
            return None
        written = written[:-1]
    elif written.endswith("("):
        written = finished(one)
    # The sign or word behind a name stands there already, or another one.
    written = re.sub(r"( is| =| of| from)$", "", written)
    return text[: one.start] + written + behind


def refused(path, view: View, phrase, one: Proposal) -> list[str]:
    """Return what is said of an offer that is unknown in its place."""
    text = typed(view, phrase, one)
    if text is None:
        return []
    documents = OpenDocuments()
    documents.put(path, text)
    stop = one.start + len(one.insert) - len(one.insert.removeprefix(one.label))
    is_entry = phrase.start == phrase.statement.parts[0].start and phrase.block.kind != "script"
    return [
        f"{finding.message}, in: {text[phrase.statement.start : stop].strip()}"
        for finding in check(documents, path, thorough=False).diagnostics
        if finding.code in UNKNOWN
        and finding.span is not None
        and finding.span.source.path == path
        and one.start <= finding.span.start < stop
        and (is_entry or finding.span.end <= stop)
    ]


def is_said_elsewhere(phrase, one: Proposal) -> bool:
    """Return whether what an offer needs stood in the words that it replaces."""
    first = phrase.statement.words[:1]
    if one.kind == "property":
        return first == ["described"]
    # A region or group is compared by "is", another coordinate by a sign; what a quantity
    # applies to depends on it.
    return one.label in ("region", "group", "surface", "bending", "applies")


@pytest.mark.parametrize("count", [1, pytest.param(6, marks=pytest.mark.slow)])
@pytest.mark.parametrize("path", SHORT, ids=lambda path: path.stem)
def test_no_offer_is_unknown_in_its_place(path, count):
    view, chance = view_of(OpenDocuments(), path), random.Random(path.stem)
    phrases = [phrase for phrase in view.all_phrases() if phrase.parts]
    for phrase in chance.sample(phrases, min(2 * count, len(phrases))):
        offers = [
            one
            for one in complete(view, phrase.start)
            if one.kind not in ("keyword", "unit", "file") and one.start == phrase.start
        ]
        for one in chance.sample(offers, min(count, len(offers))):
            if not is_said_elsewhere(phrase, one):
                assert refused(path, view, phrase, one) == []


# --- some places ------------------------------------------------------------------------------

HEAD = """language 1
tissue gum { spring constant = 40 N/m; viscosity = 10 mN*s/m; mass = 5 g }
body left { mesh is tube { axis from (0, 0, 0) mm to (9, 0, 0) mm; radius = 3 mm; rings = 4;
  sides = 5 }; tissue is gum }
body right { mesh is tube { axis from (20, 0, 0) mm to (29, 0, 0) mm; radius = 3 mm; rings = 4;
  sides = 5 }; tissue is gum }
set some = nodes of left where x < 1 mm
set threads = springs of left where length > 1 mm
set both = [threads]
joint seam { springs from left to right; tissue is gum }
tool shears { kind is scissors }
tool grip { kind is forceps }
tool haemostat { kind is clamp }
"""


@every(
    ("text", "can", "cannot"),
    [
        ("script { at 0 s: fix ‸ }", {"some", "left"}, {"threads", "both", "seam", "grip"}),
        ("script { at 0 s: cut ‸ }", {"threads", "both", "left"}, {"grip"}),
        ("script { at 0 s: grasp some with ‸ }", {"grip", "haemostat"}, {"shears"}),
        ("script { from 0 s to 1 s: close ‸ }", {"grip"}, {"haemostat"}),
        ("tool a { kind is needle; ‸ }", {"shaft", "size"}, {"radius"}),
        ("script { at 0 s: cut left with ‸ }", {"shears"}, {"grip"}),
        ("script { at 0 s: change mass of ‸ }", {"some"}, {"threads"}),
        ("script { at 0 s: change viscosity of ‸ }", {"threads", "seam"}, {"grip"}),
        ("expect tension(‸", {"threads", "seam"}, {"grip", "shears"}),
        ("expect force(‸", {"some", "grip"}, {"threads", "shears"}),
        ("expect count(pieces of ‸", {"left"}, {"threads"}),
        ("expect ‸", {"count"}, {"pieces", "nodes"}),
        ("output { tension(‸ }", {"threads"}, {"grip"}),
        ("output { trajectory every 1 ms; ‸ }", {"force"}, {"trajectory"}),
        ("set a = nodes of ‸", {"left"}, {"seam"}),
        ("set a = springs of left where ‸", {"length"}, {"surface"}),
        ("set a = nodes of left where ‸", {"surface"}, {"length", "bending"}),
        ("simulate { duration = 1 s; ‸ }", {"step"}, {"duration"}),
        ("tissue t { spring law is linear; ‸ }", {"mass"}, {"spring law", "spring force"}),
        ("tissue t { viscous force of a = d * ‸ }", {"a", "d"}, {"w", "e"}),
        ("expect force(some) > 1 N ‸", {"at", "over"}, {"then", "is", "set"}),
        ("let a = 3 mm ‸", set(), {"is", "to"}),
        ("study s { design is grid; ‸ }", {"vary", "keep"}, {"design", "language"}),
        ("study s { vary rings of ‸ }", {"left"}, {"gum", "some"}),
        ("study s { vary a = 3 mm ‸ }", {"to"}, {"in", "by", "of"}),
        ("study s { measure p = force(some) ‸ }", {"at"}, {"of", "to", "from", "over"}),
        ("study s { measure p = force(‸ }", {"some", "grip"}, {"threads", "shears"}),
        ("study a { measure p = energy }\nstudy b { expect max(‸", {"max"}, {"p", "force"}),
        ("tissue t { described ‸ }", {"in"}, {"per", "by", "is"}),
        ("language 1\n‸", {"body"}, {"at"}),
    ],
)
def test_what_cannot_stand_somewhere_is_not_offered(text, can, cannot):
    found = {one.label for one in complete(*asked(HEAD + text))}
    assert can <= found
    assert not cannot & found


def test_sets_that_hold_each_other_are_offered():
    text = HEAD + "set a = [b]\nset b = [a]\nscript { at 0 s: fix ‸ }"
    assert {"a", "b"} <= {one.label for one in complete(*asked(text))}


def test_a_line_above_that_is_wrong_hides_nothing():
    text = HEAD + "set = = (\nscript { at 0 s: fix ‸ }"
    assert "some" in {one.label for one in complete(*asked(text))}


def tokens_of(beginning):
    return tree_of(Source("text", beginning)).statements[0].sentence


@pytest.mark.parametrize(
    ("beginning", "some", "others"),
    [
        ("", {"WORD", "PARAM", "AT"}, {"THEN", "LANGUAGE"}),
        ("at 0 s: grasp a ", {"WITH"}, {"THEN", "SET"}),
        ("let a = 3", {"PLUS"}, {"WORD"}),
        ("let a = (1, 2, 3", {"RPAR_UNIT"}, {"WORD"}),
        ("set a = nodes # a remark", {"OF"}, {"THEN"}),
    ],
)
def test_the_grammar_says_what_can_follow(beginning, some, others):
    accepted = accepted_behind(tokens_of(beginning))
    assert some <= accepted
    assert not others & accepted


def test_what_follows_a_mistake_is_not_known():
    assert accepted_behind(tokens_of("let let")) is None
    assert accepted_behind([], is_heading=True) == {"LANGUAGE"}
