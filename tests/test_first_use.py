"""Every public function, used first by several threads of a fresh process at once."""

import subprocess
import sys

import pytest

import tissuec
from tests.test_foreign_folder import PLAIN, SCENE

THREADS = 4
STUDY = SCENE[: SCENE.index("learn thread")]
#: Expressions for all that `tissuec.__all__` has to call; SCENE and RESULT are there.
USES = {
    "check": "tissuec.check(PLAIN)",
    "compile": "tissuec.compile(PLAIN).network.node_count",
    "environment": (
        "tissuec.environment(PLAIN, observations=['force of left'], reward='force(left)',"
        " actions={'push right with ({} mN, 0 mN, 0 mN)': (0, 1)},"
        " step='10 ms').reset()[0].shape"
    ),
    "examine": "refused(lambda: tissuec.examine(PLAIN, tissue='threat'))",
    "load": "tissuec.load(RESULT).times.tolist()",
    "modes": "len(tissuec.modes(PLAIN.replace('from 0 s to', 'from 10 ms to')))",
    "properties": "len(tissuec.properties(PLAIN))",
    "read_table": "len(tissuec.read_table(TABLE))",
    "run": "tissuec.run(PLAIN, companion='inline').outcome",
    "start": "tissuec.start(PLAIN).step('10 ms')",
    "study": "len(tissuec.study(STUDY, workers=1))",
    "Trajectory": "tissuec.Trajectory(RESULT).sets.keys()",
    "StudyTable": "type(tissuec.read_table(TABLE)) is tissuec.StudyTable",
}
PROGRAM = f"""if True:
    import sys, threading, traceback, warnings
    import tissuec
    PLAIN, STUDY, RESULT, TABLE, *uses = sys.argv[1:]
    def refused(use):  # what is asked for takes minutes otherwise
        try: use()
        except tissuec.TissueError as error: return str(error)
    barrier, found = threading.Barrier({THREADS}), []
    def use(number):
        barrier.wait()
        try:
            found.append(repr(eval(uses[number % len(uses)])))
        except BaseException as error:
            found.append(f"{{uses[number % len(uses)]}}: {{error!r}}")
            print(found[-1])
    threads = [threading.Thread(target=use, args=(n,)) for n in range({THREADS})]
    for thread in threads: thread.start()
    for thread in threads: thread.join()
    if len(uses) == 1 and len(set(found)) > 1: print(found)
"""


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("done")
    tissuec.run(PLAIN, out=folder / "done.vtkhdf", companion="off").close()
    tissuec.study(STUDY, out=folder / "done.csv", workers=1)
    return [str(folder / "done.vtkhdf"), str(folder / "done.csv")]


def used(files, *names):
    """Return what goes wrong where threads of a fresh process use functions at once."""
    uses = [USES[name] for name in names]
    command = [sys.executable, "-W", "ignore", "-c", PROGRAM, PLAIN, STUDY, *files, *uses]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    return done.stdout + done.stderr


def test_every_public_function_is_used():
    others = {name for name in tissuec.__all__ if name.endswith(("Error", "Warning"))}
    assert USES.keys() == set(tissuec.__all__) - others - {"Diagnostic", "__version__"}


@pytest.mark.parametrize("name", ["check", "run"])
def test_threads_begin_with_one_function(files, name):
    assert not used(files, name)


def test_threads_begin_with_different_functions(files):
    assert not used(files, "modes", "study", "properties", "load")


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(USES))
def test_threads_begin_with_any_function_twenty_times(files, name):
    for _ in range(20):
        assert not used(files, name)
