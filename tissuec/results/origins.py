"""Where the numbers of a network come from: places in the texts that a result file keeps."""

from collections.abc import Mapping

import numpy as np

from tissuec.core.source import Source, Span
from tissuec.model.network import Origin, Provenance
from tissuec.results import access
from tissuec.results.access import Contents, ResultGroup
from tissuec.results.schema import ORIGINS, ORIGINS_OF
from tissuec.results.store import Store


def write_origins(store: Store, provenance: Mapping[str, Provenance]) -> None:
    """Write the origins of all arrays as one table, and which of them each entry has."""
    every = tuple(dict.fromkeys(o for one in provenance.values() for o in one.origins))
    if not every:
        return
    rows = {origin: row for row, origin in enumerate(every)}
    store.arrays(
        ORIGINS,
        text=[origin.span.source.name for origin in every],
        how=[origin.how for origin in every],
        span=[(origin.span.start, origin.span.end) for origin in every],
    )
    for name, one in provenance.items():
        row = np.array([rows[origin] for origin in one.origins], dtype=np.int32)
        store.array(ORIGINS_OF["{array}"].of(array=name), row[one.index])


def read_origins(file: ResultGroup, texts: Mapping[str, Source]) -> dict[str, Provenance]:
    """Return the origins of each array by its name; nothing from files without them.

    Args:
        texts: The scene and what it uses, by name.
    """
    if ORIGINS.path not in file:
        return {}
    origins = tuple(
        Origin(Span(texts.get(text) or Source(text, ""), *span), how)
        for text, how, span in Contents(file, ORIGINS).rows("text", "how", "span")
    )
    of = access.group(file, ORIGINS_OF.path)
    return {str(name): Provenance(access.array(of, str(name)), origins) for name in of}
