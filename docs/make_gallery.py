"""Make the pictures of ``gallery.md`` by the commands that stand under them there.

    python docs/make_gallery.py [NAME …]

needs matplotlib (``pip install "tissuec[plot]"``) and Pillow, and takes some minutes. The
commands are carried out in a folder of their own; the last one of each block draws. With names,
only these pictures are made anew. "> FILE" behind a command keeps what it prints.
"""

import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from PIL import Image

DOCS = Path(__file__).resolve().parent
ROOT = DOCS.parent
PAGE, PICTURES = DOCS / "gallery.md", DOCS / "figures" / "gallery"
ENTRY = re.compile(
    r"\(figures/gallery/(?P<name>\w+)\.png\).*?^```sh\n(?P<text>.*?)^```$", re.M | re.S
)
SCENE = re.compile(r"^```tis (?P<name>\S+)\n(?P<text>.*?)^```$", re.M | re.S)
COLOURS = 128  # of a picture, as many as its palette holds
DPI = "110"


def main(names: list[str]) -> None:
    """Make pictures, and say how large all of them are."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "tube.tis").write_bytes(
            (ROOT / "benchmarks" / "nets" / "tube.tis").read_bytes()
        )
        page = PAGE.read_text(encoding="utf-8")
        for scene in SCENE.finditer(page):
            (Path(folder) / scene["name"]).write_text(scene["text"], encoding="utf-8")
        done: set[str] = set()
        for name, commands in entries(page):
            if not names or name in names:
                make(name, commands, Path(folder), done)
    total = sum(path.stat().st_size for path in PICTURES.glob("*.png"))
    print(f"{PICTURES}: {total / 1e3:.0f} kB")


def entries(page: str) -> Iterator[tuple[str, list[str]]]:
    """Yield the name of each picture of the page and the commands under it."""
    for found in ENTRY.finditer(page):
        yield found["name"], found["text"].replace("\\\n", "").splitlines()


def make(name: str, commands: list[str], folder: Path, done: set[str]) -> None:
    """Carry out commands, those that were not yet, and keep the picture of the last one."""
    *before, last = commands
    for command in before:
        if command not in done:
            run(command, folder)
            done.add(command)
    run(f"{last} -o {name}.png --dpi {DPI}", folder)
    # A palette of few colours is a third of the size, and nobody sees it.
    picture = Image.open(folder / f"{name}.png").convert("RGB")
    method, dither = Image.Quantize.MAXCOVERAGE, Image.Dither.NONE
    target = PICTURES / f"{name}.png"
    picture.quantize(COLOURS, method=method, dither=dither).save(target, optimize=True)
    print(f"{name}: {target.stat().st_size / 1e3:.0f} kB")


def run(command: str, folder: Path) -> None:
    """Carry out a command line; what is wrong with it ends this program."""
    line, _, target = command.partition(">") if " > " in command else (command, "", "")
    program, *words = shlex.split(line)
    if program == "tissuec":
        words = ["-m", "tissuec", "-q", *words]
    known = os.environ | {"PYTHONPATH": str(ROOT)}
    said = subprocess.run(
        [sys.executable, *words], cwd=folder, env=known, stdout=subprocess.PIPE
    )
    # A stress test ends with 1 where something is silently wrong, which its map shows.
    if said.returncode and not (target and said.stdout):
        raise SystemExit(f"{command}: exit code {said.returncode}")
    if target:
        (folder / target.strip()).write_bytes(said.stdout)


if __name__ == "__main__":
    main(sys.argv[1:])
