"""Regions of a robot file on a mesh: the nodes, boundary triangles or tetrahedra that they select.

A box and other shapes select nodes by their position, triangles and tetrahedra by their centre. What is
defined by boundary triangles (skin, normal, STL) selects the nodes of these triangles and the tetrahedra
behind them. A group of the mesh file selects the nodes of its cells, boundary triangles that are in it or
belong to its tetrahedra, and the tetrahedra in it or behind its triangles. Numbers of nodes select these
nodes, and the triangles and tetrahedra all of whose corners they are. Set operations apply to whatever is
wanted.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, Protocol

import numpy as np

from tauten.model.mesh.groups import CellGroup, NodeNumbers
from tauten.model.mesh.mesh_files import MeshError, read_triangles
from tauten.model.mesh.surface import boundary_owners, boundary_triangles, unit_normals
from tauten.model.mesh.tet_mesh import UNITS, TetMesh
from tauten.model.mesh.triangle_distance import distances_to_triangles
from tauten.model.numerics import Array, Bools, Ints
from tauten.model.schema import (
    Box,
    Cylinder,
    Difference,
    Everything,
    Facing,
    HalfSpace,
    Intersection,
    NamedGroup,
    NearStl,
    NumberedNodes,
    Region,
    RobotFileError,
    Skin,
    Sphere,
    Union,
)

Part = Literal["node", "boundary triangle", "tetrahedron"]
STL_DISTANCE = 0.25  # of the mean edge on the boundary


class NodeSelector(Protocol):
    """Nodes of a robot that regions select."""

    @property
    def source(self) -> str:
        """The robot file, for errors."""

    @property
    def nodes(self) -> Array:
        """Their positions at rest: (n_nodes, 3) [m]."""

    def select_nodes(self, selection: Region | str, what: str) -> Bools:
        """Which of them a region selects, see `Selector.select_nodes`."""


@dataclass(frozen=True, slots=True)
class Selector:
    """Selects parts of one mesh; made by `make_selector`.

    Attributes:
        source: the robot file, for errors.
        folder: where files that regions name are looked for.
        named: regions by name.
        nodes: (n_nodes, 3) positions at rest [m].
        tets: (e, 4).
        boundary: (t, 3) boundary triangles.
        owner: (t,) the tetrahedron behind each.
        groups: cells that the mesh file names.
        body: name of the body whose mesh this is; "" for a robot's whole mesh.
        ranges: bodies that a whole mesh is made of, by name.
        numbers: of the nodes in the mesh file; None where there are several files or none.
        followers: (n_nodes,) which nodes only follow others, such as those beside a beam, and are not
            selected by `select_nodes`; None: none.
    """

    source: str
    folder: Path
    named: Mapping[str, Region]
    nodes: Array
    tets: Ints
    boundary: Ints
    owner: Ints
    groups: tuple[CellGroup, ...]
    body: str = ""
    ranges: Mapping[str, BodyRange] = field(default_factory=dict)
    numbers: NodeNumbers | None = None
    followers: Bools | None = None

    def nodes_of(self, body: str) -> Bools:
        """Which nodes belong to a body: (n_nodes,) bool."""
        return self._mask(Everything(kind="all", body=body), "node")

    def select_nodes(self, selection: Region | str, what: str) -> Bools:
        """Which nodes a region or the name of one selects: (n_nodes,) bool.

        Raises:
            RobotFileError: none, or a group or file that does not exist.
        """
        return self._found(selection, "node", what)

    def select_triangles(self, selection: Region | str, what: str) -> Bools:
        """Which boundary triangles it selects: (t,) bool; arguments and errors as in `select_nodes`."""
        return self._found(selection, "boundary triangle", what)

    def select_tets(self, selection: Region | str, what: str) -> Bools:
        """Which tetrahedra it selects: (e,) bool; arguments and errors as in `select_nodes`."""
        return self._found(selection, "tetrahedron", what)

    def _found(self, selection: Region | str, part: Part, what: str) -> Bools:
        try:
            chosen = self._mask(selection, part)
        except (ValueError, MeshError) as error:
            raise RobotFileError(f"{self.source}: {what}: {error}") from error
        if part == "node" and self.followers is not None:
            chosen = chosen & ~self.followers
        if not chosen.any():
            free = self.nodes if self.followers is None else self.nodes[~self.followers]
            low, high = free.min(axis=0).round(4), free.max(axis=0).round(4)
            raise RobotFileError(
                f"{self.source}: {what}: no {part} {described(selection, part)}, "
                f"the mesh spans {low.tolist()} to {high.tolist()} m"
            )
        return chosen

    def _mask(self, selection: Region | str, part: Part) -> Bools:
        if isinstance(selection, str):
            return self._mask(self.named[selection], part)
        if selection.body is not None and selection.body != self.body:
            return self._of_body(selection, part)
        if isinstance(selection, Union | Intersection | Difference):
            masks = np.array([self._mask(item, part) for item in selection.of])
            combined: Bools = masks[0] & ~np.asarray(masks[1:].any(axis=0))
            if isinstance(selection, Union):
                combined = np.asarray(masks.any(axis=0))
            if isinstance(selection, Intersection):
                combined = np.asarray(masks.all(axis=0))
            return combined
        if isinstance(selection, Box | Sphere | Cylinder | HalfSpace | Everything):
            return inside(self._centres(part), selection)
        if isinstance(selection, NamedGroup):
            return self._group(selection, part)
        if isinstance(selection, NumberedNodes):
            return self._numbered(selection, part)
        return self._behind(self._triangles(selection), part)

    def _of_body(self, region: Region, part: Part) -> Bools:
        """What a region of one body selects in the whole mesh."""
        assert region.body is not None
        if region.body not in self.ranges:
            known = ", ".join(sorted(self.ranges)) or (self.body or "none")
            raise ValueError(f"body {region.body!r} is not one of the bodies here: {known}")
        of = self.ranges[region.body]
        chosen = np.zeros(len(self._parts(part)), dtype=bool)
        found = of.selector._mask(region, part)
        first = {
            "node": of.first_node, "tetrahedron": of.first_tet,
            "boundary triangle": of.first_triangle,
        }[part]  # fmt: skip
        chosen[first : first + len(found)] = found
        return chosen

    def _parts(self, part: Part) -> Array | Ints:
        """All nodes, tetrahedra or boundary triangles."""
        if part == "node":
            return self.nodes
        return self.tets if part == "tetrahedron" else self.boundary

    def _centres(self, part: Part) -> Array:
        """Positions of the nodes, or centres of triangles or tetrahedra [m]."""
        if part == "node":
            return self.nodes
        centres: Array = self.nodes[self._parts(part)].mean(axis=1)
        return centres

    def _triangles(self, region: Region) -> Bools:
        """Boundary triangles of a region that is defined by them: (t,) bool."""
        corners = self.nodes[self.boundary]  # (t, 3, 3)
        if isinstance(region, Facing):
            wanted = np.array(region.direction) / np.linalg.norm(region.direction)
            least = np.cos(np.radians(region.max_angle_deg))
            facing: Bools = unit_normals(corners) @ wanted >= least
            return facing
        if isinstance(region, NearStl):
            points, triangles = read_triangles(self.folder / region.file)
            surface = UNITS[region.length_unit] * points[triangles]  # (s, 3, 3)
            edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)  # (t, 3)
            reach = region.distance or STL_DISTANCE * float(edges.mean())
            near: Bools = distances_to_triangles(corners.mean(axis=1), surface) <= reach
            return near
        assert isinstance(region, Skin)
        return np.ones(len(self.boundary), dtype=bool)

    def _behind(self, triangles: Bools, part: Part) -> Bools:
        """The nodes of boundary triangles (t,) bool, the tetrahedra behind them, or themselves."""
        if part == "boundary triangle":
            return triangles
        chosen = np.zeros(len(self.nodes if part == "node" else self.tets), dtype=bool)
        chosen[(self.boundary if part == "node" else self.owner)[triangles]] = True
        return chosen

    def _numbered(self, region: NumberedNodes, part: Part) -> Bools:
        """Nodes by their numbers in the mesh file, and the parts all of whose corners are among them."""
        if self.numbers is None:
            raise ValueError(
                "numbers of nodes are those of one mesh file: give the body that they belong to"
            )
        chosen = self.numbers.chosen(np.array(region.numbers, dtype=np.int64))
        if part == "node":
            return chosen
        corners = self.tets if part == "tetrahedron" else self.boundary
        return np.asarray(chosen[corners].all(axis=1))

    def _group(self, region: NamedGroup, part: Part) -> Bools:
        """What a group of the mesh file selects."""
        by_name = {group.name: group for group in self.groups}
        if region.group not in by_name:
            known = ", ".join(repr(name) for name in sorted(by_name)) or "none"
            raise ValueError(f"the mesh file has no group {region.group!r}, its groups are {known}")
        group = by_name[region.group]
        tets = np.zeros(len(self.tets), dtype=bool)
        tets[group.tets] = True
        both = np.sort(np.concatenate([group.triangles, self.boundary]), axis=1)
        _, keys = np.unique(both, axis=0, return_inverse=True)
        wanted, listed = np.split(keys.ravel(), [len(group.triangles)])
        triangles = np.isin(listed, wanted)
        if part == "boundary triangle":
            return triangles | tets[self.owner]
        if part == "tetrahedron":
            return tets | self._behind(triangles, part)
        chosen = np.zeros(len(self.nodes), dtype=bool)
        chosen[self.tets[tets]] = True
        chosen[group.triangles] = True
        return chosen


@dataclass(frozen=True, slots=True)
class BodyRange:
    """Where the mesh of a body, with a selector in its own coordinates, begins in that of its robot."""

    selector: Selector
    first_node: int
    first_tet: int
    first_triangle: int


def make_selector(
    mesh: TetMesh,
    named: Mapping[str, Region],
    source: str,
    body: str = "",
    ranges: Mapping[str, BodyRange] | None = None,
    solid: Bools | None = None,
) -> Selector:
    """A selector on a mesh.

    Args:
        mesh: the mesh.
        named: regions by name.
        source: the robot file, for errors, beside which files that regions name are looked for.
        body: name of the body whose mesh this is.
        ranges: bodies that a whole mesh is made of, by name.
        solid: (e,) which tetrahedra have a boundary; None: all.
    """
    filled = np.arange(len(mesh.tets)) if solid is None else np.flatnonzero(solid)
    return Selector(
        source=source,
        folder=Path(source).parent,
        named=named,
        nodes=mesh.nodes,
        tets=mesh.tets,
        boundary=boundary_triangles(mesh.tets[filled]),
        owner=filled[boundary_owners(mesh.tets[filled])],
        groups=mesh.groups,
        body=body,
        ranges=ranges or {},
        numbers=mesh.numbers,
    )


def inside(points: Array, region: Box | Sphere | Cylinder | HalfSpace | Everything) -> Bools:
    """Which points (m, 3) [m] lie in a region of space, its border included: (m,) bool.

    Borders are exact: choose a region slightly larger where positions are rounded.
    """
    chosen: Bools
    if isinstance(region, Everything):
        chosen = np.ones(len(points), dtype=bool)
    elif isinstance(region, Box):
        chosen = np.all((points >= region.lower) & (points <= region.upper), axis=1)
    elif isinstance(region, Sphere):
        chosen = np.linalg.norm(points - region.centre, axis=1) <= region.radius
    elif isinstance(region, HalfSpace):
        chosen = (points - region.point) @ np.array(region.normal) >= 0.0
    else:
        axis = np.subtract(region.end, region.start)
        share = (points - region.start) @ axis / (axis @ axis)  # (m,)
        radial = points - region.start - share[:, None] * axis
        chosen = (share >= 0.0) & (share <= 1.0)
        chosen &= np.linalg.norm(radial, axis=1) <= region.radius
    return chosen


def described(selection: Region | str, part: Part) -> str:
    """A region in the words of an error."""
    if isinstance(selection, str):
        return f"in the region {selection!r}"
    where = "in" if part == "node" else "has its centre in"
    if isinstance(selection, Box):
        return f"{where} {selection.lower} to {selection.upper}"
    if isinstance(selection, Intersection):
        return " and ".join(described(item, part) for item in selection.of)
    if isinstance(selection, Facing):
        return f"points along {selection.direction} within {selection.max_angle_deg:g} degrees"
    if isinstance(selection, NearStl):
        return f"near the surface in {selection.file}"
    if isinstance(selection, NamedGroup):
        return f"in the group {selection.group!r}"
    if isinstance(selection, Sphere):
        return f"{where} the sphere of radius {selection.radius:g} m around {selection.centre}"
    if isinstance(selection, Cylinder):
        return f"{where} the cylinder from {selection.start} to {selection.end}"
    if isinstance(selection, NumberedNodes):
        return f"has all of its corners among the {len(selection.numbers)} nodes of the region"
    return f"in this {selection.kind}"  # type: ignore[attr-defined]
