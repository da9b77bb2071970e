"""The player."""

from tissuec.report.markup import Html, element
from tissuec.report.sections import Section
from tissuec.report.story import Story


def section(story: Story) -> Section:
    """Return the motion, to be played."""
    return Section("motion", "Motion", _body(story))


def _body(story: Story) -> Html:
    trajectory = story.trajectory
    if not len(trajectory.times) or not len(trajectory.nodes):
        return element("p", "The run recorded no trajectory, so that there is nothing to play.")
    try:
        from tissuec.player.page import fragment
    except ImportError:
        return element("p", "player pending")
    return Html(fragment(trajectory))
