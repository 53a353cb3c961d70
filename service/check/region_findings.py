"""What each region of a robot file selects: counted for the findings, and as geometry to draw."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tauten.model.load import Bodies
from tauten.model.numerics import Array, Ints
from tauten.model.schema import Region, RobotConfig, RobotFileError
from tauten.service.check.findings import Finding


@dataclass(frozen=True, slots=True)
class RegionParts:
    """What one region selects.

    Attributes:
        name: its name, or the field it stands in.
        nodes: (k, 3) positions of its nodes at rest [m].
        triangles: (t, 3, 3) corners of its boundary triangles at rest [m].
        n_tets: its tetrahedra.
    """

    name: str
    nodes: Array
    triangles: Array
    n_tets: int

    @property
    def of_beams(self) -> bool:
        """Whether it is a surface in a file of beams, which is as the file says."""
        return len(self.nodes) == 0 and len(self.triangles) > 0

    @property
    def finding(self) -> Finding:
        """Its counts."""
        found = (
            f"{len(self.nodes)} nodes, {len(self.triangles)} boundary triangles, "
            f"{self.n_tets} tetrahedra"
        )
        if len(self.nodes) or len(self.triangles) or self.n_tets:
            return Finding(f"region {self.name}", "fine", found)
        advice = "it selects nothing: move it, or delete it"
        return Finding(f"region {self.name}", "doubtful", found, advice)


def region_parts(config: RobotConfig, bodies: Bodies) -> Iterator[RegionParts]:
    """What the named regions and those of `fixed` select."""
    touching = bodies.touching  # with the surfaces of beams
    selections: dict[str, Region | str] = dict(config.named_regions())
    for field, selection in config.selections():
        if not isinstance(selection, str) and not field.startswith("bodies."):
            selections[field] = selection
    for name, selection in selections.items():
        yield RegionParts(
            name,
            bodies.selector.nodes[chosen(bodies.selector.select_nodes, selection)],
            touching.nodes[touching.boundary[chosen(touching.select_triangles, selection)]],
            len(chosen(bodies.selector.select_tets, selection)),
        )


def chosen(select: object, selection: Region | str) -> Ints:
    """Ids of what a method of a selector selects; none where it refuses an empty region."""
    try:
        found: Ints = np.flatnonzero(select(selection, ""))  # type: ignore[operator]
    except RobotFileError:
        return np.zeros(0, dtype=np.int64)
    return found
