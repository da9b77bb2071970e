"""Several parameters in one ``adjust``: how they are joined in the language.

``adjust = [stiffness, damping]`` lists entries of the tissue or force of the block; what has an
owner or limits takes a sentence of its own.
"""

import re

from tissuec.core.errors import Diagnostic
from tissuec.core.hints import Edit, Hint
from tissuec.core.source import Span
from tissuec.lang.mistake import Mistake

_WORDS = r"[^\W\d][\w']*(?: [^\W\d][\w']*)*"
_PART = re.compile(rf"(?P<entry>{_WORDS}?)(?P<owner> of {_WORDS})?")
_ADJUST = re.compile(
    r"adjust ?(?:= ?)?(?P<parts>.+?)(?P<limits> (?:from|to|around|by|per|along|between) .*)?"
)
_JOINT = re.compile(r"\s*(?:,|;|\band\b)\s*")
_LONGEST = 2000


def adjusted_list(m: Mistake) -> Diagnostic | None:
    """Recognise ``adjust a and b``, ``adjust [a, b]`` and ``adjust a of x, b of x``."""
    tokens = [*m.before, m.found, *m.after]
    start, stop = tokens[0].start, max(m.statement.stop, tokens[0].stop)
    text = m.source.text[start:stop].rstrip()
    if len(text) > _LONGEST or "\n" in text:
        return None
    found = _ADJUST.fullmatch(text)
    if found is None:
        return None
    listed = re.sub(r"[\[\]]", "", found["parts"]).strip()
    parts = [_PART.fullmatch(part) for part in _JOINT.split(listed)]
    if len(parts) < 2 or not all(parts):
        return None
    read = [(part["entry"], part["owner"] or "") for part in parts if part is not None]
    limits = found["limits"] or ""
    owner = read[-1][1]
    if not owner and not limits and not any(one for _, one in read):
        written = f"adjust = [{', '.join(entry for entry, _ in read)}]"
    else:
        written = "; ".join(f"adjust {entry}{one or owner}{limits}" for entry, one in read)
    place = Span(m.source, start, start + len(text))
    message = "several parameters are a list, or have a sentence each"
    return Diagnostic("TIS312", message, place, Hint(f"write: {written}", Edit(written, place)))
