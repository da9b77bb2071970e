"""Forces of a scene: blocks become fields on nodes."""

import numpy as np

from tissuec.compiler.ambient_damping import skin_areas
from tissuec.compiler.sets import Groups
from tissuec.forces.acting import Acted
from tissuec.forces.fields import Field
from tissuec.forces.potential_fields import PotentialField
from tissuec.model.blocks import FieldBlock, name_of_force
from tissuec.model.network import Network
from tissuec.scene.model import Scene
from tissuec.scene.reading import schema
from tissuec.scene.reading.findings import Findings


def force_blocks(
    scene: Scene, network: Network, groups: Groups, findings: Findings
) -> list[FieldBlock]:
    """Return the forces of a scene; each one that cannot act is rejected by itself."""
    found: list[FieldBlock] = []
    area = skin_areas(network)
    for force in scene.forces.values():
        with findings.item():
            nodes = np.unique(groups.nodes(force.target).indices)
            own = nodes, network.position[nodes], network.mass[nodes], area[nodes]
            acted = Acted(*own, network.skin, network.line_ends, network.skin_elements)
            try:
                field = force.entries.on(acted)
                _check(field, network)
            except ValueError as error:
                reason = str(error)
                findings.reject(
                    "TIS309",
                    f"force {force.name}: {reason}",
                    schema.blamed(reason, force.places, force.target.span),
                )
            found.append(FieldBlock(name_of_force(force.name), force.kind, field, force.span))
    return found


def _check(field: Field, network: Network) -> None:
    """Check what another package has written; raises ValueError of what cannot be computed."""
    is_own = type(field).__module__.startswith("tissuec.")
    if isinstance(field, PotentialField) and not is_own:
        field.check(network.position)
