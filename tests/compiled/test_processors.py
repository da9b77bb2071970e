"""Results are the same, to the last bit, for whatever processor kernels are made."""

import json
import os
import subprocess
import sys

import llvmlite.binding as llvm
import pytest

from tests.compiled.on_processor import SCENES
from tissuec.compiled.loading import PROCESSOR

_AVX2 = ("avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "popcnt")
_AVX512 = ("avx512bw", "avx512cd", "avx512dq", "avx512f", "avx512vl")
#: Processors, by LLVM's names, and the instructions that LLVM uses for them.
PROCESSORS = {
    "x86-64": ("sse2",),  # without fused operations: the C library has them
    "x86-64-v3": _AVX2,
    "haswell": _AVX2,
    "znver3": (*_AVX2, "sse4a"),
    "skylake-avx512": (*_AVX2, *_AVX512),
}
LIBRARY = ("indentation", "liver", "palpation", "rupture", "sterilisation", "suture")


def features():
    """Return which instructions this processor has, by LLVM's names."""
    try:
        return llvm.get_host_cpu_features()
    except RuntimeError:
        return {}


def found(processor, *scenes):
    """Return what scenes give for a processor, or for this one if it is empty."""
    command = [sys.executable, "-m", "tests.compiled.on_processor", *scenes]
    environment = os.environ | {PROCESSOR: processor}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def here():
    return found("", *SCENES)


def executable(processor):
    missing = [name for name in PROCESSORS[processor] if not features().get(name)]
    if missing:
        pytest.skip(f"this processor has no {', '.join(missing)}")
    return processor


@pytest.mark.parametrize(
    "processor",
    [
        *("x86-64", "skylake-avx512"),
        *(
            pytest.param(name, marks=pytest.mark.slow)
            for name in ("haswell", "x86-64-v3", "znver3")
        ),
    ],
)
def test_scenes_give_the_same_bits_for_every_processor(processor, here):
    assert found(executable(processor), *SCENES) == here


@pytest.mark.slow
@pytest.mark.parametrize("processor", PROCESSORS)
def test_shipped_scenes_give_the_same_bits_for_every_processor(processor):
    assert found(executable(processor), *LIBRARY) == found("", *LIBRARY)
