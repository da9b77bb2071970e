"""Where the numbers of a network come from: places in the texts that a result file keeps."""

from collections.abc import Mapping

import numpy as np

from tissuec.core.source import Source, Span
from tissuec.model.network import Origin, Provenance
from tissuec.results import access
from tissuec.results.access import ResultGroup
from tissuec.results.store import Store

ORIGINS = "/tissuec/network/origins"
_TABLE = {
    "text": "name of the text of each origin",
    "how": "how the value is given: written, rules, table, …",
}


def write_origins(store: Store, provenance: Mapping[str, Provenance]) -> None:
    """Write the origins of all arrays as one table, and which of them each entry has."""
    every = tuple(dict.fromkeys(o for one in provenance.values() for o in one.origins))
    if not every:
        return
    rows = {origin: row for row, origin in enumerate(every)}
    columns = {
        "text": [origin.span.source.name for origin in every],
        "how": [origin.how for origin in every],
    }
    for name, texts in columns.items():
        store.texts(f"{ORIGINS}/{name}", texts, _TABLE[name])
    spans = np.array([(origin.span.start, origin.span.end) for origin in every])
    store.array(f"{ORIGINS}/span", spans, "its first character and the one after its last")
    for name, one in provenance.items():
        row = np.array([rows[origin] for origin in one.origins], dtype=np.int32)
        text = f"row of the origin of each entry of {name}"
        store.array(f"{ORIGINS}/of/{name}", row[one.index], text, compress=True)


def read_origins(file: ResultGroup, texts: Mapping[str, Source]) -> dict[str, Provenance]:
    """Return the origins of each array by its name; nothing from files without them.

    Args:
        texts: The scene and what it uses, by name.
    """
    if ORIGINS not in file:
        return {}
    group = access.group(file, ORIGINS)
    columns = access.texts(group, "text"), access.texts(group, "how")
    spans = access.array(group, "span").tolist()
    origins = tuple(
        Origin(Span(texts.get(text) or Source(text, ""), *span), how)
        for text, how, span in zip(*columns, spans, strict=True)
    )
    of = access.group(group, "of")
    return {str(name): Provenance(access.array(of, str(name)), origins) for name in of}
