"""A package of its own adds members, without a line in tissuec: those of docs/extending.md."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.test_docs import DOCS, blocks

#: Groups of entry points by the folder in which the page puts an example.
GROUPS = {
    "tissuec/meshes/generators": "tissuec.mesh",
    "tissuec/meshes/formats": "tissuec.mesh_format",
    "tissuec/script/tools": "tissuec.tool",
    "tissuec/script/verbs": "tissuec.verb",
    "tissuec/script/measures": "tissuec.measure",
    "tissuec/results/fields": "tissuec.frame_field",
    "tissuec/forces/acting": "tissuec.force",
    "tissuec/validate/forces": "tissuec.force_formula",
    "tissuec/laws/spring": "tissuec.spring_law",
    "tissuec/laws/solid": "tissuec.solid_law",
    "tissuec/engine/integrators": "tissuec.integrator",
    "tissuec/geometry/surfaces": "tissuec.surface",
    "tissuec/view/plots": "tissuec.plot",
    "tissuec/scene": "tissuec.block",
}

COMMANDS = "tissuec/cli"  # which are part of the program

#: Corners of triangles, a line for each.
TETRAHEDRON = "0 0 0 0 9 0 9 0 0\n0 0 0 9 0 0 0 0 9\n0 0 0 0 0 9 0 9 0\n9 0 0 0 9 0 0 0 9\n"


def install(folder, name, version, groups):
    """Write the metadata of a package whose modules are in a folder already.

    Args:
        groups: Pairs of a name and a module, by groups of entry points.
    """
    metadata = folder / f"{name.replace('-', '_')}-{version}.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n"
    )
    (metadata / "entry_points.txt").write_text(
        "\n".join(
            f"[{group}]\n" + "".join(f"{name} = {module}\n" for name, module in members)
            for group, members in groups.items()
        )
    )


def break_in(folder):
    """Install a package that says to have a mesh, and that cannot be imported."""
    (folder / "broken.py").write_text("import nowhere\n")
    install(folder, "broken", "0.3", {"tissuec.mesh": [("a", "broken")]})


#: Members with a wrong annotation, and what is said of it.
ANNOTATED = {
    "float": 'the annotation of "radius" in Coil does not say how the entry is written',
    "Annotated[float, Real(LENGTH)] | None": "Annotated[float | None, …]",
    "Annotated[float, 3.0]": "does not say how the entry is written",
    "Lenth": "cannot be evaluated: NameError: name 'Lenth' is not defined",
}
COIL = """from __future__ import annotations

from typing import Annotated

from msgspec import Struct

from tissuec.core.fields import Real
from tissuec.core.units import LENGTH
from tissuec.meshes.generators import MESHES


@MESHES.member("coil")
class Coil(Struct, frozen=True, eq=False):
    turns: Annotated[float, Real(LENGTH)]
    radius: KIND
"""
SPRAIN = """from typing import Annotated

from tissuec.script.forms import VerbSentence
from tissuec.script.parts import Nodes
from tissuec.script.verbs import VERBS


@VERBS.member("sprain")
class Sprain(VerbSentence, frozen=True):
    group: Nodes
    force: Annotated[float, "to"]
"""

#: Verbs whose actions answer what checks ask.
VERBS_MODULE = """
from math import inf
from typing import Annotated, ClassVar

from tissuec.core.units import FORCE
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import ChoiceClause, Nodes, NumberClause, Springs
from tissuec.script.verbs import VERBS, LoggedEvent
from tissuec.script.verbs.holding import Taken, sentence, take

AGENTS = {"heat": "By a hot tool.", "acid": "By a fluid."}


@VERBS.member("weaken")
class Weaken(VerbSentence, frozen=True):
    meant = "corrode"
    group: Springs
    force: Annotated[
        float, NumberClause("to", FORCE, "positive", what="force", example="to 1 N")
    ]
    agent: Annotated[str | None, ChoiceClause("with", AGENTS, what="agent")]

    def breakable(self, network):
        return self.group.indices

    def apply(self, state, queue):
        chosen = self.group.indices
        state.springs = state.springs.changed("strength", chosen, self.force)
        return (LoggedEvent("weaken", (), sentence(self.span), self.span),)


@VERBS.member("clamp")
class Clamp(VerbSentence, frozen=True):
    group: Nodes

    def holding(self):
        return Taken(self.group.name, self.group.indices)

    def apply(self, state, queue):
        take(state, self.group.name, self.group.indices)
        return (LoggedEvent("clamp", (), sentence(self.span), self.span),)


@VERBS.member("throw")
class Throw(VerbSentence, frozen=True):
    shift: ClassVar[float] = inf
    group: Nodes

    def apply(self, state, queue):
        state.velocity[self.group.indices] = 20.0
        return (LoggedEvent("throw", (), sentence(self.span), self.span),)
"""
PAIR = """language 1
tissue cord { spring constant = 100 N/m; viscosity = 0.5 N*s/m; mass = 1 g }
body pair { mesh is explicit; tissue is cord }
table nodes of pair in mm with columns "id x" { 1 0; 2 20 }
table springs of pair with columns "a b" { 1 2 }
set wall = nodes of pair where id == 1
set end = nodes of pair where id == 2
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 20 ms }
"""


@pytest.fixture(scope="module")
def clinic(tmp_path_factory):
    """Return a folder in which a package of verbs is installed."""
    folder = tmp_path_factory.mktemp("clinic")
    (folder / "clinic_verbs.py").write_text(VERBS_MODULE, encoding="utf-8")
    members = [(word, "clinic_verbs") for word in ("weaken", "clamp", "throw")]
    install(folder, "clinic-verbs", "0.1", {"tissuec.verb": members})
    return folder


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Return a folder in which a package is installed that has the examples of the page."""
    folder = tmp_path_factory.mktemp("site")
    package, groups = folder / "tissue_extras", {}
    for block in blocks(DOCS / "extending.md"):
        home = Path(block.name or "")
        if block.kind == "python" and block.name and home.parent.as_posix() != COMMANDS:
            name = "_".join(home.parts[1:-1])
            (package / name).mkdir(parents=True, exist_ok=True)
            (package / name / home.name).write_text(block.text, encoding="utf-8")
            module = f"tissue_extras.{name}.{home.stem}"
            groups.setdefault(GROUPS[home.parent.as_posix()], []).append((home.stem, module))
    install(folder, "tissue-extras", "2.5", groups)
    return folder


def call(folder, site, *words, code=0):
    """Run tissuec in a folder, with the packages of a site; return what it prints."""
    return call_python(folder, site, None, *words, code=code)


def call_python(folder, site, program, *words, code=0):
    """Run a program, or tissuec, in a folder with the packages of a site."""
    environment = {
        **os.environ,
        "PYTHONPATH": f"{site}{os.pathsep}{os.environ.get('PYTHONPATH', '')}",
    }
    done = subprocess.run(
        [sys.executable, *(["-c", program] if program else ["-m", "tissuec"]), *words],
        cwd=folder, env=environment, capture_output=True, text=True, encoding="utf-8",
    )  # fmt: skip
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout + done.stderr


def scenes():
    """Return the scenes of the page that use an example, by their names."""
    named = {b.name: b.text for b in blocks(DOCS / "extending.md") if b.kind == "tis"}
    return {
        name: text for name, text in named.items() if name != "cyst.tis" and "/" not in name
    }


#: Carries out a command for each of several files, in one process.
ONE_AFTER_ANOTHER = """
import sys
from tissuec.cli import main
command, *files = sys.argv[1:]
for file in files:
    sys.argv = ["tissuec", command, file]
    try:
        main()
    except SystemExit as end:
        assert not end.code, file
"""
VALIDATED = {"magnet.tis", "limit.tis", "drop.tis"}


@pytest.mark.parametrize(
    ("command", "names"), [("run", scenes().keys() - VALIDATED), ("validate", VALIDATED)]
)
def test_scenes_use_members_of_an_installed_package(command, names, site, tmp_path):
    (tmp_path / "tetrahedron.raw").write_text(TETRAHEDRON)
    for name in names:
        (tmp_path / name).write_text(scenes()[name], encoding="utf-8")
    printed = call_python(tmp_path, site, ONE_AFTER_ANOTHER, command, *sorted(names))
    assert "fail" not in printed


def test_a_result_names_the_packages_that_its_scene_may_have_used(site, tmp_path):
    (tmp_path / "ring.tis").write_text(scenes()["ring.tis"], encoding="utf-8")
    call(tmp_path, site, "run", "ring.tis", "-q")
    assert "tissue-extras" in call(tmp_path, site, "info", "ring.vtkhdf", "--json")


def test_actions_of_a_package_are_kept_for_a_run_that_goes_on(site, tmp_path):
    code = (
        "import numpy as np\n"
        "from tissuec.engine.execution.run_state import read_state, write_state\n"
        "from tissuec.script.verbs import VERBS\n"
        "from tissue_extras.script_verbs.shrink import Shrink\n"
        "blank = Shrink(*(None for _ in Shrink.__struct_fields__))\n"
        "assert type(read_state(write_state(blank, []), [])) is Shrink and 'shrink' in VERBS\n"
    )
    call_python(tmp_path, site, code)


#: What an editor is given about a block of a package.
ASKED = r"""
from pathlib import Path
from tissuec.lsp.completion import complete
from tissuec.lsp.documents import OpenDocuments
from tissuec.lsp.highlighting import grammar
from tissuec.lsp.hover import hover
from tissuec.lsp.semantic_tokens import tokens
from tissuec.lsp.views import view_of

def at(text, ask):
    documents = OpenDocuments()
    documents.put(Path("a.tis"), text.replace("|", ""))
    return ask(view_of(documents, Path("a.tis")), text.index("|"))

def offered(text):
    return [one.label for one in at(text, complete)]

assert "landmark" in offered("language 1\nland|")
assert {"place", "side"} == set(offered("language 1\nlandmark apex { | }"))
assert {"left", "right", "middle"} == set(offered("language 1\nlandmark apex { side is | }"))
assert "on which it is" in at("language 1\nlandmark apex { si|de is left }", hover).text
text = "language 1\nlandmark apex { side is left }\n"
kinds = {text[start:stop]: kind for start, stop, kind in tokens(text)}
assert (kinds["landmark"], kinds["side"], kinds["left"]) == ("part", "entry", "word")
assert "landmark-part" in grammar()["repository"]
"""


def test_editors_know_a_block_of_a_package_by_its_declaration(site, tmp_path):
    call_python(tmp_path, site, ASKED)


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ("side is left", 'landmark apex needs "place"'),
        ("place = 3 mm", "place must be a vector"),
        ("place = (0, 0, 1) mm; side is lft", 'side cannot be "lft"'),
        ("position = (0, 0, 1) mm", '"position" is not an entry of landmark apex'),
    ],
)
def test_a_block_of_a_package_is_checked_by_its_declaration(entry, said, site, tmp_path):
    text = scenes()["landmarks.tis"].replace("place = (0, 0, 13) mm; side is left", entry)
    (tmp_path / "landmarks.tis").write_text(text, encoding="utf-8")
    assert said in call(tmp_path, site, "check", "landmarks.tis", code=2)


def test_a_verb_of_a_package_lets_springs_break(clinic, tmp_path):
    (tmp_path / "pair.tis").write_text(
        PAIR
        + """script {
  at 0 s: { fix wall; weaken pair to 0.1 N }
  from 0 s to 20 ms: move end by (2, 0, 0) mm using constant speed
}
expect ruptured(pair) == 1 at 20 ms
"""
    )
    assert "1 of 1 hold" in call(tmp_path, clinic, "run", "pair.tis", "--strict")


@pytest.mark.parametrize("kind", ANNOTATED)
def test_a_wrong_annotation_is_answered_with_file_and_line(kind, tmp_path):
    (tmp_path / "coils.py").write_text(COIL.replace("KIND", kind), encoding="utf-8")
    install(tmp_path, "coils", "0.1", {"tissuec.mesh": [("coil", "coils")]})
    (tmp_path / "pair.tis").write_text(PAIR.replace("is explicit", "is coil { radius = 1 mm }"))
    said = call(tmp_path, tmp_path, "check", "pair.tis", code=2)
    assert ANNOTATED[kind] in said
    assert "coils.py:15: the annotation" in said


def test_a_wrong_annotation_of_a_verb_is_answered_with_file_and_line(tmp_path):
    (tmp_path / "sprains.py").write_text(SPRAIN, encoding="utf-8")
    install(tmp_path, "sprains", "0.1", {"tissuec.verb": [("sprain", "sprains")]})
    (tmp_path / "pair.tis").write_text(f"{PAIR}script {{ at 0 s: sprain pair to 1 N }}\n")
    said = call(tmp_path, tmp_path, "check", "pair.tis", code=2)
    assert 'sprains.py:11: the annotation of "force" in Sprain does not say which part' in said


WRONG = {
    "weaken pair": ("TIS304", "the force is missing", "for example: to 1 N"),
    "weaken pair to 0 N": ("TIS308", "the force must be above 0", "for example: to 1 N"),
    "weaken pair to 1 mm": ("TIS502", "must be a force (N)", "but 1 mm is a length"),
    "weaken pair to 1 N with haet": ("TIS305", 'unknown agent "haet"', 'did you mean "heat"'),
    "weaken pair to 1 N by 2 mm": ("TIS303", 'does not take "by"', "weaken SET to FORCE"),
    "corrode pair to 1 N": ("TIS404", "not a verb", 'did you mean "weaken"'),
}


@pytest.mark.parametrize("order", WRONG)
def test_what_is_wrong_in_a_sentence_of_a_package_follows_from_its_parts(
    order, clinic, tmp_path
):
    (tmp_path / "pair.tis").write_text(f"{PAIR}script {{ at 0 s: {order} }}\n")
    said = call(tmp_path, clinic, "check", "pair.tis", code=2)
    for text in WRONG[order]:
        assert text in said


#: Prints what an editor offers, the forms, and the description of a verb of the package.
IN_AN_EDITOR = """
import sys
from pathlib import Path
from tissuec.lsp.completion import complete
from tissuec.lsp.documents import OpenDocuments
from tissuec.lsp.hover import hover
from tissuec.lsp.signatures import signature
from tissuec.lsp.views import view_of
typed, path = sys.argv[1], Path("pair.tis")
text = path.read_text() + "script { at 0 s: " + typed
documents = OpenDocuments()
documents.put(path, text + " }")
view = view_of(documents, path)
print(*sorted(one.label for one in complete(view, len(text))), sep=", ")
found = signature(view, len(text))
print(found and [form.text for form in found.forms])
"""
OFFERED = {
    "weaken ": "end, pair, to, wall, with",
    "weaken pair ": "to, with",
    "weaken pair to 1 ": "N, kN, mN",
    "weaken pair to 1 N with ": "acid, heat",
}


@pytest.mark.parametrize("typed", OFFERED)
def test_editors_offer_the_parts_of_a_verb_of_a_package(typed, clinic, tmp_path):
    (tmp_path / "pair.tis").write_text(PAIR)
    said = call_python(tmp_path, clinic, IN_AN_EDITOR, typed)
    assert OFFERED[typed] in said
    assert "'weaken SET to FORCE', 'weaken SET to FORCE with heat'" in said


@pytest.mark.parametrize(
    ("order", "follows"),
    [
        ("clamp end", "release end"),
        ("throw end", "cut pair along plane through (100, 0, 0) mm facing (1, 0, 0)"),
    ],
)
def test_checks_know_what_a_verb_of_a_package_holds_and_moves(order, follows, clinic, tmp_path):
    (tmp_path / "pair.tis").write_text(
        f"{PAIR}script {{ at 0 s: fix wall; at 1 ms: {order}; at 10 ms: {follows} }}\n"
    )
    assert "pair.tis: good" in call(tmp_path, clinic, "check", "pair.tis", "--strict")


def test_nothing_is_known_of_a_package_that_is_not_installed(tmp_path):
    (tmp_path / "ring.tis").write_text(scenes()["ring.tis"], encoding="utf-8")
    assert 'there is no mesh called "ring"' in call(
        tmp_path, tmp_path, "check", "ring.tis", code=2
    )


def test_a_package_that_cannot_be_imported_is_named(tmp_path):
    break_in(tmp_path)
    (tmp_path / "ring.tis").write_text(scenes()["ring.tis"], encoding="utf-8")
    said = call(tmp_path, tmp_path, "check", "ring.tis", code=2)
    assert "the package broken 0.3 cannot add a mesh: importing broken fails" in said


def test_a_package_that_cannot_be_imported_is_named_each_time(tmp_path):
    break_in(tmp_path)
    code = (
        "from tissuec.core.plugins import BrokenPlugIn\n"
        "from tissuec.meshes.generators import MESHES\n"
        "for _ in range(2):\n"
        "    try:\n"
        "        len(MESHES)\n"
        "    except BrokenPlugIn as error:\n"
        "        print(error)\n"
    )
    said = call_python(tmp_path, tmp_path, code)
    assert said.count("the package broken 0.3 cannot add a mesh") == 2
