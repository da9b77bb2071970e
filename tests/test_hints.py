"""Hints lead out of a mistake: each edit that one proposes is made, and each list is tried.

An edit makes its finding go away, and leaves fewer errors, or as many and fewer warnings.
"""

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from functools import cache
from itertools import pairwise

from tests.every import every
from tests.magnitudes import keeps_magnitudes
from tests.test_scenes import BAD, request_of
from tissuec.core.errors import CompileError, Diagnostic
from tissuec.core.hints import Edit
from tissuec.core.structs import replace
from tissuec.lang.characters import normalise
from tissuec.lang.parser import parse
from tissuec.lang.words import JOINING_WORDS, TIME_WORDS
from tissuec.lsp.documents import OpenDocuments
from tissuec.pipeline import check_request
from tissuec.scene.request import Request

BY_NAME = {path.stem: path for path in BAD}

#: Findings about numbers that cannot stay as large as they are.
OUT_OF_RANGE = ("TIS308", "TIS309", "TIS310")
#: Texts that a hint proposes as they stand.
PROPOSAL = re.compile(r'(?:did you mean|^write|: write|^type) "?(?!\w+ … |…)([^"…]+)"')
#: What stands for something in a form.
PLACEHOLDERS = {
    "NAME": "a", "SET": "a", "BODY": "a", "TOOL": "a", "THREAD": "a", "NOZZLE": "a",
    "JOINT": "a", "JOINTS": "a", "FORCEPS": "a",
    "POINT": "(0, 0, 0) mm", "VECTOR": "(0, 0, 1) mm",
    "FORCE": "1 N", "NUMBER": "1", "LENGTH": "1 mm", "ANGLE": "1 deg", "PROFILE": "ramp",
    "PRESSURE": "1 Pa", "VOLUME": "1 ml", "KNOT": "knot", "T": "1 s", "A": "a", "B": "b",
    "…": "1",
}  # fmt: skip
FORM = re.compile(
    r"(?:for example|write|declare one|declare it): ([^:\"-][^:]*?(?:: [^:]+?)?)"
    r"(?=$|, and then|, with tool|, or write)"
)
LISTED = re.compile(
    r"(?:^|\?  )(choices|kinds|meshes|profiles after using|knots|spring laws): ([^;]+)"
)


@cache
def found(name: str) -> tuple[Diagnostic, ...]:
    """Return what is said about a bad scene."""
    try:
        return said(request_of(BY_NAME[name]))
    except CompileError as error:  # it is no text
        return error.diagnostics


def said(request: Request) -> tuple[Diagnostic, ...]:
    try:
        return check_request(request)[1]
    except CompileError as error:
        return error.diagnostics


@cache
def edited(name: str, edits: tuple[Edit, ...]) -> tuple[Diagnostic, ...]:
    """Return what is said about a bad scene after edits, which do not overlap."""
    request, documents = request_of(BY_NAME[name]), OpenDocuments()
    texts = {request.source: request.source.text}
    for edit in sorted(edits, key=lambda edit: edit.span.start, reverse=True):
        source = edit.span.source
        known = next((one for one in texts if one.name == source.name), source)
        text = texts.get(known, source.text)
        texts[known] = text[: edit.span.start] + edit.text + text[edit.span.end :]
    overrides = list(request.overrides)
    for source, text in texts.items():
        if source.name == "--set":
            overrides[overrides.index(source.text)] = text
        elif source.name == request.source.name:
            request = replace(request, source=replace(source, text=text))
        else:
            documents.put(source.path, text)
    return said(replace(request, overrides=tuple(overrides), files=documents))


def weight(findings: Sequence[Diagnostic]) -> tuple[int, int]:
    errors = sum(finding.severity == "error" for finding in findings)
    return errors, len(findings) - errors


def kinds(findings: Iterable[Diagnostic]) -> Counter:
    return Counter((finding.code, finding.message) for finding in findings)


@every("name", BY_NAME, parts=4)
def test_hints_lead_out_of_a_mistake(name):
    findings = found(name)
    for finding in findings:
        for edit in finding.edits:
            goes_away(finding, edit, name)
        assert finding.edits or not PROPOSAL.search(finding.hint), "a text is no edit"
        for form in FORM.findall(finding.hint):
            can_be_read(form)
        if LISTED.search(finding.hint):
            can_be_chosen(finding, name)
    if findings and all(finding.edits for finding in findings):
        leave_no_error(findings, name)


def goes_away(finding: Diagnostic, edit: Edit, name: str) -> None:
    """Make sure that an edit removes its finding, and leaves less to do."""
    before, after = found(name), edited(name, (edit,))
    told = f"{finding}\n\n{edit.text!r} leads to\n\n" + "\n".join(map(str, after))
    kind = finding.code, finding.message
    assert kinds(after)[kind] < kinds(before)[kind], told
    assert weight(after) < weight(before), told
    is_of_size = finding.severity == "warning" or finding.code in OUT_OF_RANGE
    assert is_of_size or keeps_magnitudes(edit), told


def leave_no_error(findings: Sequence[Diagnostic], name: str) -> None:
    """Make sure that the first edits of all findings together leave no error."""
    edits = tuple(finding.edits[0] for finding in findings)
    places = sorted((edit.span.start, edit.span.end) for edit in edits)
    apart = all(one[1] <= two[0] and one != two for one, two in pairwise(places))
    after = edited(name, edits) if apart else ()
    assert weight(after)[0] == 0, "\n".join(map(str, after))


def can_be_read(form: str) -> None:
    """Make sure that a form that a hint shows is part of the language."""
    for text in re.split(r" or: | or (?=data|hold)|, or with gentle.*|, and no more", form):
        if text:
            parse(normalise(f"language 1\n{filled(text)}\n", "form.tis"))


def filled(form: str) -> str:
    """Return a form with something in place of what it leaves open."""
    form = re.sub(r"\{ … \}", "{ }", form.replace("; … }", " }"))
    form = re.sub(r"\b[A-Z]+\b(?!\")", lambda word: PLACEHOLDERS.get(word[0], word[0]), form)
    form = re.sub(r"(?<= = )…", "1", form).replace("… mm", "1 mm").replace("…", "a")
    if form.startswith("where "):
        return f"region a {form} {{ }}"
    if ": " in form:  # a sentence of a script
        return form
    return f"a {form}" if form.split(" ")[0] in (*JOINING_WORDS, *[*TIME_WORDS][1:]) else form


def can_be_chosen(finding: Diagnostic, name: str) -> None:
    """Make sure that no choice of a list is refused for what it is, but for what it needs."""
    listed = LISTED.search(finding.hint)
    wrong = re.findall(r'"([^"]+)"', finding.message)[-1:]
    if listed is None or not wrong or wrong[0] not in finding.span.text:
        return
    codes = ("TIS305", "TIS306") if "using" in listed[1] else ("TIS305",)
    for choice in re.sub(", or .*", "", listed[2]).split(", "):
        edit = Edit(choice, old=wrong[0]).at(finding.span)
        end = edit.span.start + len(choice)
        refused = [
            one
            for one in edited(name, (edit,))
            if one.code in codes and one.span.start < end <= one.span.end
        ]
        assert not refused, (choice, *refused)
