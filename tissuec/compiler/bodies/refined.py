"""A scene whose bodies of elements have cells half as long."""

from typing import Any

from tissuec.core.structs import replace
from tissuec.meshes.generators import Generator, Refinable
from tissuec.scene.model import Body, Scene
from tissuec.scene.reading.findings import Findings


def refined(scene: Scene, halvings: int, findings: Findings) -> Scene:
    """Return a scene with shorter cells in its bodies of elements; springs stay as they are.

    The properties of a net of springs are those of its springs, so that a finer net is another
    tissue.

    Args:
        halvings: How often cells are halved.
        findings: Takes what is wrong.

    Raises:
        CompileError: No body consists of elements, or cells of one cannot be halved.
    """
    solid = {key: body for key, body in scene.bodies.items() if body.elements is not None}
    if not solid:
        findings.raise_errors()  # which leave out bodies
        findings.add(
            "TIS309",
            "no body consists of elements, so no mesh can be refined",
            next(iter(scene.bodies.values())).span,
            hint="a net of springs is as fine as its tissue says; describe the tissue by its "
            "Young's modulus to make it of elements",
        )
        findings.raise_errors()
    finer = {
        key: replace(body, mesh=_halved(body, halvings, findings), is_refined=True)
        for key, body in solid.items()
    }
    return replace(scene, bodies={**scene.bodies, **finer})


def _halved(body: Body, halvings: int, findings: Findings) -> Generator:
    mesh: Any = body.mesh
    for _ in range(halvings):
        if not isinstance(mesh, Refinable):
            findings.add(
                "TIS309",
                f"the mesh of {body.name} has cells that cannot be halved",
                body.span,
                hint="run the scene with a finer mesh file, and compare both results with "
                "tissuec compare",
            )
            findings.raise_errors()
        mesh = mesh.refined()
    return mesh
