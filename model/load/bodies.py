"""Bodies of a robot file: read, placed, made of their materials and joined into one mesh."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from tauten.model.body import Body
from tauten.model.contact import ContactSet
from tauten.model.effectors import Effectors
from tauten.model.load.beam_bodies import CORNERS, BeamPart, beam_network, build_beam
from tauten.model.mesh import (
    BodyRange,
    MeshError,
    QuadraticMesh,
    Selector,
    TetMesh,
    join_meshes,
    make_selector,
    quadratic_mesh,
    read_mesh,
    read_quadratic_mesh,
    require_size,
)
from tauten.model.numerics import Array, Bools, Ints
from tauten.model.parts import Placement
from tauten.model.robot import Robot
from tauten.model.schema import (
    BeamNetwork,
    BodySettings,
    Disc,
    Region,
    RobotConfig,
    RobotFileError,
    digests_of_fewer,
    robot_digest,
)
from tauten.model.signals import actuators_of, limits_of
from tauten.model.tetra import BodyParts, body_parts, join_bodies

B = TypeVar("B", bound=Body)
P = TypeVar("P")

AnyMesh = TetMesh | QuadraticMesh
AT_DISC = 1e-9  # m, distance of a point that is on a disc
Shape = AnyMesh | BeamNetwork  # of a body, in its own coordinates


@dataclass(frozen=True, slots=True)
class Bodies:
    """All bodies of a robot as one.

    Attributes:
        parts: mesh, elements and masses.
        selector: of regions; it leaves the nodes beside those of beams out.
        touching: the same with the surfaces of beams, which only contacts know.
        fixed: (n_nodes,) which nodes the regions of `fixed` hold.
        rigid: nodes of each rigid body, as (n_nodes,) bool, by its name.
        beams: bodies that are beams.
    """

    parts: BodyParts
    selector: Selector
    touching: Selector
    fixed: Bools
    rigid: dict[str, Bools]
    beams: list[BeamPart]

    @property
    def beam_nodes(self) -> Ints:
        """Nodes of all beams, without the corners beside them: (b,)."""
        return np.concatenate([np.zeros(0, np.int64), *(part.nodes for part in self.beams)])

    def of_beams(self, mesh: TetMesh) -> Bools:
        """Which tetrahedra of some or all of the robot's stand for nodes of beams: (e,)."""
        return np.isin(mesh.tets[:, 0], self.beam_nodes)

    @property
    def followers(self) -> Bools:
        """Which nodes only follow the node of a beam, as corners and surface: (n_nodes,) bool."""
        nodes = np.zeros(len(self.parts.mesh.nodes), dtype=bool)
        nodes[self.beam_nodes] = True
        return self.with_corners(nodes) & ~nodes

    def rigid_nodes(self, chosen: Ints) -> Ints:
        """Nodes (m,) with the corners of those of beams among them, which know their rotation: (m + 3 b,)."""
        of_beams = np.intersect1d(chosen, self.beam_nodes)
        corners = of_beams[:, None] + np.arange(CORNERS)
        return np.union1d(chosen, corners.ravel())

    def select_nodes(self, region: Region | str, what: str) -> Bools:
        """Which nodes a region selects, of beams with their corners or neither: (n_nodes,) bool."""
        return self.with_corners(self.selector.select_nodes(region, what))

    def with_corners(self, chosen: Bools) -> Bools:
        """The same nodes (n_nodes,), with the corners of those that are nodes of beams and no others."""
        result = chosen.copy()
        for part in self.beams:
            result[part.nodes[:, None] + np.arange(CORNERS)] = chosen[part.nodes, None]
            result[part.followers] = chosen[part.nodes[part.owners]]
        return result

    def corners_of(self, node: int) -> Ints:
        """A node of a beam and all that moves with it, from the node on: (4 + c,)."""
        part = next(one for one in self.beams if node in one.nodes)
        number = (node - part.nodes[0]) // CORNERS
        return np.concatenate([node + np.arange(CORNERS), part.followers[part.owners == number]])

    def nearest_disc(self, point: Array) -> tuple[float, int, str] | None:
        """Of the disc nearest to a point (3,) its distance [m], node and name; None: there is none."""
        found = [
            (
                outside(disc, point - part.body.nodes[disc.node]),
                int(part.nodes[disc.node]),
                disc.name,
            )
            for part in self.beams
            for disc in part.discs
        ]
        return min(found, default=None)


def outside(disc: Disc, away: Array) -> float:
    """Distance [m] of a point, `away` (3,) from the disc's node [m], from a disc in metres; zero inside."""
    axis = np.array(disc.axis)
    height = float(away @ axis)
    beyond = max(abs(height) - 0.5 * disc.thickness, 0.0)
    aside = max(float(np.linalg.norm(away - height * axis)) - disc.radius, 0.0)
    return float(np.hypot(beyond, aside))


def mesh_files(config: RobotConfig, path: Path) -> list[Path | None]:
    """The mesh file of each body of the robot file at a path, None of one that is made of beams.

    Raises:
        MeshError: one is not there.
    """
    files: list[Path | None] = []
    for index, body in enumerate(config.all_bodies):
        file = path.parent / body.mesh.file if body.mesh else None
        if file is not None and not file.is_file():
            of = f"bodies.{index}." if config.bodies else ""
            raise MeshError(f"{path}: {of}mesh.file: no such file {str(file)!r}")
        files.append(file)
    return files


def read_bodies(config: RobotConfig, path: Path, refinements: int = 0) -> list[Shape]:
    """The shapes of the bodies as they are in their files [m], a mesh file used twice read once.

    A refinement cuts every tetrahedron into eight, every beam into two.

    Raises:
        MeshError: a mesh cannot be used.
        RobotFileError: a file of beams cannot be used.
    """
    read: dict[str, AnyMesh] = {}
    for index, (body, file) in enumerate(
        zip(config.all_bodies, mesh_files(config, path), strict=True)
    ):
        settings = body.mesh
        if settings is None or file is None:
            continue
        of = f"bodies.{index}." if config.bodies else ""
        key = settings.model_dump_json()
        if key not in read:
            reader = read_quadratic_mesh if settings.element == "quadratic" else read_mesh
            read[key] = reader(file, settings.length_unit, not config.needs_boundary)
            for _ in range(refinements):
                read[key] = read[key].refine()
        fields = f"{of}mesh.length_unit" + (f" and {of}scale" if of else "")
        require_size(read[key].nodes, body.scale, str(file), fields)
    return [
        read[body.mesh.model_dump_json()]
        if body.mesh
        else beam_network(config, body, str(path), refinements)
        for body in config.all_bodies
    ]


def contents_of(config: RobotConfig, shapes: Sequence[Shape]) -> list[bytes]:
    """The shapes as bytes for the robot's digest; of beams without a file the number of their nodes."""
    found = []
    for body, shape in zip(config.all_bodies, shapes, strict=True):
        if not isinstance(shape, BeamNetwork):
            found.append(content_of(shape))
        elif body.beam is not None and body.beam.file is not None:
            found.append(shape.model_dump_json(exclude_defaults=True).encode())
        else:
            found.append(str(len(shape.nodes)).encode())
    return found


def robot_with(
    config: RobotConfig,
    shapes: Sequence[Shape],
    source: str,
    body: B,
    effectors: Effectors[P],
    contacts: ContactSet,
    vertices: P,
) -> Robot[B]:
    """The robot of a file, with what its kind of body has of its own: effectors and contacts."""
    folder = Path(source).parent
    digest = robot_digest(config, contents_of(config, shapes), folder)
    return Robot(
        name=config.name,
        frame=config.frame,
        digest=digest,
        tolerance=config.contact.tolerance,
        actuators=actuators_of(config),
        limits=limits_of(config, source),
        effectors=effectors,
        contacts=contacts,
        vertices=vertices,
        body=body,
        digests_of_fewer=digests_of_fewer(digest, config, folder),
    )


def content_of(mesh: AnyMesh) -> bytes:
    """Nodes, elements and groups of a mesh."""
    parts = [(mesh.nodes + 0.0).tobytes(), mesh.tets.astype("<i8").tobytes()]  # + 0.0: without −0.0
    for group in mesh.groups:
        cells = (group.tets, group.triangles)
        parts += [group.name.encode(), *(part.astype("<i8").tobytes() for part in cells)]
    numbers = mesh.numbers
    if numbers is not None and len(numbers.of_file) <= numbers.of_file[-1]:  # some are left out
        parts.append(numbers.of_file.astype("<i8").tobytes())
    return b"".join(parts)


def build_bodies(config: RobotConfig, shapes: Sequence[Shape], source: str) -> Bodies:
    """The bodies of a robot file, made of its shapes, each in its place and with the laws of its regions.

    Raises:
        RobotFileError: a region that selects nothing, elements that do not fit a mesh, a beam without length.
    """
    named, parts, ranges = config.named_regions(), [], {}
    held: list[Bools] = []
    beams: list[BeamPart] = []
    solid: list[Bools] = []
    counts = np.zeros(3, dtype=np.int64)  # nodes, tetrahedra, boundary triangles before the body
    for index, (body, shape) in enumerate(zip(config.all_bodies, shapes, strict=True)):
        prefix = f"bodies.{index}." if config.bodies else ""
        own: AnyMesh
        if isinstance(shape, BeamNetwork):
            part, own, beam = build_beam(config, body, shape, source, prefix)
            beams.append(beam.moved(int(counts[0])))
        else:
            own = scaled_mesh(shape, body)
            place = Placement.of(body.rotation, body.position)
            there = replace(own, nodes=place.points(own.nodes))
            part = build_body(body, own, there, named, source, prefix)
        unmoved = own.split() if isinstance(own, QuadraticMesh) else own
        solid.append(np.full(len(unmoved.tets), body.beam is None))
        selector = make_selector(unmoved, named, source, body=body.name, solid=solid[-1])
        chosen = np.zeros(len(unmoved.nodes), dtype=bool)
        for i, region in enumerate(body.fixed):
            chosen |= selector.select_nodes(region, f"{prefix}fixed.{i}")
        parts.append(part)
        held.append(chosen)
        sizes = np.array([len(chosen), len(unmoved.tets), len(selector.boundary)])
        ranges[body.name] = BodyRange(selector, *counts.tolist())
        counts = counts + sizes
    joined = join_bodies(parts, join_meshes([part.mesh for part in parts]))
    whole = make_selector(joined.mesh, named, source, ranges=ranges, solid=np.concatenate(solid))
    fixed = np.concatenate(held)
    for i, region in enumerate(config.fixed):
        fixed |= whole.select_nodes(region, f"fixed.{i}")
    rigid = {body.name: whole.nodes_of(body.name) for body in config.all_bodies if body.rigid}
    touching = with_beams(whole, beams) if beams else whole
    bodies = Bodies(joined, whole, touching, fixed, rigid, beams)
    selector = replace(whole, followers=bodies.followers) if beams else whole
    return replace(bodies, selector=selector, fixed=bodies.with_corners(fixed))


def with_beams(whole: Selector, beams: Sequence[BeamPart]) -> Selector:
    """A selector that knows the surfaces of beams besides."""
    ranges, triangles, owners = {}, [], []
    of_beams = {part.name: part for part in beams}
    count = 0
    for name, of in whole.ranges.items():
        own = of.selector
        if name in of_beams:
            part = of_beams[name]
            owner = part.owners[part.triangles.max(axis=1) - part.first_follower]
            own = replace(own, boundary=part.triangles - of.first_node, owner=owner)
        ranges[name] = replace(of, selector=own, first_triangle=count)
        triangles.append(own.boundary + of.first_node)
        owners.append(own.owner + of.first_tet)
        count += len(own.boundary)
    return replace(
        whole, boundary=np.concatenate(triangles), owner=np.concatenate(owners), ranges=ranges
    )


def scaled_mesh(mesh: AnyMesh, body: BodySettings) -> AnyMesh:
    """A mesh in a body's own coordinates, with midpoints where its elements have them."""
    if body.mesh is not None and body.mesh.element == "quadratic" and isinstance(mesh, TetMesh):
        mesh = quadratic_mesh(mesh)
    return mesh if body.scale == 1.0 else replace(mesh, nodes=body.scale * mesh.nodes)


def build_body(
    body: BodySettings,
    own: AnyMesh,
    mesh: AnyMesh,
    named: Mapping[str, Region],
    source: str,
    prefix: str,
) -> BodyParts:
    """The domains of one body, each with the law of its region, and its masses.

    Smoothed elements average within a law, so that regions with equal laws are one.

    Raises:
        RobotFileError: a region of `materials` without elements, or elements that do not fit the mesh.
    """
    assert body.material is not None and body.mesh is not None
    items = (body.material, *body.materials)
    materials = [(item.elastic_law(), item.viscous()) for item in items]
    different = list(dict.fromkeys(materials))
    laws, viscosities = map(list, zip(*different, strict=True))
    law = np.zeros(len(mesh.tets), dtype=np.int64)
    density = np.full(len(mesh.tets), body.material.density)
    if body.materials:
        corners = own.corners if isinstance(own, QuadraticMesh) else own
        selector = make_selector(corners, named, source, body=body.name)
        for index, item in enumerate(body.materials):
            chosen = selector.select_tets(item.region, f"{prefix}materials.{index}.region")
            law[chosen], density[chosen] = different.index(materials[index + 1]), item.density
    try:
        parts = body_parts(mesh, body.mesh.element, laws, law, density, viscosities)
    except ValueError as error:
        raise RobotFileError(f"{source}: {prefix}mesh: {error}") from error
    total = body.material.total_mass
    if total is None:
        return parts
    if body.material.mass == "nodes":
        even = np.full(len(parts.mass), total / len(parts.mass))
        return replace(parts, mass=even, lumpings=[])
    share = total / parts.mass.sum()
    lumpings = [replace(one, excess=share * one.excess) for one in parts.lumpings]
    return replace(parts, mass=share * parts.mass, lumpings=lumpings)
