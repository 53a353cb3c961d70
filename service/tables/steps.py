"""Times of steps by mesh, without contact, as a table."""

from __future__ import annotations

from tauten.service.bench import StepBench
from tauten.service.tables.numbers import Numbers, Page, measured_on, milliseconds


def steps_page(result: StepBench) -> Page:
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
    table = Numbers(title, ("nodes", "elements", "factorisation", "forward", "inverse"), rows, 0)
    return Page("tauten bench steps", f"Measured on {measured_on(result.machine)}", (table,))
