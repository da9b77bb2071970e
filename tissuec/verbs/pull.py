"""``pull``: the same as ``push``, for sentences that read better with it."""

from dataclasses import dataclass
from typing import ClassVar

from tissuec.verbs import VERBS
from tissuec.verbs.push import Push


@VERBS.member("pull")
@dataclass(frozen=True, slots=True)
class Pull(Push):
    """Lets an external force act on nodes, exactly as ``push`` does."""

    forms: ClassVar[tuple[str, ...]] = tuple(
        form.replace("push", "pull", 1) for form in Push.forms
    )
