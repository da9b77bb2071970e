"""The plan of the run and what it skipped, as in ``tissuec explain --plan``."""

from tissuec.core.report import FactSection
from tissuec.view.report.content import ReportContent
from tissuec.view.report.markup import Section, element, html, shown
from tissuec.view.summaries.plan import plan_sections


def section(content: ReportContent) -> Section:
    """Return the plan; that in the file where the scene cannot be compiled."""
    plan = content.prediction
    if plan is not None:
        return Section("plan", "Plan", shown(plan_sections(plan)))
    text = "Arrays and cost are unknown, because the scene could not be compiled again."
    skipped = content.manifest.get("plan", {}).get("skipped") or ["nothing"]
    parts = (element("p", text), shown([FactSection("skipped", skipped)]))
    return Section("plan", "Plan", html(parts))
