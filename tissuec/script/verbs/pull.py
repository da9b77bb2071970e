"""``pull``: the same as ``push``, for sentences that read better with it."""

from typing import ClassVar

from tissuec.script.verbs import VERBS
from tissuec.script.verbs.push import Push


@VERBS.member("pull")
class Pull(Push, frozen=True):
    """Applies an external force to nodes, exactly as ``push`` does."""

    meant: ClassVar[str] = ""
