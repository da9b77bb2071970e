"""Expectations, measured values, and whether they hold."""

from collections.abc import Mapping

from tissuec.results.recording import ExpectationResult
from tissuec.view.report.content import ReportContent
from tissuec.view.report.markup import Content, Html, Section, element, html, row, table
from tissuec.view.report.verdict import SIGNS, Tone

TONES: Mapping[str, Tone] = {
    "holds": "good", "fails": "bad", "not reached": "open", "not recorded": "open",
}  # fmt: skip


def section(content: ReportContent) -> Section | None:
    """Return the table of expectations; None of a scene without any."""
    if not content.expectations:
        return None
    heads = ("verdict", "expectation", "measured", "at", "line")
    rows = [_row(content, one) for one in content.expectations]
    body = table("Expectations and measured values", heads, rows, "expectations")
    return Section("expectations", "Expectations", html((_lead(content), body)))


def _lead(content: ReportContent) -> Html | None:
    if content.count("not recorded"):
        return element("p", "The result does not record which of them hold.")
    if content.count("holds") and any(one.time is not None for one in content.expectations):
        text = "For an expectation that holds over an interval, the last measurement is shown."
        return element("p", text, class_="remark")
    return None


def _row(content: ReportContent, one: ExpectationResult) -> Html:
    clock = content.trajectory.clock
    time: Content = "–" if one.time is None else clock.text(one.time, digits=6)
    return row(
        mark(TONES[one.state], one.state),
        element("code", one.expect.removeprefix("expect ")),
        element("code", one.measured) if one.measured else "–",
        element("span", time, class_="number-cell"),
        content.texts.link(one.place),
    )


def mark(tone: Tone, word: str) -> Html:
    """Return a word with the sign that goes with it."""
    sign = element("span", SIGNS[tone], aria_hidden="true")
    return element("span", sign, " ", word, class_=f"mark {tone}")
