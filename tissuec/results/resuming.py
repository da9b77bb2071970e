"""Going on with an interrupted run: where it stopped, if it was one of the very same scene."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from tissuec.model.network import Network
from tissuec.results import PlaceError, ResultError
from tissuec.results.checkpoint import Checkpoint, scene_digest
from tissuec.results.places import partial_path
from tissuec.results.trajectory import Trajectory


def find_checkpoint(
    path: Path, text: str, manifest: Mapping[str, Any], network: Network
) -> Checkpoint:
    """Return the last checkpoint of the unfinished result at ``path``.

    Args:
        path: The partial file, or the final name.
        text: The scene as it is to be gone on with.
        manifest: What the result would say of its origin if it began now.
        network: What the scene is compiled to now.

    Raises:
        PlaceError: There is no such file, it was run from another text or ``--set``, or its
            checkpoint is of another version of tissuec, or not as it was written.
    """
    partial = partial_path(path)
    if not partial.exists():
        raise PlaceError(f'there is no interrupted run "{partial}" to resume')
    try:
        with Trajectory.open(partial) as begun:
            changes, checkpoint = list(_changes(begun, text, manifest)), begun.checkpoint()
    except ResultError as error:
        raise PlaceError(f"{error}; without --resume the run starts again") from error
    if checkpoint is None:
        changes = ["it has no checkpoint"]
    elif not changes and checkpoint.scene != scene_digest(text, network):
        changes = ["the scene compiles to another network"]
    if checkpoint is None or changes:
        raise PlaceError(
            f'cannot resume "{partial}": {", and ".join(changes)}; without --resume the '
            "run starts again"
        )
    return checkpoint


def _changes(begun: Trajectory, text: str, manifest: Mapping[str, Any]) -> Iterator[str]:
    """Yield the changes since a run began."""
    if begun.text != text:
        yield f'"{manifest["scene"]}" has changed since'
    for kind in ("sources", "files"):
        then, now = begun.manifest.get(kind, {}), manifest.get(kind, {})
        for name in {**then, **now}:
            if then.get(name) != now.get(name):
                yield f'"{name}" has changed since'
    former = begun.manifest.get("overrides", [])
    if former != manifest["overrides"]:
        options = " ".join(f'--set "{override}"' for override in former)
        yield f"it was run with {options or 'no --set'}"
