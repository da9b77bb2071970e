"""Hooks of MkDocs: version in the title, coloured scenes, pages from files beside ``docs/``.

Pages link to files of the repository as GitHub shows them. On the site, the README and the
changelog are pages, and other files are names without a link.
"""

import os
import re
from pathlib import Path
from typing import Any

import colours  # MkDocs searches the folder of this file for modules
import make_atlas
from mkdocs.structure.files import File, Files

from tissuec import __version__

DOCS = Path(__file__).resolve().parent
ROOT = DOCS.parent
#: Files beside ``docs/`` that are pages, and their names on the site.
BESIDE = {"README.md": "index.md", "CHANGELOG.md": "changes.md"}
ATLAS = "atlas.html"  # a name in texts, and on the site a link
_ATLAS = re.compile(rf"the atlas\s`{re.escape(ATLAS)}`")
#: The language of a code block and what tests read behind it, such as the name of a file.
_FENCE = re.compile(r"^( *```)(\w+)( .*)?$", re.MULTILINE)
#: Scenes with mistakes are scenes, too.
_LANGUAGES = {"wrong": "tis"}
_LINK = re.compile(
    r"(?P<image>!?)\[(?P<text>[^\]]*)\]\((?P<path>[\w./-]+)(?P<anchor>#[^)]*)?\)"
)


def on_config(config: Any) -> Any:
    """Show the version in the title of the site, and let code blocks be scenes."""
    colours.register()
    config.site_name = f"{config.site_name} {__version__}"
    return config


def on_files(files: Files, config: Any) -> Files:
    """Add the pages that are made of files beside ``docs/``, and the atlas of tissues."""
    for path, name in BESIDE.items():
        text = (ROOT / path).read_text(encoding="utf-8")
        files.append(File.generated(config, name, content=text))
    files.append(File.generated(config, ATLAS, content=make_atlas.page()))
    return files


def on_page_markdown(markdown: str, page: Any, **context: Any) -> str:
    """Rewrite links between pages and other files, and code blocks with names of files."""
    at = DOCS / page.file.src_uri
    folder = ROOT if page.file.src_uri in BESIDE.values() else at.parent
    linked = _LINK.sub(lambda found: _on_site(found, folder, at.parent), markdown)
    atlas = Path(os.path.relpath(DOCS / ATLAS, at.parent)).as_posix()
    linked = _ATLAS.sub(f"the [atlas]({atlas})", linked)
    return _FENCE.sub(lambda found: found[1] + _LANGUAGES.get(found[2], found[2]), linked)


def _on_site(found: re.Match[str], folder: Path, below: Path) -> str:
    """Return a link as it is on the site, or its text alone if it leads to no page.

    Args:
        found: The link.
        folder: Where its path begins in the repository.
        below: Where it begins on the site.
    """
    target = (folder / found["path"]).resolve()
    if not target.exists():
        return found[0]  # which MkDocs reports
    if target.is_relative_to(DOCS):
        name = Path(os.path.relpath(target, below)).as_posix()
    elif target.parent == ROOT and target.name in BESIDE:
        name = Path(os.path.relpath(DOCS / BESIDE[target.name], below)).as_posix()
    else:
        return found["text"]
    return f"{found['image']}[{found['text']}]({name}{found['anchor'] or ''})"
