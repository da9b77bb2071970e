"""Expectations, measured values, and whether they hold."""

from collections.abc import Mapping

from tissuec.core.units import TIME, show
from tissuec.results.recording import ExpectationResult
from tissuec.view.report.content import ReportContent
from tissuec.view.report.markup import Content, Html, element, html, row, table
from tissuec.view.report.sections import Section
from tissuec.view.report.verdict import SIGNS, Tone

TONES: Mapping[str, Tone] = {
    "holds": "good", "fails": "bad", "not reached": "open", "not recorded": "open",
}  # fmt: skip


def section(story: ReportContent) -> Section | None:
    """Return the table of expectations; None of a scene without any."""
    if not story.expectations:
        return None
    heads = ("verdict", "expectation", "measured", "at", "line")
    rows = [_row(story, one) for one in story.expectations]
    body = table("Expectations and measured values", heads, rows, "expectations")
    return Section("expectations", "Expectations", html((_lead(story), body)))


def _lead(story: ReportContent) -> Html | None:
    if story.count("not recorded"):
        return element("p", "The result does not record which of them hold.")
    if story.count("holds") and any(one.time is not None for one in story.expectations):
        text = "For an expectation that holds over an interval, the last measurement is shown."
        return element("p", text, class_="remark")
    return None


def _row(story: ReportContent, one: ExpectationResult) -> Html:
    time: Content = "–" if one.time is None else show(one.time, TIME, digits=6)
    return row(
        mark(TONES[one.state], one.state),
        element("code", one.expect.removeprefix("expect ")),
        element("code", one.measured) if one.measured else "–",
        element("span", time, class_="number-cell"),
        story.texts.link(one.place),
    )


def mark(tone: Tone, word: str) -> Html:
    """Return a word with the sign that goes with it."""
    sign = element("span", SIGNS[tone], aria_hidden="true")
    return element("span", sign, " ", word, class_=f"mark {tone}")
