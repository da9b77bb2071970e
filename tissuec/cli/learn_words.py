"""``tissuec learn`` for blocks that fit words to numbers of tissues."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from tissuec.cli.common import DONE, FAILED, Settings, echo, keep_input
from tissuec.cli.learn_options import LearnOptions
from tissuec.core.errors import counted
from tissuec.results import wording

if TYPE_CHECKING:
    from tissuec.learn.words_fit.fitting import LearntVocabulary
    from tissuec.scene.learn_model import VocabularyFit
    from tissuec.scene.request import Request
    from tissuec.scene.resolved import ResolvedProgram


def fit_vocabulary(
    fit: "VocabularyFit", request: "Request", wishes: LearnOptions, settings: Settings
) -> tuple[int, dict[str, Any]]:
    """Fit words and write them; returns the exit code and the document.

    Args:
        fit: The learn block.
        request: The text that contains it.
        wishes: Options of the command.
        settings: Settings of all commands.

    Raises:
        UsageError: A check of the derivatives of a motion was requested.
        TissueError: The vocabulary cannot be written to its file.
    """
    from tissuec.learn.presets.fitted_vocabulary import compose_vocabulary, sources_of
    from tissuec.learn.presets.placing import place
    from tissuec.learn.report.fitted_words import as_dict
    from tissuec.learn.report.passes import Passes
    from tissuec.learn.report.words import unified
    from tissuec.learn.words_fit.fitting import fit_words
    from tissuec.pipeline import read_words

    if wishes.gradient:
        raise click.UsageError(
            f"learn {fit.name} has no data, so there are no derivatives of a motion to check"
        )
    words = read_words(request)[0]
    target = wishes.output or fit.write
    if target is not None:
        _check_place(target, fit, words, request, force=wishes.force)
    with Passes(f"learn {fit.name}", shown=settings.shows_progress) as line:
        learnt = fit_words(request, fit, words, progress=line.at)
    if not settings.json:
        _tell(learnt, settings)
        if wishes.diff:
            before = {name: one.text for name, one in sources_of(fit, words).items()}
            click.echo("".join(unified(before, learnt.texts)), nl=False)
    doubt = _doubt(learnt)
    files: list[Path] = []
    if target is not None and (wishes.anyway or not doubt):
        preset = compose_vocabulary(learnt, words, request, target)
        files = place(preset, force=wishes.force)
    document = as_dict(learnt) | {"written": [str(file) for file in files]}
    if settings.json:
        return FAILED if doubt else DONE, document
    for file in files:
        settings.say(f"wrote {file}")
    if doubt:
        is_lost = target is not None and not files
        lost = "; nothing is written (to write it: --anyway)" if is_lost else ""
        echo(f"FAILED: {doubt}{lost}", err=True)
    return FAILED if doubt else DONE, document


def _check_place(
    target: Path,
    fit: "VocabularyFit",
    words: "ResolvedProgram",
    request: "Request",
    *,
    force: bool,
) -> None:
    """Reject a target before time is spent: a text of the scene, or an unrelated file."""
    from tissuec.learn.presets.fitted_vocabulary import rehearse_vocabulary, sources_of
    from tissuec.learn.presets.placing import refuse_others

    for source in sources_of(fit, words).values():
        if source.path is not None:
            keep_input(target, source.path)
    planned = rehearse_vocabulary(fit, words, request, target)
    if not force:
        refuse_others(planned.files)


def _doubt(learnt: "LearntVocabulary") -> str:
    """Return why the words should not be used, empty if they can be."""
    if not learnt.converged:
        return f"{learnt.reason}; increase passes"
    failed = len(learnt.failed)
    return f"{counted(failed, 'expectation')} failed" if failed else ""


def _tell(learnt: "LearntVocabulary", settings: Settings) -> None:
    """Print the results, and the expectations that fail."""
    from tissuec.learn.report.fitted_words import as_text

    echo("\n".join(as_text(learnt)))
    failed = learnt.failed
    for place, measured in failed:
        echo(f"FAILED {place}", err=True)
        echo(f"       {measured}", err=True)
    if learnt.fit.demands:
        holding = len(learnt.fit.demands) - len(failed)
        states = ["holds"] * holding + ["fails"] * len(failed)
        settings.say(f"expectations: {wording.expectations(states)}")
