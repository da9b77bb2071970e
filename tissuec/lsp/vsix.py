"""The VS Code extension as one file: a zip with two manifests beside the folder.

The layout is that of the Open Packaging Conventions, as ``vsce`` writes it and as
``code --install-extension`` reads it.
"""

import json
from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Any
from xml.sax.saxutils import escape, quoteattr
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from tissuec.core.resources import grammar
from tissuec.lsp.vscode import contents

#: Files of the folder that are not generated from tables; the first starts the server.
_WRITTEN = ("client.js", "client.licences.txt", "README.md")
_TYPES = {
    ".json": "application/json", ".js": "application/javascript", ".md": "text/markdown",
    ".txt": "text/plain", ".vsixmanifest": "text/xml",
}  # fmt: skip
#: The earliest date of a zip: equal contents make equal files.
_DATE = (1980, 1, 1, 0, 0, 0)


def files() -> dict[str, bytes]:
    """Return the files of the extension by their paths in its folder."""
    folder = grammar("vscode")
    found = {path: text.encode() for path, text in contents().items()}
    return found | {name: (folder / name).read_bytes() for name in _WRITTEN}


def write_vsix(target: Path) -> None:
    """Write the extension as one file.

    Raises:
        OSError: The file cannot be written, or one of the extension cannot be read.
    """
    found = files()
    parts = {f"extension/{path}": content for path, content in found.items()}
    package = json.loads(found["package.json"])
    with ZipFile(target, "w", ZIP_DEFLATED) as archive:
        for path, content in {
            "[Content_Types].xml": _content_types(parts).encode(),
            "extension.vsixmanifest": _manifest(package).encode(),
            **parts,
        }.items():
            archive.writestr(ZipInfo(path, _DATE), content, ZIP_DEFLATED)


def _content_types(parts: Mapping[str, bytes]) -> str:
    """Return the type of each ending, and of files that have none."""
    endings = {PurePosixPath(path).suffix for path in parts} | {".vsixmanifest"}
    lines = [
        f"<Default Extension={quoteattr(end)} ContentType={quoteattr(_type_of(end))}/>"
        for end in sorted(endings - {""})
    ]
    lines += [
        f"<Override PartName={quoteattr(f'/{path}')} ContentType={quoteattr(_type_of(''))}/>"
        for path in sorted(parts)
        if not PurePosixPath(path).suffix
    ]
    types = "http://schemas.openxmlformats.org/package/2006/content-types"
    return _document(f'<Types xmlns="{types}">', lines, "</Types>")


def _type_of(ending: str) -> str:
    return _TYPES.get(ending, "application/octet-stream")


def _manifest(package: Mapping[str, Any]) -> str:
    """Return the manifest for an installer: name, version, engine, paths of the contents."""
    schema = "http://schemas.microsoft.com/developer/vsx-schema/2011"
    code = "Microsoft.VisualStudio.Code"
    said = {"Id": "name", "Version": "version", "Publisher": "publisher"}
    identity = " ".join(f"{name}={quoteattr(package[key])}" for name, key in said.items())
    lines = [
        "<Metadata>",
        f'<Identity Language="en-US" {identity}/>',
        f"<DisplayName>{escape(package['displayName'])}</DisplayName>",
        f'<Description xml:space="preserve">{escape(package["description"])}</Description>',
        f"<Categories>{escape(','.join(package['categories']))}</Categories>",
        "<Properties>",
        f'<Property Id="{code}.Engine" Value={quoteattr(package["engines"]["vscode"])}/>',
        "</Properties>",
        "</Metadata>",
        f'<Installation><InstallationTarget Id="{code}"/></Installation>',
        "<Dependencies/>",
        "<Assets>",
        f'<Asset Type="{code}.Manifest" Path="extension/package.json" Addressable="true"/>',
        '<Asset Type="Microsoft.VisualStudio.Services.Content.Details" '
        'Path="extension/README.md" Addressable="true"/>',
        "</Assets>",
    ]
    return _document(
        f'<PackageManifest Version="2.0.0" xmlns="{schema}">', lines, "</PackageManifest>"
    )


def _document(opening: str, lines: list[str], closing: str) -> str:
    return "\n".join(['<?xml version="1.0" encoding="utf-8"?>', opening, *lines, closing, ""])
