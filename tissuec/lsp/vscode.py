"""The VS Code extension: its generated files, and all of it as one file.

The layout of that file is that of the Open Packaging Conventions, as ``vsce`` writes it and as
``code --install-extension`` reads it.
"""

import json
from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Any
from xml.sax.saxutils import escape, quoteattr
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from tissuec.core import resources
from tissuec.core.version import __version__
from tissuec.lsp.highlighting import grammar
from tissuec.lsp.textmate import SCOPE, SCOPES
from tissuec.scene.program.library import SUFFIX

_GRAMMAR = "syntaxes/tissuec.tmLanguage.json"
_CONFIGURATION = "language-configuration.json"
#: What the server calls units and words, for themes that know no such tokens.
_TOKENS = {"type": "unit", "enumMember": "word", "property": "entry", "method": "measure"}


def contents() -> dict[str, str]:
    """Return the generated files of the folder by their paths in it."""
    documents = {
        "package.json": _package(),
        _CONFIGURATION: _configuration(),
        _GRAMMAR: grammar(),
    }
    return {
        path: json.dumps(document, indent=2, ensure_ascii=False) + "\n"
        for path, document in documents.items()
    }


def _package() -> dict[str, Any]:
    return {
        "name": "tissuec",
        "displayName": "tissuec",
        "description": "Soft-tissue scenes: highlighting and a language server",
        "version": _version(),
        "publisher": "tissuec",
        "license": "MIT",
        "categories": ["Programming Languages"],
        "engines": {"vscode": "^1.82.0"},
        "main": "./client.js",
        "devDependencies": {"esbuild": "0.28.2", "vscode-languageclient": "9.0.1"},
        "contributes": {
            "languages": [
                {
                    "id": "tissuec",
                    "aliases": ["tissuec", "tissue scene"],
                    "extensions": [SUFFIX],
                    "firstLine": r"^language\s+[0-9]",
                    "configuration": f"./{_CONFIGURATION}",
                }
            ],
            "grammars": [{"language": "tissuec", "scopeName": SCOPE, "path": f"./{_GRAMMAR}"}],
            "semanticTokenScopes": [
                {
                    "language": "tissuec",
                    "scopes": {token: [SCOPES[kind]] for token, kind in _TOKENS.items()},
                }
            ],
            "configuration": {
                "title": "tissuec",
                "properties": {
                    "tissuec.command": {
                        "type": "string",
                        "default": "tissuec",
                        "description": "The program that runs tissuec lsp.",
                    },
                    "tissuec.libraries": {
                        "type": "array",
                        "items": {"type": "string"},
                        "default": [],
                        "description": "Folders to search for used files.",
                    },
                },
            },
            "configurationDefaults": {
                "[tissuec]": {"editor.tabSize": 2, "editor.insertSpaces": True}
            },
        },
    }


def _version() -> str:
    """Return the version as npm wants it: three numbers."""
    numbers = [part for part in __version__.split(".") if part.isdigit()][:3]
    return ".".join([*numbers, "0", "0"][:3])


def _configuration() -> dict[str, Any]:
    pairs = [["{", "}"], ["[", "]"], ["(", ")"]]
    quotes = {"open": '"', "close": '"', "notIn": ["string", "comment"]}
    return {
        "comments": {"lineComment": "#"},
        "brackets": pairs,
        "autoClosingPairs": [*({"open": one, "close": other} for one, other in pairs), quotes],
        "surroundingPairs": [*pairs, ['"', '"']],
        "indentationRules": {
            "increaseIndentPattern": r"^[^#\"]*\{[^}\"]*$",
            "decreaseIndentPattern": r"^\s*\}",
        },
    }


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
    folder = resources.grammar("vscode")
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
