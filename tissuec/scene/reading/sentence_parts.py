"""Parts whose sentences the compiler reads, with meshes, and those of learn and study."""

from msgspec.structs import replace

from tissuec.core.fields import OneOf
from tissuec.scene.learning import entries as learn_entries
from tissuec.scene.learning import sentences as learn_sentences
from tissuec.scene.reading.block_sentences import as_entries
from tissuec.scene.reading.entries import Entries, entries_of
from tissuec.scene.reading.parts import SCENE, block, declare
from tissuec.scene.settings import integrators
from tissuec.scene.study import entries as study_entries


def _learn_entries() -> Entries:
    settings, known = learn_entries.learn_schema(), integrators()
    words = {word: known[word] for word in settings["integrator"].words}
    integrator = replace(settings["integrator"], kind=OneOf(words))
    sentences = as_entries(learn_sentences.SENTENCES)
    return {**sentences, **settings, "integrator": integrator}


declare(
    "learn", "Fits numbers of tissues, nodes, springs or words to measured data.", 30,
    block=block(_learn_entries),
)  # fmt: skip
declare(
    "study", "Many runs of the scene: what varies, and what is measured.", 31,
    block=block(lambda: {
        **as_entries(study_entries.SENTENCES), **entries_of(study_entries.StudySettings)
    }),
)  # fmt: skip
declare(
    "script", "Actions at given times or conditions.", 41, "single",
    block=block({}),
)  # fmt: skip
declare(
    "set", "A named set of nodes or springs, selected on the mesh as drawn.", 52, "sentence",
    forms=(
        "set NAME = nodes of BODY in LIST where CONDITION",
        "set NAME = springs of DRAWN in LIST where CONDITION",
    ),
    names=SCENE,
)  # fmt: skip
declare(
    "expect",
    "An expected result; a failed expectation is reported after the run.", 54, "sentence",
    forms=(
        "expect CONDITION at TIME", "expect CONDITION from TIME to TIME",
        "expect CONDITION until TIME", "expect CONDITION over run",
    ),
)  # fmt: skip
