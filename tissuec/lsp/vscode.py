"""Files of a VS Code extension that are generated from tables of the compiler."""

import json
from typing import Any

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
