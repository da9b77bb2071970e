"""The player, and for paper the net at some moments."""

from tissuec.player.options import Options
from tissuec.player.page import fragment
from tissuec.report import pictures
from tissuec.report.markup import Content, Html, element, html
from tissuec.report.sections import Section
from tissuec.report.story import Story

#: Positions that the player brings along; a longer run is shown in fewer frames.
MOST_POSITIONS = 400_000
FEWEST_FRAMES = 20


def section(story: Story) -> Section:
    """Return the motion, to be played."""
    return Section("motion", "Motion", html(_body(story)))


def _body(story: Story) -> Content:
    trajectory = story.trajectory
    frames, nodes = len(trajectory.times), len(trajectory.nodes)
    if not frames or not nodes:
        return element("p", "The run recorded no trajectory, so that there is nothing to play.")
    most = max(MOST_POSITIONS // nodes, FEWEST_FRAMES)
    options = Options(frames=most) if frames > most else Options()
    less = (
        f"Every so many of its {frames} frames are shown, {most} in all."
        if frames > most
        else ""
    )
    paper = (
        None
        if pictures.lacking()
        else pictures.for_paper(story, "frames", f"net of {story.title}")
    )
    return (
        Html(fragment(trajectory, options)),
        element("p", less, class_="remark") if less else None,
        paper,
    )
