"""What LLVM is told of arguments that share no memory."""

import lzma

import pytest

from tissuec.forces.runs_kernel import UNSHARED
from tissuec.kernels.bundles import BUNDLES
from tissuec.kernels.loading import ENDING, SHIPPED


@pytest.mark.parametrize("bundle", [name for name in BUNDLES if name.startswith("runs")])
def test_loops_over_runs_are_shipped_with_what_is_known_of_their_memory(bundle):
    # Where the functions are inlined, LLVM turns "noalias" into scopes of their own.
    text = lzma.decompress((SHIPPED / f"{bundle}{ENDING}").read_bytes()).decode()
    assert text.count("!alias.scope") >= sum(map(len, UNSHARED.values()))
