"""The prediction of a run, as parts of a report."""

from math import isfinite

from tissuec.compiler.prediction import Prediction
from tissuec.core.errors import shown_size
from tissuec.core.report import FactSection, FactTable
from tissuec.core.units import TIME, show


def plan_sections(plan: Prediction) -> list[FactSection]:
    """Return the arrays, the method, the parts that are skipped, and the cost."""
    rows = [
        (name, " x ".join(map(str, array["shape"])), shown_size(array["bytes"]))
        for name, array in plan.arrays.items()
    ]
    table = FactTable(("array", "shape", "size"), rows, "Arrays of the net", (12, 16))
    title = "cost"
    if isfinite(plan.steps):
        title = "cost, with steps at this limit (a tolerance can need smaller steps)"
    return [
        FactSection("arrays", [table]),
        FactSection(f"method: {plan.method}", _method(plan)),
        FactSection("skipped", plan.skipped or ["nothing"]),
        FactSection(title, cost(plan)),
    ]


def _method(plan: Prediction) -> list[str]:
    """Return why the method was chosen, and what bounds its steps."""
    facts = plan.facts
    limited = isfinite(facts["limit"])
    limit = f"up to {show(facts['limit'], TIME)}" if limited else "any size"
    return [
        f"reason: {plan.reason}",
        *plan.choices,
        f"fastest motion {facts['omega']:.4g} rad/s, damping ratio {facts['zeta']:.3g}",
        f"stable steps: {limit}",
    ]


def cost(plan: Prediction) -> list[str]:
    """Return the number of steps, their time, and the size of the file."""
    file = f"result file of {'at most' if plan.compress else 'about'} {shown_size(plan.bytes)}"
    if not isfinite(plan.steps):
        each = show(plan.step_seconds, TIME, digits=2)
        return [
            f"as many steps as the tolerance needs, each of about {each}",
            "no estimate of the computing time",
            file,
        ]
    return [
        f"about {plan.steps:.3g} steps, {plan.evaluations:.3g} force evaluations",
        f"about {show(plan.seconds, TIME, digits=2)} of computing time, without compilation",
        file,
    ]
