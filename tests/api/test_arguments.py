"""Arguments of another type or size than Python's functions take."""

import pickle
import warnings

import numpy as np
import pytest

import tissuec
from tests.api.scenes import FLYING, PULL
from tissuec.pipeline import compile_request
from tissuec.scene.program import imports

HUGE = 10**5000  # of more digits than Python prints
STUDY = (
    PULL + "study s { vary pull = [1 mm, 2 mm]; measure x = max(position of bob along x) }\n"
)


@pytest.fixture(scope="module")
def result():
    with tissuec.run(PULL, companion="off") as trajectory:
        yield trajectory


@pytest.fixture
def run():
    with tissuec.start(PULL) as stepped:
        yield stepped


WRONG = [
    (lambda: tissuec.run(PULL, pull=HUGE), "pull is too large for a floating-point number"),
    (lambda: tissuec.run(PULL, way=(HUGE, 0, 0)), "way is too large for a floating-point"),
    (lambda: tissuec.check(PULL, params={1: 2}), "the name of a param must be a text, not 1"),
    (lambda: tissuec.check(PULL, params={None: 2}), "name of a param must be a text, not None"),
    (lambda: tissuec.check(PULL, libraries="shared"), r"must be a list, such as \['shared'\]"),
    (lambda: tissuec.check(PULL, libraries=3), r"libraries must be a list, such as \[3\]"),
    (lambda: tissuec.run(PULL, threads="2"), "threads must be a whole number, not '2'"),
    (lambda: tissuec.start(PULL, threads=True), "threads must be a whole number, not True"),
    (lambda: tissuec.modes(FLYING, count=-1), "count must be 1 or more, not -1"),
    (lambda: tissuec.modes(FLYING, count=1.5), "count must be a whole number, not 1.5"),
    (lambda: tissuec.modes(FLYING, above="1 Hz"), "above must be a number, not '1 Hz'"),
    (lambda: tissuec.modes(FLYING, above=float("nan")), "above must be a finite number"),
    (lambda: tissuec.modes(FLYING, body=["ball"]), "body must be a text"),
    (lambda: tissuec.properties(FLYING, body=3), "body must be a text, not 3"),
    (lambda: tissuec.properties(FLYING, frequencies=-1), "frequencies must be 0 or more"),
    (lambda: tissuec.examine(PULL, tissue=3), "tissue must be a text, not 3"),
    (lambda: tissuec.examine(PULL, spacing=0), "spacing must be above 0, not 0"),
    (lambda: tissuec.examine(PULL, thickness=-1e-3), "thickness must be above 0, not -0.001"),
    (lambda: tissuec.study(STUDY, workers=0), "workers must be 1 or more, not 0"),
    (lambda: tissuec.study(STUDY, workers=-1), "workers must be 1 or more, not -1"),
    (lambda: tissuec.study(STUDY, workers=1.5), "workers must be a whole number, not 1.5"),
    (lambda: tissuec.study(STUDY, 3), "the name of a study must be a text, not 3"),
    (
        lambda: tissuec.study(STUDY, sentences="error estimate is off"),
        "sentences must be a list",
    ),
]


@pytest.mark.parametrize(("call", "message"), WRONG, ids=[message for _, message in WRONG])
def test_an_argument_of_another_kind_is_named(call, message):
    with pytest.raises((TypeError, ValueError), match=message):
        call()


@pytest.mark.parametrize("name", [None, 3, ["bob"], b"bob"], ids=str)
def test_names_of_nodes_are_texts(result, run, name):
    for owner in (result, run):
        for ask in (owner.nodes_of, owner.springs_of):
            with pytest.raises(TypeError, match="a name must be a text, not "):
                ask(name)


STEPS = [
    (lambda run: run.step(None), "a time in seconds must be a number, not None"),
    (lambda run: run.step([1]), r"a time in seconds must be a number, not \[1\]"),
    (lambda run: run.step(True), "a time in seconds must be a number, not True"),
    (lambda run: run.step(HUGE), "a time in seconds is too large"),
    (lambda run: run.order(None), "a sentence must be a text, not None"),
    (lambda run: run.measure(3), "a measure must be a text, not 3"),
    (lambda run: run.holds(b"x"), "a condition must be a text"),
]


@pytest.mark.parametrize(("call", "message"), STEPS, ids=[message for _, message in STEPS])
def test_an_argument_of_a_stepped_run_is_named_and_nothing_is_done(run, call, message):
    with pytest.raises((TypeError, ValueError), match=message):
        call(run)
    assert run.time == 0


def test_numbers_of_numpy_are_numbers():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert len(tissuec.modes(FLYING, count=np.int64(2), above=np.float32(0))) <= 2


def test_a_text_is_parsed_once_also_when_params_are_given(monkeypatch):
    parsed, parse = [], imports.parsed
    monkeypatch.setattr(
        imports, "parsed", lambda source: parsed.append(source) or parse(source)
    )
    assert tissuec.compile(PULL, pull=1e-3).scene.source.text == PULL
    assert [source.name for source in parsed].count("scene") == 1


def test_what_is_parsed_once_leaves_no_modules_in_other_processes():
    compiled, request = tissuec.api._compiled(PULL, {"pull": 1e-3}, ())
    again = pickle.loads(pickle.dumps(request))
    assert request.files._modules and not again.files._modules
    positions = compile_request(again)[0].network.position
    assert np.array_equal(positions, compiled.network.position)
