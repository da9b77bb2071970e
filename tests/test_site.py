"""The documentation builds as a site, and its page on data names every file of data."""

import re
import subprocess
import sys
from fnmatch import fnmatch
from pathlib import Path

import pytest

SUFFIXES = {".csv", ".obj", ".stl", ".png", ".gif"}


def test_the_site_builds_without_warnings(repository, tmp_path):
    pytest.importorskip("material", reason="needs the extra docs")
    command = ["mkdocs", "build", "--strict", "--site-dir", str(tmp_path)]
    run = subprocess.run(
        [sys.executable, "-m", *command], cwd=repository, capture_output=True, text=True
    )
    assert run.returncode == 0, run.stderr
    front = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert re.search(r"tissuec \d+\.\d+\.\d+", front)
    docs = repository / "docs"
    pages = {page.relative_to(docs).with_suffix("") for page in docs.rglob("*.md")}
    pages |= {Path("index"), Path("changes")}
    built = {path.parent.relative_to(tmp_path) for path in tmp_path.rglob("index.html")}
    assert built == {page.parent if page.name == "index" else page for page in pages}
    text = (tmp_path / "tutorial" / "index.html").read_text(encoding="utf-8")
    assert '<span class="kd">tissue</span>' in text, "scenes have no colours"
    atlas = (tmp_path / "atlas.html").read_text(encoding="utf-8")
    assert all(f'id="{one}"' in atlas for one in ("liver", "skin", "tendon"))
    laboratory = (tmp_path / "laboratory" / "index.html").read_text(encoding="utf-8")
    assert 'href="../atlas.html"' in laboratory


def test_the_page_on_data_names_every_file(repository):
    text = (repository / "docs" / "data.md").read_text(encoding="utf-8")
    rows = [line.split("|")[1] for line in text.splitlines() if line.startswith("| `")]
    patterns = [pattern for row in rows for pattern in re.findall("`([^`]+)`", row)]
    files = [
        path.relative_to(repository).as_posix()
        for folder in ("library", "docs", "tests")
        for path in (repository / folder).rglob("*")
        if path.suffix in SUFFIXES
    ]
    assert not [name for name in files if not any(fnmatch(name, one) for one in patterns)]
    assert not [one for one in patterns if not any(fnmatch(name, one) for name in files)]
