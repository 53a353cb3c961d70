"""Times of steps by mesh, without contact, as a table."""

from __future__ import annotations

from tauten.service.bench import StepBench
from tauten.service.tables.numbers import Numbers, milliseconds


def steps_table(result: StepBench) -> Numbers:
    """Forward and inverse steps without contact, on a mesh and its refinements."""
    rows = tuple(
        (
            str(mesh.sizes.nodes),
            str(mesh.sizes.elements),
            mesh.factorisation,
            milliseconds(mesh.forward_ms),
            milliseconds(mesh.inverse_ms),
        )
        for mesh in result.meshes
    )
    title = f"{result.robot}: one step without contact, median / p99 in ms"
    return Numbers(title, ("nodes", "elements", "factorisation", "forward", "inverse"), rows, 0)
