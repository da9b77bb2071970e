"""Colours agree with the compiler, with the grammar for editors, and bear any text."""

import json
import random
from itertools import pairwise

from docs.reference.pages import outdated_grammars
from tests.every import every
from tests.lsp.editor_documents import BAD, GOOD, LIBRARY
from tests.lsp.textmate import Engine
from tissuec.core.units import SYMBOLS
from tissuec.lang.words import RESERVED
from tissuec.lsp.highlighting import grammar
from tissuec.lsp.semantic_tokens import KINDS, tokens
from tissuec.lsp.textmate import SCOPES
from tissuec.lsp.vscode import contents
from tissuec.scene.reading.parts import parts
from tissuec.script.measures import MEASURES
from tissuec.script.verbs import VERBS

SCENE = """language 1
param lift = 6 mm  # how far
tissue fat { hardness is very soft; mass = 4 mg; spring law is toe { strain = 3 % } }
body liver { mesh is tube { rings = 16 }; tissue is fat }
set top = nodes of liver where x > lift and not surface
script { at 0 s: push top with (0, 0, 1) N using smooth profile }
expect count(nodes of liver) == 3 at 0 s
"""


def coloured(text):
    """Return what each word of a text is coloured as; the last one of several counts."""
    return {text[start:stop]: kind for start, stop, kind in tokens(text)}


def test_words_have_the_colour_of_what_they_are_there_for():
    found = coloured(SCENE)
    expected = {
        "language": "keyword", "6": "number", "mm": "unit", "# how far": "comment",
        "body": "part", "hardness": "entry", "very": "word", "soft": "word", "mesh": "entry",
        "tube": "word", "rings": "entry", "fat": "name", "x": "measure", "surface": "measure",
        "lift": "name", "push": "verb", "smooth": "word", "profile": "word", "count": "measure",
        "mg": "unit", "strain": "entry", ">": "sign", "%": "unit",
    }  # fmt: skip
    assert {word: found[word] for word in expected} == expected


@every("path", [*LIBRARY, *GOOD])
def test_every_sign_of_a_text_has_one_colour(path):
    text = path.read_text(encoding="utf-8")
    found = tokens(text)
    assert all(one[1] <= other[0] for one, other in pairwise(found))
    assert {kind for _, _, kind in found} <= set(KINDS)
    rest = list(text)
    for start, stop, _ in found:
        rest[start:stop] = " " * (stop - start)
    assert not "".join(rest).strip()


def test_any_text_can_be_coloured():
    chance = random.Random(3)
    for path in BAD[::7]:
        text = path.read_bytes().decode("utf-8", errors="replace")
        for _ in range(3):
            start = chance.randrange(len(text) + 1)
            tokens(text[:start] + chance.choice('{}()";#\r\n😀') + text[start + 3 :])


def test_the_grammar_for_editors_colours_alike():
    """The grammar knows single lines only, so that a few words of one scene differ."""
    engine, kinds = Engine(grammar()), {scope: kind for kind, scope in SCOPES.items()}
    differ: list[str] = []
    for path in (*LIBRARY, *GOOD):
        text = path.read_text(encoding="utf-8")
        shown: dict[int, str] = {}
        for start, stop, scope in engine.tokens(text):
            shown |= dict.fromkeys(range(start, stop), kinds[scope])
        differ += (
            f"{path.stem}: {text[start:stop]}"
            for start, stop, kind in tokens(text)
            if {shown.get(place) for place in range(start, stop)} != {kind}
        )
    assert sorted(differ) == ["layout: nodes", "layout: x", "layout: y", "layout: z"]


def test_the_files_for_editors_are_up_to_date():
    stale = [str(path) for path in outdated_grammars()]
    assert not stale, f"run python -m docs.reference: {stale} are out of date"


def test_the_files_for_editors_are_json_and_name_files_that_are_there(repository):
    documents = {path: json.loads(text) for path, text in contents().items()}
    package = documents["package.json"]["contributes"]
    folder = repository / "grammars" / "vscode"
    (language,), (rules,) = package["languages"], package["grammars"]
    for path in (language["configuration"], rules["path"], documents["package.json"]["main"]):
        assert (folder / path).is_file()
    assert documents[rules["path"].removeprefix("./")]["scopeName"] == rules["scopeName"]


def test_the_grammar_knows_all_words_of_the_tables():
    text = json.dumps(grammar())
    for word in (*RESERVED, *parts(), *VERBS, *MEASURES, *SYMBOLS):
        assert json.dumps(word)[1:-1].replace(" ", "\\\\s+") in text or word == "%"
