"""The progress line of a study: runs, failures, time left."""

import time as clock

from tissuec.core.progress import ProgressLine, minutes
from tissuec.scene.study.model import called


class StudyProgress(ProgressLine):
    """The line of a study; see `ProgressLine`."""

    def __init__(self, name: str, *, shown: bool, anywhere: bool = False):
        super().__init__(called(name), shown=shown, anywhere=anywhere)
        self.first: tuple[float, int] | None = None

    def at(self, done: int, failed: int, planned: int) -> None:
        """Show how far the study is, if it is time to.

        Args:
            done: Runs with a row.
            failed: Those of them that failed.
            planned: Runs of the whole study.
        """
        if self.first is None:
            self.first = clock.monotonic(), done
        self.show(lambda now: self._text(now, done, failed, planned))

    def _text(self, now: float, done: int, failed: int, planned: int) -> str:
        assert self.first is not None
        began, before = self.first
        bad = f", {failed} failed" if failed else ""
        each = (now - began) / (done - before) if done > before else 0.0
        left = f", {minutes(each * (planned - done))} left" if each else ""
        return f"{self.name}: {done} of {planned} runs{bad}{left}"
