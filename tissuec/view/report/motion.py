"""The player, and for paper the net at some moments."""

from tissuec.view.player.options import Options
from tissuec.view.player.page import fragment
from tissuec.view.report import pictures
from tissuec.view.report.content import ReportContent
from tissuec.view.report.head import capital
from tissuec.view.report.markup import Content, Html, Section, element, html

#: What the player brings along: positions of all frames, and nodes of one.
MOST_POSITIONS, MOST_NODES = 400_000, 20_000
FEWEST_FRAMES = 20


def section(content: ReportContent) -> Section:
    """Return the motion, to be played."""
    return Section("motion", "Motion", html(_body(content)))


def _body(content: ReportContent) -> Content:
    frames, nodes = len(content.trajectory.times), len(content.trajectory.nodes)
    if not frames or not nodes:
        return element("p", "The run recorded no trajectory, so there is no motion to play.")
    options, less = chosen(frames, nodes)
    label = f"the motion of {content.title}"
    still = None if pictures.lacking() else pictures.for_paper(content, "frames", label)
    caption = f"{capital(label)}." + (f" Shown are {less}." if less else "")
    played = Html(fragment(content.trajectory, options))
    return element("figure", played, still, element("figcaption", caption))


def chosen(frames: int, nodes: int) -> tuple[Options, str]:
    """Return the parts of a run that fit on a page of some megabytes, and what is left out."""
    shown = min(nodes, MOST_NODES)
    most = max(MOST_POSITIONS // shown, FEWEST_FRAMES)
    left = [
        f"{few} of {many} {what}"
        for few, many, what in ((most, frames, "frames"), (shown, nodes, "nodes"))
        if few < many
    ]
    options = Options(
        frames=most if most < frames else None, nodes=shown if shown < nodes else None
    )
    return options, " and ".join(left)
