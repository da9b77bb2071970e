"""Processor time of commands in processes of their own."""

import os
import subprocess
import sys
from pathlib import Path


def seconds_of_run(
    scene: Path, result: Path, environment: dict[str, str] | None = None
) -> float:
    """Return the processor time of ``tissuec run`` without the companion run [s].

    Args:
        scene: The scene.
        result: Where the result goes.
        environment: Variables of the process besides those of this one.
    """
    words = ("run", str(scene), "--companion", "off", "-o", str(result))
    before = os.times()
    subprocess.run(
        [sys.executable, "-m", "tissuec", *words], capture_output=True, check=False,
        env=os.environ | (environment or {}),
    )  # fmt: skip
    after = os.times()
    user, system = after.children_user, after.children_system
    return user - before.children_user + system - before.children_system
