"""A key in a long text costs what that key changes, not what the text is long."""

import time

import pytest

from tissuec.core.keeping import Memory
from tissuec.lang.grammar import StatementParser
from tissuec.lsp import findings, navigation
from tissuec.lsp.completion import complete
from tissuec.lsp.documents import OpenDocuments
from tissuec.lsp.hover import hover
from tissuec.lsp.semantic_tokens import tokens_of
from tissuec.lsp.views import view_of

PART = """
# Net {k} of many.
param force{k} = {more} mN  # of its spring
tissue gum{k} {{
  about "Tissue {k}"
  described in soft tissue
  hardness is soft
  elasticity is big
  weight is medium
  spring constant = {more} N/m
}}
body net{k} {{
  mesh is tube {{
    axis from ({k}, 0, 0) mm to ({k}.6, 0, 0) mm
    radius = 3 mm
    rings = 3
    sides = 4
    diagonals is both
  }}
  tissue is gum{k}
}}
set left{k} = nodes of net{k} where x < {k}.1 mm
set right{k} = nodes of net{k} where x > {k}.5 mm
"""
END = """
environment { gravity = (0, 0, 0) m/s^2; damping = 1 mN*s/m }
simulate { duration = 0.1 s }
output { trajectory every 10 ms }
"""


def scene(bodies: int) -> str:
    """Return a text of 28 lines for each body."""
    parts = "".join(PART.format(k=k, more=k + 1) for k in range(bodies))
    script = "".join(
        f"  at 0 s: fix left{k}\n"
        f"  from 0 s to 50 ms: pull right{k} with force{k} along (1, 0, 0)\n"
        for k in range(bodies)
    )
    return f'language 1\nuse "fuzzy/soft_tissue"\n{parts}script {{\n{script}}}\n{END}'


@pytest.fixture
def documents(tmp_path):
    """Return open texts, the path of a long one, its text, and a place in its middle."""
    documents, path, text = OpenDocuments(), tmp_path / "long.tis", scene(12)
    documents.put(path, text)
    findings.check(documents, path)
    return documents, path, text, text.index("radius = 3", len(text) // 2)


def test_a_key_lets_one_statement_be_parsed(documents, monkeypatch):
    opened, path, text, place = documents
    parsed: list[str] = []
    parse = StatementParser.parse

    def counted(self, statement, rule="statement"):
        parsed.append(" ".join(token.text for token in statement))
        return parse(self, statement, rule)

    monkeypatch.setattr(StatementParser, "parse", counted)
    opened.put(path, text[:place] + "\n\n" + text[place:].replace("3 mm", "4 mm", 1))
    found = findings.check(opened, path)
    assert found.compiled is not None
    assert parsed == ["radius = 4 mm"]


def test_bodies_that_did_not_change_are_not_counted_again(tmp_path, monkeypatch):
    text = scene(12)
    documents, path = OpenDocuments(), tmp_path / "long.tis"
    documents.memory = Memory(8)  # fewer than there are bodies, as in a long text
    documents.put(path, text)
    findings.check(documents, path)
    counted: list[int] = []
    monkeypatch.setattr(findings, "floppy_modes", lambda *arrays: counted.append(1))
    documents.put(path, text.replace("0.1 s", "0.2 s"))
    assert findings.check(documents, path, thorough=False).is_thorough
    assert not counted


def test_findings_of_names_come_before_nets_are_drawn(documents):
    opened, path, text, _ = documents
    opened.put(path, text.replace("hardness is soft", "hardness is sft", 1))
    told: list[list[str]] = []

    def resolved(found):
        told.append([one.code for one in found.errors])

    with_error = findings.check(opened, path, resolved=resolved)
    assert told == [[one.code for one in with_error.diagnostics if one.severity == "error"]]
    assert told == [["TIS201"]]

    class OutdatedError(Exception):
        pass

    def give_up(_):
        raise OutdatedError

    opened.put(path, text)
    with pytest.raises(OutdatedError):
        findings.check(opened, path, resolved=give_up)


@pytest.mark.slow
def test_five_thousand_lines_are_answered_within_half_a_second(tmp_path):
    text = scene(180)
    assert text.count("\n") > 4500
    documents, path, known = OpenDocuments(), tmp_path / "long.tis", Memory(50_000)
    place = text.index("radius = 3", len(text) // 2)
    costs: list[float] = []
    for key in range(4):
        documents.put(path, text[:place] + " " * key + text[place:])
        start = time.process_time()
        view = view_of(documents, path)
        hover(view, place + key + 2)
        complete(view, place + key + 2)
        navigation.outline(view.structure)
        tokens_of(view.structure, known)
        costs.append(time.process_time() - start)
        findings.check(documents, path, thorough=False)
    # All answers together, on a computer that others use, too.
    assert min(costs[1:]) < 0.5
