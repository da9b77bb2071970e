"""Embedded nodes as scalar loops; see ``acting.embedding``."""

from tissuec.kernels.records import EmbeddingTable, Floats


def collect(
    time: float, x: Floats, v: Floats, f: Floats, power: Floats, embedding: EmbeddingTable
) -> None:
    """Move the forces on embedded nodes that are there already to their hosts.

    Args:
        embedding: The embedded nodes.
    """
    for k in range(embedding.nodes.size):
        i = 3 * embedding.nodes[k]
        for entry in range(embedding.first[k], embedding.first[k + 1]):
            j, weight = 3 * embedding.hosts[entry], embedding.weights[entry]
            f[j] += weight * f[i]
            f[j + 1] += weight * f[i + 1]
            f[j + 2] += weight * f[i + 2]
        f[i] = f[i + 1] = f[i + 2] = 0.0


def follow(values: Floats, embedding: EmbeddingTable) -> None:
    """Set vectors of embedded nodes to the weighted sums of those of their hosts.

    Args:
        values: Of all nodes in any unit, flat, shape (3 node,).
        embedding: The embedded nodes.
    """
    for k in range(embedding.nodes.size):
        i = 3 * embedding.nodes[k]
        s0 = s1 = s2 = 0.0
        for entry in range(embedding.first[k], embedding.first[k + 1]):
            j, weight = 3 * embedding.hosts[entry], embedding.weights[entry]
            s0 += weight * values[j]
            s1 += weight * values[j + 1]
            s2 += weight * values[j + 2]
        values[i], values[i + 1], values[i + 2] = s0, s1, s2
