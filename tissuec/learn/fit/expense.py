"""What a fit by finite differences takes, told before it begins."""

from typing import NamedTuple

import numpy as np

from tissuec.compiler.prediction import predict
from tissuec.core.progress import minutes
from tissuec.core.structs import replace
from tissuec.learn.derivatives.finite_differences import FiniteDifferenceModel
from tissuec.learn.fit.session import LearnSession

#: Runs of an experiment for each parameter and one more: 19 were measured for one parameter.
#: Further starts and fits to simulated data come on top.
RUNS = 10
MANY, LONG = 100, 60.0  # runs, and their time [s], from which on they are announced


class Expense(NamedTuple):
    """What a fit takes, roughly.

    Attributes:
        runs: How many whole runs, or series of equilibria, it makes for finite differences.
        seconds: Processor time of these [s]; NaN where only the tolerance decides how long a
            run takes.
    """

    runs: int
    seconds: float

    @property
    def announcement(self) -> str:
        """Return the announcement of a long fit; "" for a short one."""
        if self.runs < MANY and not self.seconds > LONG:
            return ""
        text = f"derivatives are finite differences, which take about {self.runs} runs"
        if np.isnan(self.seconds):
            return text
        return f"{text}, {minutes(self.seconds)} of processor time"


def expense_of(session: LearnSession) -> Expense:
    """Return the runs and the time of a fit; no runs where all derivatives are exact."""
    each = RUNS * (session.shaping.size + 1)
    runs, seconds = 0, 0.0
    for trial in session.learning:
        if isinstance(trial.model, FiniteDifferenceModel):
            runs += each
            seconds += each * _seconds(trial.model)
    return Expense(runs, seconds)


def _seconds(model: FiniteDifferenceModel) -> float:
    """Return the predicted time of a run [s]."""
    found = predict(replace(model.shaping.compiled, plan=model.plan))
    if not model.is_still:
        return found.cost.solving
    # Each row is an equilibrium, in addition to those on the way there.
    many = found.static.equilibria
    return found.cost.solving * (many + len(model.times)) / many
