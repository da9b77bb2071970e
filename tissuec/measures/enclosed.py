"""What measures of volumes share: the surface of a body."""

from functools import lru_cache

from tissuec.core.source import Source, Span
from tissuec.enclosures import Enclosure
from tissuec.measures import Subject
from tissuec.measures.moment import Moment
from tissuec.network import Network

_NOWHERE = Span(Source("", ""), 0, 0)


def surface_of(subject: Subject, moment: Moment) -> Enclosure | None:
    """Return what the surface of a body encloses, None where it is open."""
    situation = moment.situation
    return situation.enclosure(subject.name) or _closed(situation.network, subject.name)


@lru_cache(maxsize=16)
def _closed(network: Network, name: str) -> Enclosure | None:
    try:
        return Enclosure.of(network, name, 1.0, _NOWHERE)
    except ValueError:
        return None
