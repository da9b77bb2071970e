"""Processes that tests start need not compile what others have compiled before."""

import subprocess
import sys
from pathlib import Path


def test_processes_keep_bytecode(tmp_path):
    (tmp_path / "imported.py").write_text("", encoding="utf-8")
    code = "import imported; print(imported.__cached__)"
    run = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert Path(run.stdout.strip()).is_file()
