"""What LLVM is told of arguments that share no memory."""

import lzma

import pytest

from tissuec.forces import pairs_kernel, runs_kernel
from tissuec.kernels.bundles import BUNDLES
from tissuec.kernels.loading import ENDING, SHIPPED

MODULES = {
    name: {"runs": runs_kernel, "springs": pairs_kernel}[name.partition("_")[0]]
    for name in BUNDLES
    if name.startswith(("runs", "springs_viscous"))
}


@pytest.mark.parametrize("bundle", MODULES)
def test_loops_over_springs_are_shipped_with_what_is_known_of_their_memory(bundle):
    # Where the functions are inlined, LLVM turns "noalias" into scopes of their own.
    text = lzma.decompress((SHIPPED / f"{bundle}{ENDING}").read_bytes()).decode()
    unshared = MODULES[bundle].UNSHARED
    assert text.count("!alias.scope") >= sum(map(len, unshared.values()))
