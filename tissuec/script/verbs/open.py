"""``open``: jaws that move apart."""

from typing import ClassVar

from tissuec.script.verbs import VERBS
from tissuec.script.verbs.jaws import JawMotion


@VERBS.member("open")
class Open(JawMotion, frozen=True):
    """Opens the jaws of forceps by a length; each jaw moves by half of it.

    The forceps must not be moved as a whole at the same time. Tissue between the jaws is held
    only by friction, and slips when the pull exceeds it. The forces on the jaws are contact
    forces.
    """

    apart: ClassVar[bool] = True
