"""What LLVM is told of arguments that share no memory."""

import lzma
import re

import pytest

from tissuec.compiled.bundles import BUNDLES
from tissuec.compiled.loading import ENDING, SHIPPED
from tissuec.forces.springs import pairs_kernel, runs_kernel

MODULES = {
    name: {"runs": runs_kernel, "springs": pairs_kernel}[name.partition("_")[0]]
    for name in BUNDLES
    if name.startswith(("runs", "springs_viscous"))
}


@pytest.mark.parametrize("bundle", MODULES)
def test_loops_over_springs_are_shipped_with_what_is_known_of_their_memory(bundle):
    text = lzma.decompress((SHIPPED / f"{bundle}{ENDING}").read_bytes()).decode()
    for names in MODULES[bundle].UNSHARED.values():
        # What an argument is said to be; those that are not needed are left out.
        called = re.findall(rf"^define .*%arg\.{names[0]}\.4\W.*$", text, re.MULTILINE)
        said = [
            re.findall(rf"ptr ([^%,]*)%arg\.{name}\.4\W", head)
            for head in called
            for name in names
        ]
        if any(said):
            assert all("noalias" in each for found in said for each in found)
        else:  # Where the function is inlined, LLVM turns "noalias" into scopes of their own.
            needed = [name for name in names if name != "above" or "watched" in bundle]
            assert text.count("!alias.scope") >= len(needed)
