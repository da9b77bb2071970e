"""The plan of the run and what it skipped, as in ``tissuec explain --plan``."""

from tissuec.compiler.prediction import Prediction
from tissuec.view.report.content import ReportContent
from tissuec.view.report.head import capital
from tissuec.view.report.markup import Html, Section, element, html, listing, row, table
from tissuec.view.summaries import plan as wording


def section(content: ReportContent) -> Section:
    """Return the plan; that in the file where the scene cannot be compiled."""
    plan = content.prediction
    if plan is not None:
        return Section("plan", "Plan", _plan(plan))
    text = "Arrays and cost are unknown, because the scene could not be compiled again."
    skipped = content.manifest.get("plan", {}).get("skipped", [])
    return Section("plan", "Plan", html((element("p", text), _skipped(skipped))))


def _plan(plan: Prediction) -> Html:
    arrays = table(
        "Arrays of the net", ("array", "shape", "size"), [row(*a) for a in wording.arrays(plan)]
    )
    return html(
        (
            element("h3", f"Method: {plan.method}"),
            listing(wording.method(plan)),
            _skipped(plan.skipped),
            element("h3", capital(wording.cost_title(plan))),
            listing(wording.cost(plan)),
            element("h3", "Arrays"),
            arrays,
        )
    )


def _skipped(skipped: "list[str] | tuple[str, ...]") -> Html:
    nothing = element("p", "Nothing was skipped.")
    return html((element("h3", "Skipped"), listing(skipped) if skipped else nothing))
