"""Benches of the laboratory for a tissue that is written in a test."""

from tissuec.analysis.lab.bench import TestBench
from tissuec.core.source import Source
from tissuec.pipeline import read_words
from tissuec.scene.request import Request


def text(entries):
    return f"language 1\ntissue gel {{ {entries} }}\n"


def bench(entries, **more):
    """Return the bench of a tissue; options are those of ``TestBench``."""
    request = Request(Source("gel.tis", text(entries)))
    return TestBench(request, read_words(request)[0].tissues["gel"], spacing=2.5e-3, **more)
