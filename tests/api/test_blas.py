"""Calls from Python use BLAS on one thread, and leave its settings as they are."""

import inspect
import os
import subprocess
import sys

import pytest

import tissuec
from tissuec.core.blas import VARIABLE

UNUSED = """language 1
param spare = 1 mm
tissue gel { spring constant = 1 N/m; viscosity = 0 N*s/m; mass = 1 g }
body bar {
  mesh is lattice {
    kind is sodium chloride; cell = 5 mm; box from (0, 0, 0) mm to (5, 5, 5) mm
  }
  tissue is gel
}
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 ms }
"""
#: Prints the numbers of threads before, during and behind a check; while SciPy is loaded, and
#: behind it; and the number of processors.
COUNTS = f"""
import os, sys
import numpy.linalg, tissuec
from tissuec import pipeline
from tissuec.core.blas import _libraries, on_one_thread
found, check = [], pipeline.check_request
def note():
    counts = [library.threads() for library in _libraries().values()]
    found.append((counts, os.environ.get("{VARIABLE}")))
def checked(*given, **named):
    note()
    return check(*given, **named)
@on_one_thread
@on_one_thread
def load():
    import scipy.linalg
    note()
pipeline.check_request = checked
for library in _libraries().values():
    library.set_threads(3)
note()
tissuec.check("language 1")
note()
load()
note()
print((*found, [library.processors() for library in _libraries().values()]))
"""


def found(**more):
    environment = {k: v for k, v in os.environ.items() if k != VARIABLE} | more
    command = [sys.executable, "-c", COUNTS]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return eval(done.stdout)


def bundles_openblas():
    import numpy

    return "openblas" in str(numpy.show_config(mode="dicts")["Build Dependencies"]["blas"])


@pytest.mark.skipif(not bundles_openblas(), reason="NumPy has another BLAS")
def test_blas_uses_one_thread_in_calls_and_as_many_as_before_behind_them():
    before, during, behind, loading, end, processors = found()
    assert before == behind == ([3], None)
    assert during == ([1], "1")
    # SciPy may share the library of NumPy.
    assert loading == ([1] * len(processors), "1")
    assert end == ([3, *processors[1:]], None)


@pytest.mark.skipif(not bundles_openblas(), reason="NumPy has another BLAS")
def test_a_user_who_sets_the_variable_decides():
    *found_then, _ = found(**{VARIABLE: "2"})
    assert all(counts in ([3], [3, 2]) and said == "2" for counts, said in found_then)


def test_calls_keep_their_signatures_and_warn_who_called():
    assert str(inspect.signature(tissuec.check)).startswith("(scene: ")
    with pytest.warns(tissuec.TissueWarning) as found:
        tissuec.compile(UNUSED)
    assert [one.filename for one in found] == [__file__]


@pytest.mark.parametrize("name", [{}, {"__name__": "notebook"}])
def test_code_without_the_name_of_a_module_is_warned(name):
    code = compile("\ntissuec.compile(text)", "cell", "exec")
    with pytest.warns(tissuec.TissueWarning) as found:
        exec(code, {"tissuec": tissuec, "text": UNUSED, **name})
    assert [(one.filename, one.lineno) for one in found] == [("cell", 2)]
