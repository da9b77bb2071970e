"""The kernels that follow from what a pair of a node and a shape stores."""

from functools import cache, cached_property, partial

from tissuec.compiled.generated import GeneratedKernel
from tissuec.compiled.loops import groups as loops
from tissuec.forces.contact.pressing import NodeOnShape, PairForm
from tissuec.forces.potential_kernels import PotentialKernels


class PairKernels(PotentialKernels):
    """The kernels of pairs, each made when it is needed.

    Args:
        pair: As traced.
    """

    def __init__(self, pair: NodeOnShape):
        super().__init__("contact", pair, {})
        self.pair = pair

    @cached_property
    def forces(self) -> GeneratedKernel:
        """Return the kernel that adds forces and powers."""
        return self._named("forces", partial(loops.force_loop, pair=self.pair))

    @cached_property
    def pull(self) -> GeneratedKernel:
        """Return ``pull_back`` of ``forces.matrices``, also by the stiffness."""
        return self._named("pull", partial(loops.pull_loop, pair=self.pair, learnt="stiffness"))

    @cached_property
    def push(self) -> GeneratedKernel:
        """Return ``push_forward`` of ``forces.matrices``, also by the stiffness."""
        return self._named("push", partial(loops.push_loop, pair=self.pair, learnt="stiffness"))


@cache
def kernels_of_pairs(form: PairForm) -> PairKernels:
    """Return the kernels of pairs of a form, once for each."""
    return PairKernels(NodeOnShape(form))
