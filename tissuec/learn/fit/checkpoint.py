"""Checkpoints of a search between passes, so that an interrupted learning can be resumed."""

import hashlib
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import Any, Self

import numpy as np
from msgspec.structs import asdict

from tissuec.core.files import OutputFile, final_place
from tissuec.learn.fit.search import SearchState
from tissuec.learn.fit.session import LearnSession
from tissuec.results.errors import PlaceError
from tissuec.results.manifest import versions
from tissuec.scene.request import Request

_MARK = b"PK\x03\x04"  # of files that numpy.savez writes


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


class KeptSearch:
    """The file with the state of a search, which no other learning writes meanwhile.

    Args:
        path: The file.
        key: Digest of ``key_of``.

    Attributes:
        before: The stored state of a search of the same learning; None without one.
        note: Why it is None although there is a state, as a sentence; else empty.

    Raises:
        PlaceError: Another learning writes the file, it is not a state, or cannot be written.
    """

    def __init__(self, path: Path, key: str):
        self._key, self.before, self.note = key, None, ""
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file = OutputFile(final_place(path), "append")
        except BlockingIOError as error:
            raise PlaceError(
                f'cannot write "{path}": another learning is writing it; wait for its end, or '
                "give another preset with -o"
            ) from error
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            raise PlaceError(f'cannot write "{path}": {reason}') from error
        content = self._file.readall()
        if content and not content.startswith(_MARK):
            self._file.close()
            raise PlaceError(
                f'cannot write "{path}": it exists and is not the state of a learning; remove '
                "it, or give another preset with -o"
            )
        if content:
            self._read(content, path)

    def _read(self, content: bytes, path: Path) -> None:
        try:
            with np.load(BytesIO(content), allow_pickle=False) as file:
                if str(file["key"]) == self._key:
                    names = SearchState.__struct_fields__
                    self.before = SearchState(**{name: _value(file[name]) for name in names})
        except Exception:  # damaged files raise what they like
            self.note = f'"{path}" is damaged, so learning has begun again'

    def keep(self, state: SearchState) -> None:
        """Write the state of the search; the file is complete at any moment.

        Raises:
            OSError: It cannot be written.
        """
        content = BytesIO()
        np.savez(content, key=self._key, **asdict(state))
        self._file = self._file.replaced(content.getvalue())

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *failure: object) -> None:
        self._file.release()


def _value(array: np.ndarray) -> Any:
    """Return a plain value as such, and not as an array without axes."""
    return array if array.ndim else array.item()
