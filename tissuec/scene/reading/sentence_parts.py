"""Parts whose sentences the compiler reads, with meshes, and those of learn and study."""

from msgspec.structs import replace

from tissuec.core.fields import OneOf
from tissuec.core.precision import PRECISIONS
from tissuec.geometry.surfaces import SURFACES
from tissuec.scene.learning import entries as learn_entries
from tissuec.scene.learning import sentences as learn_sentences
from tissuec.scene.reading.block_sentences import as_entries
from tissuec.scene.reading.entries import Entries, by_name, entries_of, entry, written
from tissuec.scene.reading.parts import SCENE, block, block_of, declare
from tissuec.scene.settings import integrators
from tissuec.scene.study import entries as study_entries

#: Entries of output beside measures.
OUTPUT_ENTRIES = by_name(
    written(
        "trajectory", "Positions of all or some nodes at regular times.",
        "trajectory of SET with FIELD every TIME", begins=" every ",
    ),
    written(
        "surface", "A smooth surface through a body at regular times.",
        "surface of BODY every TIME", repeats=True,
        opens=block_of(SURFACES, "kind of surface", default=""),
    ),
    entry(
        "precision", OneOf(PRECISIONS),
        "whether positions are stored with single or double precision", "single",
    ),
    written("compress", "Makes frames and surfaces smaller, without loss.", "compress"),
    written(
        "blocks", "A file for ParaView with the parts of bodies, beside the result.", "blocks"
    ),
    written(
        "energy", "Energies of the whole scene and the drift of their sum.",
        "energy every TIME", "energy of MEASURED every TIME", begins=" every ",
    ),
)  # fmt: skip


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
    "output", "Contents of the result file.", 43, "single",
    example="output { trajectory every 10 ms }",
    block=block(OUTPUT_ENTRIES, "MEASURE of MEASURED to MEASURED every TIME"),
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
