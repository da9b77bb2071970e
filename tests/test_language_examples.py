"""The files by which the language was first shown still mean what they say."""

import pytest

from tissuec.pipeline import check_request, compile_request, simulate
from tissuec.scene.request import Request


@pytest.fixture
def examples(repository):
    return repository / "tests" / "lang" / "examples"


@pytest.mark.parametrize(
    "name", ["soft_tissue", "fallopian_tube", "sterilisation", "indentation", "learn"]
)
def test_an_example_is_checked_without_errors(name, examples):
    _, warnings = check_request(Request.file(examples / f"{name}.tis"))
    # By the published words, springs break at 60 times their length, and presets are of a mesh.
    assert {warning.code for warning in warnings} <= {"W209", "W801"}


@pytest.mark.parametrize(
    "name",
    # The second one has 17 449 nodes and takes 160 000 steps.
    ["sterilisation", pytest.param("indentation", marks=pytest.mark.slow)],
)
def test_an_example_runs_and_its_expectations_hold(name, examples, tmp_path):
    request = Request.file(examples / f"{name}.tis")
    compiled, _ = compile_request(request)
    path = tmp_path / "result.vtkhdf"
    outcome = simulate(compiled, path, request=request, companion="off").outcome
    assert outcome.kind == "done"
    assert not outcome.failures
