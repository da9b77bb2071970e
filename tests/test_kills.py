"""Whenever a run is ended, its file opens, and going on gives what an undisturbed run gives."""

import json
import os
import subprocess
import sys

import pytest

from tissuec.core.resources import library

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="processes as on POSIX")
#: A sheet that is drawn out and shaken, cut, and torn, with every kind of output.
SHEET = """language 1
tissue skin {
  spring constant = 40 N/m; viscosity = 5 mN*s/m; mass = 0.2 g; breaking force = 55 mN
}
body sheet {
  mesh is sheet { corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm; second edge = (0, 20, 0) mm
                  columns = 5; rows = 5; diagonals is both }
  tissue is skin
}
set left = nodes of sheet where x < 1 mm
set right = nodes of sheet where x > 19 mm
environment { gravity = (0, 0, -9.81) m/s^2; damping = 1 mN*s/m }
script {
  at 0 s: { fix left; hold right }
  from 0.02 s to 0.3 s: move right by (9, 0, 0) mm using smooth profile
  when speed(sheet) > 0.05 m/s: push sheet with (0, 0, 5) mN
  at 0.3 s: cut sheet along line from (12, -1, 0) mm to (12, 9, 0) mm facing (1, 0, 0)
}
simulate { duration = DURATION }
output {
  trajectory every 4 ms; force of right every 1 ms; energy every 10 ms
  surface of sheet every 20 ms
}
expect count(springs of sheet) > 1 over run
"""


def tormented(scene, kills, seed):
    command = [sys.executable, "-m", "tests.kills", str(scene), f"--kills={kills}"]
    run = subprocess.run([*command, f"--seed={seed}"], capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr
    return json.loads(run.stdout)


def test_a_run_that_is_killed_at_any_moment_is_gone_on_with_bit_for_bit(tmp_path):
    scene = tmp_path / "sheet.tis"
    scene.write_text(SHEET.replace("DURATION", "0.4 s"))
    told = tormented(scene, 3, seed=3)
    assert sum(told["kills"].values()) == 3
    assert told["resumed"] >= 1 and told["finished"] >= 1


SCENES = sorted(one.stem for one in (library() / "scenes").glob("*.tis"))


@pytest.mark.slow
@pytest.mark.parametrize("stem", SCENES)
def test_every_shipped_scene_is_gone_on_with_bit_for_bit(stem):
    """Killed three times, also as it ends; the last run that is killed leaves a checkpoint."""
    told = tormented(library() / "scenes" / f"{stem}.tis", 3, seed=11)
    assert sum(told["kills"].values()) == 3
    assert told["resumed"] >= 1 and told["finished"] >= 1


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_a_run_that_is_killed_hundreds_of_times_is_gone_on_with_bit_for_bit(
    tmp_path, repository, seed
):
    """500 kills, of the sheet and of scenes of the library."""
    scene = tmp_path / "sheet.tis"
    scene.write_text(SHEET.replace("DURATION", "1 s"))
    shipped = repository / "library" / "scenes"
    scene = [scene, scene, shipped / "hanging_net.tis", shipped / "two_masses.tis"][seed]
    told = tormented(scene, 125, seed)
    assert sum(told["kills"].values()) == 125
    assert told["resumed"] > 20
