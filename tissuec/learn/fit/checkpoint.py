"""Checkpoints of a search between passes, so that an interrupted learning can be resumed."""

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from msgspec.structs import asdict

from tissuec.core.files import replacing
from tissuec.learn.fit.search import SearchState
from tissuec.learn.fit.session import LearnSession
from tissuec.results.manifest import versions
from tissuec.scene.request import Request


def key_of(session: LearnSession, request: Request, texts: Sequence[str]) -> str:
    """Return a digest of everything the result depends on: texts, settings, data, versions.

    Args:
        session: The learning.
        texts: All texts of the scene.
    """
    digest = hashlib.sha256()
    trials = (*session.learning, *session.held_out)
    parts = (
        *texts,
        *request.overrides,
        session.fit_problem.name,
        *(trial.experiment.digest for trial in trials),
        *(f"{name} {version}" for name, version in sorted(versions().items())),
    )
    for part in parts:
        digest.update(part.encode() + b"\0")
    return digest.hexdigest()


def keep(path: Path, key: str, state: SearchState) -> None:
    """Write the state of a search; the file is complete at any moment.

    Args:
        path: The file.
        key: Digest of ``key_of``.
        state: The state of the search.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as beside, beside.open("wb") as file:
        np.savez(file, key=key, **asdict(state))


def kept(path: Path, key: str) -> SearchState | None:
    """Return where a search of the same learning stood; None without one."""
    try:
        with np.load(path, allow_pickle=False) as file:
            if str(file["key"]) != key:
                return None
            return SearchState(
                **{name: _value(file[name]) for name in SearchState.__struct_fields__}
            )
    except (OSError, ValueError, KeyError, EOFError, BadZipFile):
        return None


def _value(array: np.ndarray) -> Any:
    """Return a plain value as such, and not as an array without axes."""
    return array if array.ndim else array.item()
