"""The progress line of a learning."""

from tissuec.core.errors import counted
from tissuec.core.progress import ProgressLine, minutes
from tissuec.learn.fit.learning import LearnProgress


class Passes(ProgressLine):
    """The line of a learning: passes, the part of the data in use, errors, time left.

    Until it ends, a learning writes nothing that can be read, so files get lines, too.
    """

    def __init__(self, name: str, *, shown: bool):
        super().__init__(name, shown=shown, logged=True)

    def at(self, progress: LearnProgress) -> None:
        """Show the state of a learning, if it is time to."""
        self.show(lambda _: f"{self.name}: {self._text(progress)}")

    def _text(self, at: LearnProgress) -> str:
        if at.fits is not None:
            return f"{counted(at.fits, 'fit')} to simulated data, {at.seconds:.0f} s"
        parts = [f"pass {at.passes} of at most {at.most}"]
        if at.horizon < 1.0:
            parts.append(f"first {100 * at.horizon:.0f} % of the data")
        if at.first > 0.0:
            parts.append(f"error {at.error / at.first:.2e} of the first")
        if at.held_out is not None:
            parts.append(f"held out {100 * at.held_out:.3g} %")
        parts.append(f"{at.seconds:.0f} s")
        if at.passes > 0:
            left = (at.most - at.passes) * at.seconds / at.passes
            parts.append(f"at most {minutes(left)} left")
        return ", ".join(parts)
