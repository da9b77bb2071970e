"""Writes ``grammars/vscode/client.js``: ``extension.js`` and its packages as one file.

The versions of the packages are those of ``package-lock.json``. Only this script requires npm.

    python docs/make_client.py
"""

import json
import shutil
import subprocess
import sys
import tempfile
from hashlib import sha256
from pathlib import Path

FOLDER = Path(__file__).parent.parent / "grammars" / "vscode"
SOURCES = ("extension.js", "package.json", "package-lock.json")
CLIENT, LICENCES = "client.js", "client.licences.txt"
BUNDLE = (
    "--bundle", "--platform=node", "--format=cjs", "--target=node18", "--external:vscode",
    "--minify", "--legal-comments=none",
)  # fmt: skip


def digest() -> str:
    """Return the digest of what the bundle is made of: our own code, and the packages."""
    packages = json.loads((FOLDER / SOURCES[2]).read_text(encoding="utf-8"))["packages"]
    own = packages.pop("")  # with the version of tissuec, which is not in the bundle
    locked = json.dumps([own["devDependencies"], packages], sort_keys=True)
    code = (FOLDER / SOURCES[0]).read_text(encoding="utf-8")
    return sha256("\n".join((code, locked, *BUNDLE)).encode()).hexdigest()


def heading() -> str:
    """Return the first line of the bundle."""
    return f"// Made by docs/make_client.py; sources: sha256 {digest()}\n"


def bundle() -> dict[str, str]:
    """Return the bundle and the licences of the packages in it, by names of files."""
    npm = shutil.which("npm")
    if npm is None:
        sys.exit("npm is missing")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for source in SOURCES:
            shutil.copy(FOLDER / source, folder)
        subprocess.run([npm, "ci", "--silent", "--no-audit"], cwd=folder, check=True)
        command = [npm, "exec", "--", "esbuild", SOURCES[0], *BUNDLE]
        subprocess.run(
            [*command, "--log-level=warning", f"--outfile={CLIENT}", "--metafile=meta.json"],
            cwd=folder,
            check=True,
        )
        code = (folder / CLIENT).read_text(encoding="utf-8")
        return {CLIENT: heading() + code, LICENCES: licences(folder)}


def licences(folder: Path) -> str:
    """Return the licences of the packages whose files are in the bundle."""
    used = json.loads((folder / "meta.json").read_text(encoding="utf-8"))["inputs"]
    names = sorted({path.split("/")[1] for path in used if path.startswith("node_modules/")})
    texts = [f"{CLIENT} contains these packages:\n"]
    for name in names:
        package = folder / "node_modules" / name
        version = json.loads((package / "package.json").read_text(encoding="utf-8"))["version"]
        (licence,) = (path for path in package.iterdir() if path.stem.lower() == "license")
        text = licence.read_text(encoding="utf-8").strip()
        lines = (line.rstrip() for line in text.splitlines())
        texts.append("\n".join([f"{name} {version}", "-" * 70, *lines, ""]))
    return "\n".join(texts)


if __name__ == "__main__":
    for file, text in bundle().items():
        (FOLDER / file).write_text(text, encoding="utf-8", newline="\n")
