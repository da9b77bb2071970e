"""The fields of frames at the times of a run."""

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from tissuec.model.network import BodyPart, Floats, Network
from tissuec.results.fields import FIELDS, channels
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.plan import Plan
from tissuec.script.verbs.preserve import Preserve

if TYPE_CHECKING:
    from tissuec.forces.enclosed.volume import Enclosure


class FieldSampler:
    """Computes the fields that the trajectory of a plan contains."""

    def __init__(self, network: Network, plan: Plan):
        self._network, self._plan = network, plan

    @cached_property
    def _channels(self) -> tuple[tuple[str, bool], ...]:
        """Return the names of the fields, and which of them are about cells."""
        return tuple((one.name, one.at == "cell") for one in channels(self._plan.output.fields))

    @cached_property
    def _volumes(self) -> "tuple[Enclosure, ...]":
        """Return all volumes that may be preserved, in the order of ``VolumeCells``."""
        from tissuec.forces.enclosed.volume import Enclosure  # most scenes have none

        return tuple(
            Enclosure.of(self._network, body.name, 1.0, body.span)
            for body in preserved_bodies(self._network, self._plan)
        )

    def of(self, snapshot: Snapshot) -> Mapping[str, Floats]:
        """Return the numbers of the fields by name, in SI units.

        Args:
            snapshot: At one time or several.

        Returns:
            Numbers of shape (…, node), (…, node, 3), (…, spring), (…, triangle of the skin of
            the network), or (…, cell) of all cells that there can be: a cell that does not
            preserve its volume has 0.
        """
        found: dict[str, Floats] = {}
        for name, is_of_cells in self._channels:
            numbers = FIELDS[name].sample(snapshot)
            found[name] = self._on_all_cells(numbers, snapshot) if is_of_cells else numbers
        return found

    def _on_all_cells(self, numbers: Floats, snapshot: Snapshot) -> Floats:
        state, begin = snapshot.state, 0
        own: dict[str, Floats] = {}
        for enclosure in state.enclosures.values():
            end = begin + enclosure.item_count
            own[enclosure.name], begin = numbers[..., begin:end], end
        parts: list[Floats] = []
        for volume in self._volumes:
            every = np.zeros((*numbers.shape[:-1], volume.item_count))
            if volume.name in own:
                intact = np.ones(volume.item_count, dtype=bool)
                intact[volume.lost_items(state.alive)] = False
                every[..., intact] = own[volume.name]
            parts.append(every)
        return np.concatenate(parts, axis=-1)


def preserved_bodies(network: Network, plan: Plan) -> tuple[BodyPart, ...]:
    """Return the bodies that frames show whose volume is preserved at some time of a plan."""
    actions = (event.action for event in plan.every_event)
    names = {
        action.group.name
        for action in actions
        if isinstance(action, Preserve) and not action.is_fluid(network)
    }
    frames = plan.output.frames
    return tuple(
        body
        for body in network.bodies
        if body.name in names
        and ((frames >= body.nodes.start) & (frames < body.nodes.stop)).any()
    )
