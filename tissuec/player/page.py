"""A result as one HTML document that plays it, without a network or other files."""

import html

from tissuec.player.options import DEFAULT, Options
from tissuec.results.trajectory import Trajectory


def render(trajectory: Trajectory, options: Options = DEFAULT) -> str:
    """Return the whole HTML document."""
    return f"<!doctype html><title>{html.escape(trajectory.path.name)}</title>"


def fragment(
    trajectory: Trajectory,
    options: Options = DEFAULT,
    *,
    height: int = 640,
) -> str:
    """Return the player as an element to be put into another page.

    It stands in a frame of its own, so that neither page meets the other's styles or keys.

    Args:
        height: Of the frame [px].
    """
    name = html.escape(trajectory.path.name)
    document = html.escape(render(trajectory, options))
    style = f"width:100%;height:{height}px;border:0"
    return f'<iframe title="player of {name}" style="{style}" srcdoc="{document}"></iframe>'
