"""Words that were moved are found again from what their rules give."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from tests.learn.wordy import SETTING, scene_of, words_of
from tissuec.learn.vocabulary.moving import WordsModel

HEAD = """language 1
property hardness from 0 to 1 { evenly = [soft, medium, hard] }
property wetness from 0 to 1 { dry until 0.2; damp from 0.5 to 0.6; wet from 0.9 }
quantity spring constant from 2 N/m to 2000 N/m on log scale {
  evenly = [low, medium, high, very high]; applies to each spring
}
rules simple {
  if hardness is soft then spring constant is low
  if hardness is medium and wetness is not dry then spring constant is medium
  if hardness is medium and wetness is dry then spring constant is high
  if hardness is hard and wetness is wet then spring constant is high
  if hardness is hard and wetness is not wet then spring constant is very high
}
"""
BODY = """
tissue sample {k} {{ described in simple; hardness = {hardness}; wetness = {wetness} }}
body sample {k} {{ mesh is explicit; tissue is sample {k} }}
table nodes of sample {k} in mm with columns "id x y" {{ 1 0 0; 2 1 0 }}
table springs of sample {k} with columns "a b" {{ 1 2 }}
"""


def sampled(count: int):
    """Return a scene with tissues of many descriptions in numbers."""
    source = np.random.default_rng(5)
    names = [a + b for a in "bcdfghjkmp" for b in "bcdfghjkmp"][:count]
    parts = [
        BODY.format(k=name, hardness=f"{h:.3f}", wetness=f"{w:.3f}")
        for name, (h, w) in zip(names, source.random((count, 2)), strict=True)
    ]
    return scene_of(HEAD + "".join(parts) + SETTING)


@pytest.fixture(scope="module")
def model() -> WordsModel:
    adjusts = [words_of(name) for name in ("hardness", "wetness", "spring constant")]
    return WordsModel(sampled(50), adjusts)


@pytest.mark.parametrize("seed", range(3))
def test_moved_words_are_found_again(model, seed):
    truth = 0.5 * np.random.default_rng(seed).normal(size=model.size)
    wanted = np.log(list(model.given(truth).values()))

    def left(theta):
        return np.log(list(model.given(theta).values())) - wanted

    found = least_squares(left, np.zeros(model.size), lambda theta: model.jacobian(theta)[1])
    # What is left is rounding; numbers of a problem of this condition keep half their digits.
    assert np.abs(found.fun).max() < 1e-7
    assert found.x == pytest.approx(truth, abs=1e-4)
    for named in (q.named for q in model.vocabulary(found.x).quantities.values()):
        middles = [shape.middle for shape in named.scale.words.values()]
        assert middles == sorted(middles)


def test_a_prior_keeps_words_that_nothing_is_known_of(model):
    theta = np.full(model.size, 0.3)
    residuals, slopes = model.prior(theta, sigma=0.1)
    assert residuals == pytest.approx(np.full(model.size, 3.0))
    assert slopes == pytest.approx(10.0 * np.eye(model.size))
    assert model.prior(theta)[0] == pytest.approx(theta / 0.5)
