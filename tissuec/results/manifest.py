"""The origin of a result: scene, versions, method, outcome, and places of its numbers."""

import json
import platform
import sys
from collections.abc import Mapping
from datetime import UTC, datetime
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from tissuec.core.data import as_data
from tissuec.core.plugins import plugins
from tissuec.core.source import Source, Span
from tissuec.core.version import __version__
from tissuec.model.network import Origin, Provenance
from tissuec.results import access
from tissuec.results.access import Contents, ResultGroup
from tissuec.results.schema import MANIFEST, ORIGINS, ORIGINS_OF
from tissuec.results.store import Store

PACKAGES = ("numpy", "scipy", "llvmlite", "h5py")
RUNNING = "unfinished: the run is still in progress or was killed"
_LONGEST_ATTRIBUTE = (
    8192  # HDF5 keeps attributes of at most 64 kB; longer ones stand in the text
)


def first_manifest(given: Mapping[str, object], scene_text: str) -> dict[str, object]:
    """Return the manifest of a run at its start: given and known facts."""
    known = {
        "digest": sha256(scene_text.encode()).hexdigest(),
        "versions": versions(),
        "begun": datetime.now(UTC).isoformat(timespec="seconds"),
        "outcome": RUNNING,
        "finished": False,
        "wall_time": 0.0,
    }
    return {**as_data(given), **known}


@cache
def versions() -> Mapping[str, str]:
    """Return the versions of Python, plug-ins and the packages that matter, without imports."""
    found = {"tissuec": __version__, "python": platform.python_version()}
    found |= {name: _version(name) for name in PACKAGES}
    return found | {one.package: one.version for one in plugins()}


def _version(package: str) -> str:
    """Return the version of a package, mostly by the name of the folder that tells it."""
    for folder in sys.path:
        for told in Path(folder or ".").glob(f"{package}-*.dist-info"):
            return told.stem.partition("-")[2]
    from importlib.metadata import PackageNotFoundError, version  # imports 30 modules

    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def write_manifest(store: Store, manifest: Mapping[str, object]) -> None:
    """Write the manifest as JSON, and its entries as attributes for plain HDF5 tools."""
    entries: dict[str, Any] = as_data(manifest)
    text = json.dumps(entries, ensure_ascii=False, indent=1)
    store.array(MANIFEST[""], text)
    attributes: dict[str, Any] = {}
    for name, value in {**entries, **entries.get("versions", {})}.items():
        if name in ("unit", "description", "versions"):
            continue
        plain = isinstance(value, str | int | float | bool)
        entry = value if plain else json.dumps(value, ensure_ascii=False)
        if len(str(entry).encode()) <= _LONGEST_ATTRIBUTE:
            attributes[name.replace("\0", "")] = entry
    store.label(MANIFEST.path, **attributes)


def read_manifest(file: ResultGroup) -> dict[str, Any]:
    """Return the manifest of ``file``."""
    return access.json(file, MANIFEST.path)


def credits(manifest: Mapping[str, Any]) -> str:
    """Return who wrote a scene, where, and under which licence; empty if it does not say."""
    licence = manifest.get("licence")
    parts = (
        manifest.get("author"),
        manifest.get("laboratory"),
        f"licence: {licence}" if licence else "",
    )
    return " · ".join(filter(None, parts))


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
