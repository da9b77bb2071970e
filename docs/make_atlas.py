"""Make the atlas: one page about all shipped tissues, as they are measured in the laboratory.

    python -m docs.make_atlas [FILE]

takes three to five minutes of processor time, shared by all cores. The build of the site makes
it automatically, and keeps it in ``build/`` until one of its source files changes.
"""

import sys
from concurrent.futures import ProcessPoolExecutor
from hashlib import sha256
from pathlib import Path

import tissuec
from tissuec.core.files import write_file
from tissuec.core.resources import library
from tissuec.view.report.atlas import render

ROOT = Path(__file__).resolve().parent.parent
TITLE = "Atlas of tissues"
#: Sources of the page.
_PARTS = ("library/matter", "library/fuzzy", "tissuec/analysis/lab", "tissuec/view/atlas")


def page() -> str:
    """Return the page, which is rebuilt only if a source changed."""
    digest = sha256()
    for part in _PARTS:
        for path in sorted((ROOT / part).glob("*.*")):
            digest.update(path.read_bytes())
    kept = ROOT / "build" / f"atlas-{digest.hexdigest()[:16]}.html"
    if not kept.exists():
        files = sorted((library() / "matter").glob("*.tis"))
        with ProcessPoolExecutor() as pool:
            found = [one for several in pool.map(tissuec.examine, files) for one in several]
        kept.parent.mkdir(exist_ok=True)
        write_file(kept, render(found, TITLE))
    return kept.read_text(encoding="utf-8")


if __name__ == "__main__":
    target = Path(sys.argv[1] if len(sys.argv) > 1 else "atlas.html")
    write_file(target, page())
    print(target)
