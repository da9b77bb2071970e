"""Which node each part of a cell has after a cut.

Places of parts at nodes (*slots*) are joined by faces. What they are joined to at a node is a
component, which needs a node of its own. Cells that met in an edge or node alone before stay
together there if the level does not pass between them.
"""

from collections.abc import Sequence

import numpy as np
from msgspec import Struct

from tissuec.geometry.cut_cells.clipping import Bools
from tissuec.geometry.cut_cells.contacts import SlotTable, contacts
from tissuec.geometry.cut_cells.joining import PartFaces
from tissuec.geometry.cut_cells.parts import CellParts, Sides
from tissuec.model.network import Floats, Indices
from tissuec.model.topology import pieces


class NodeCopies(Struct, frozen=True, eq=False):
    """Nodes of parts after a cut.

    Attributes:
        nodes: Of the parts of each shape, shape (part, node) each.
        copied: The present node that each new one is a copy of, shape (new node,).
    """

    nodes: tuple[Indices, ...]
    copied: Indices


def node_copies(
    groups: Sequence[CellParts],
    joins: PartFaces,
    opposed: PartFaces,
    source: Indices,
    sign: Sides,
    heights: Floats,
    marked: Bools,
) -> NodeCopies:
    """Return the nodes of parts.

    A component keeps the present node if one of its parts is on the side of the node's own
    place; if there is none, or if there are several, the largest by volumes over those of
    cells keeps it.

    Args:
        groups: Parts with their former nodes, those of each shape.
        joins: Faces through which they hold together.
        opposed: Faces through which they did.
        source: Former part of each of all parts, shape (part,).
        sign: The side of the level on which each is, or 0, shape (part,).
        heights: Of nodes [m], shape (node,).
        marked: Nodes of cells that are cut, shape (node,).
    """
    table = SlotTable.of(groups, marked)
    label = pieces(len(table), table.paired(joins)).astype(np.int64)
    label = _with_contacts(groups, table, label, opposed, source, sign, marked)
    count = int(label.max(initial=-1)) + 1
    node = np.zeros(count, dtype=np.int64)
    node[label] = table.node
    size = np.bincount(label, table.fraction, count)
    here = np.where(heights >= 0.0, 1, np.where(heights < 0.0, -1, 0))[table.node]
    is_own = np.zeros(count, dtype=bool)
    is_own[label[here * sign[table.part] >= 0]] = True
    order = np.lexsort((-size, ~is_own, node))
    order = order[marked[node[order]]]
    is_first = np.ones(len(order), dtype=bool)
    is_first[1:] = node[order[1:]] != node[order[:-1]]
    new = np.sort(order[~is_first])
    number = node.copy()
    number[new] = len(heights) + np.arange(len(new))
    return NodeCopies(table.renumbered(groups, number[label]), node[new])


def _with_contacts(
    groups: Sequence[CellParts],
    table: SlotTable,
    label: Indices,
    opposed: PartFaces,
    source: Indices,
    sign: Sides,
    marked: Bools,
) -> Indices:
    """Return components of slots that are joined at edges and nodes, too; shape (slot,)."""
    former = pieces(
        int(label.max(initial=-1)) + 1,
        np.concatenate([label[table.divided(source)], label[table.paired(opposed)]]),
    )[label]
    # Nodes at which cells held together by no faces.
    order = np.lexsort((former, table.node))
    node, group = table.node[order], former[order]
    several = (node[1:] == node[:-1]) & (group[1:] != group[:-1])
    special = np.zeros(len(marked), dtype=bool)
    special[node[1:][several]] = True
    special &= marked
    if not special.any():
        return label
    found = contacts(groups, table, special, sign)
    apart = former[found.slots[:, 0]] != former[found.slots[:, 1]]
    # At all nodes of an edge, or at none.
    pairs = found.slots[np.bincount(found.number, apart)[found.number] > 0.0]
    return pieces(int(label.max()) + 1, label[pairs])[label].astype(np.int64)
