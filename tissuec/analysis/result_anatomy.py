"""The anatomy of the scene of a result: tissues, and matter that has strain and stress."""

from tissuec.analysis.result_scene import recompile
from tissuec.compiler.anatomy import anatomy_of
from tissuec.results.blocks.anatomy import Anatomy
from tissuec.results.trajectory import Trajectory


def anatomy_of_result(trajectory: Trajectory) -> tuple[Anatomy | None, str]:
    """Return the anatomy of a result, or None and the reason why it is unknown."""
    scene = recompile(trajectory)
    if scene.compiled is not None:
        return anatomy_of(scene.compiled), ""
    return None, "; ".join(doubt.text for doubt in scene.doubts)
