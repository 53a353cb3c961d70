"""From a robot file to a robot."""

from __future__ import annotations

import hashlib
from importlib import resources
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from tauten.model.body import Material
from tauten.model.contact import ContactPair, ContactSet
from tauten.model.limits import limits_of
from tauten.model.load.beams import build_beam_robot, read_structure
from tauten.model.load.elements import build_body, place_elements, place_viscosity
from tauten.model.mesh import (
    QuadraticMesh,
    TetMesh,
    boundary_triangles,
    in_box,
    read_mesh,
    read_quadratic_mesh,
    spread_points,
)
from tauten.model.numerics import Bools, Ints, make_factorisation
from tauten.model.points import (
    Cable,
    CableSet,
    MaterialPoints,
    attach,
    effector_matrix,
    make_cables,
)
from tauten.model.robot import Robot, names_of
from tauten.model.schema import (
    BeamConfig,
    Changes,
    MaterialSettings,
    RobotConfig,
    RobotFileError,
    Section,
    SurfaceSettings,
    model_tables,
    read_toml,
    validated,
)
from tauten.model.system import integration_of, make_pattern
from tauten.model.tetra import BodyParts, TetRobot

C = TypeVar("C", RobotConfig, BeamConfig)
M = TypeVar("M", bound=MaterialSettings)


def robot_path(name_or_path: str | Path) -> Path:
    """The robot file: a path as it is, a bare name looked up among the shipped robots.

    Raises:
        RobotFileError: neither exists.
    """
    path = Path(name_or_path)
    if path.suffix == ".toml":
        return path
    folder = Path(str(resources.files("tauten.model.robots")))
    shipped = folder / f"{name_or_path}.toml"
    if not shipped.is_file():
        names = ", ".join(sorted(item.stem for item in folder.glob("*.toml")))
        raise RobotFileError(
            f"no robot {str(name_or_path)!r}: give a path to a .toml file or one of {names}"
        )
    return shipped


def load_robot(
    name_or_path: str | Path,
    rate: float | None = None,
    refinements: int = 0,
    factorisation: str | None = None,
    young_scale: float = 1.0,
) -> Robot:
    """Load a robot by name ("finger") or from a robot file.

    Args:
        name_or_path: name of a shipped robot, or a path that ends in .toml.
        rate: another control rate than the file's [Hz]; the time step is 1 / rate.
        refinements: how often every tetrahedron is cut into eight, 0 to 4.
        factorisation: another back end than the file's.
        young_scale: Young's modulus as a multiple of the file's, for robots that are not as modelled.

    Raises:
        RobotFileError: a field of the file or an argument is not allowed, or does not fit the mesh.
        MeshError: the mesh cannot be used.
    """
    path = robot_path(name_or_path)
    given = {
        "rate": rate,
        "refinements": refinements,
        "factorisation": factorisation,
        "young_scale": young_scale,
    }
    changes = validated(Changes, given, f"{path}: load_robot")
    return make_robot(read_toml(path), path, changes)


def make_robot(contents: dict[str, Any], path: Path, changes: Changes) -> Robot:
    """Build the robot of a robot file that has been read.

    Args:
        contents: of the file, not validated; tables of other layers are left to them.
        path: the file, for errors and for the files beside it.
        changes: what is changed in it.

    Raises:
        RobotFileError, MeshError: see `load_robot`.
    """
    raw = model_tables(contents)
    if "beams" in raw:
        beams = changed(validated(BeamConfig, raw, path), changes, path)
        if changes.refinements:
            raise RobotFileError(
                f"{path}: refinements is {changes.refinements}, beams are not refined"
            )
        return build_beam_robot(beams, read_structure(path.parent / beams.beams.file), str(path))
    config = changed(validated(RobotConfig, raw, path), changes, path)
    read = read_quadratic_mesh if config.mesh.element == "quadratic" else read_mesh
    mesh: TetMesh | QuadraticMesh = read(path.parent / config.mesh.file, config.mesh.length_unit)
    for _ in range(changes.refinements):
        mesh = mesh.refine()
    return build_robot(config, mesh, str(path))


def changed(config: C, changes: Changes, path: Path) -> C:
    """A robot file with what the caller of `load_robot` changes in it.

    Args:
        config: the file.
        changes: as given to `load_robot`.
        path: of the file, for errors.

    Raises:
        RobotFileError: the scaled Young's modulus is not allowed.
    """
    sections: dict[str, Section] = {}
    if changes.rate is not None:
        sections["controller"] = config.controller.model_copy(update={"rate": changes.rate})
    if changes.factorisation is not None:
        scheme = {"factorisation": changes.factorisation}
        sections["integration"] = config.integration.model_copy(update=scheme)
    if changes.young_scale != 1.0:
        what = f"{path}: scaled by {changes.young_scale:g}"
        sections["material"] = scaled(config.material, changes.young_scale, what, "material")
    config = config.model_copy(update=sections)
    if changes.young_scale != 1.0 and isinstance(config, RobotConfig):
        materials = tuple(
            scaled(item, changes.young_scale, what, f"materials.{index}")
            for index, item in enumerate(config.materials)
        )
        config = config.model_copy(update={"materials": materials})
    return config


def scaled(material: M, factor: float, source: str, prefix: str) -> M:
    """A material `factor` times as stiff.

    Args:
        material: the settings.
        factor: of Young's modulus, with which the whole law scales.
        source: for errors.
        prefix: name of the table, for errors.

    Raises:
        RobotFileError: the scaled Young's modulus is not allowed.
    """
    contents = material.model_dump()
    contents["young_modulus"] *= factor
    return validated(type(material), contents, source, prefix)


def build_robot(config: RobotConfig, mesh: TetMesh | QuadraticMesh, source: str) -> TetRobot:
    """Build a robot from a validated robot file and a checked mesh.

    Args:
        config: the robot file.
        mesh: the body.
        source: the robot file's path, for errors.

    Raises:
        RobotFileError: a region is empty or a point lies outside the mesh; the text names `source`.
    """
    settings = config.material
    material = Material(settings.young_modulus, settings.poisson_ratio, settings.density)
    body = build_body(config, mesh, source)
    fixed = fixed_nodes(config, body.mesh, source)
    cables = build_cables(config, body.mesh, source)
    effectors = build_effectors(config, body.mesh, source)
    pattern = make_pattern(fixed, [*(part.nodes for part in body.domains), cables.nodes])
    contacts = build_contacts(config, body.mesh, source)
    mass = body.mass[~fixed]  # (n / 3,)
    elements = place_elements(body, pattern)
    scheme = config.integration
    return TetRobot(
        names=names_of(config),
        digest=digest(body, material, fixed, cables, contacts),
        gravity=np.array(config.gravity),
        tolerance=config.contact.tolerance,
        mesh=body.mesh,
        material=material,
        integration=integration_of(config),
        pattern=pattern,
        elements=elements,
        viscosity=place_viscosity(body, elements),
        mass=np.repeat(mass, 3),
        load=np.outer(mass, config.gravity).ravel(),
        cables=cables,
        cable_slot=pattern.blocks(cables.nodes),
        limits=limits_of(config.cables),
        effectors=effectors,
        H_e=effector_matrix(effectors, pattern.dof, pattern.n),
        contacts=contacts,
        factorisation=make_factorisation(pattern.indptr, pattern.indices, scheme.factorisation),
    )


def fixed_nodes(config: RobotConfig, mesh: TetMesh, source: str) -> Bools:
    """Nodes in any of the `fixed` boxes: (n_nodes,) bool.

    Args:
        config: the robot file.
        mesh: the body.
        source: the robot file's path, for errors.

    Raises:
        RobotFileError: a box without nodes, or nodes that do not hold the body or hold all of it.
    """
    fixed = np.zeros(len(mesh.nodes), dtype=bool)
    for index, box in enumerate(config.fixed):
        chosen = in_box(mesh.nodes, box)
        if not chosen.any():
            low, high = mesh.nodes.min(axis=0).round(4), mesh.nodes.max(axis=0).round(4)
            raise RobotFileError(
                f"{source}: fixed.{index}: no node in {box.lower} to {box.upper}, "
                f"the mesh spans {low.tolist()} to {high.tolist()} m"
            )
        fixed |= chosen
    if np.linalg.matrix_rank(mesh.nodes[fixed] - mesh.nodes[fixed][0], tol=1e-6 * mesh.size) < 2:
        raise RobotFileError(f"{source}: fixed: needs three nodes not on a line to hold the robot")
    if fixed.all():
        raise RobotFileError(f"{source}: fixed: holds every node, no node can move")
    return fixed


def build_cables(config: RobotConfig, mesh: TetMesh, source: str) -> CableSet:
    """Cables attached to the mesh.

    Args:
        config: the robot file.
        mesh: the body.
        source: the robot file's path, for errors.
    """
    cables = []
    for index, cable in enumerate(config.cables):
        what = f"{source}: cables.{index}.points"
        points = place_points(mesh, cable.points, what, cable.max_outside)
        pull_point = None if cable.pull_point is None else np.array(cable.pull_point)
        route = np.array(cable.points if pull_point is None else [pull_point, *cable.points])
        short = np.flatnonzero(np.linalg.norm(np.diff(route, axis=0), axis=1) < 1e-9)
        if len(short):
            raise RobotFileError(f"{what}: points {short[0]} and {short[0] + 1} coincide")
        cables.append(Cable(cable.name, points, pull_point))
    return make_cables(cables, mesh.nodes)


def build_effectors(config: RobotConfig, mesh: TetMesh, source: str) -> MaterialPoints:
    """Effectors attached to the mesh.

    Args:
        config: the robot file.
        mesh: the body.
        source: the robot file's path, for errors.
    """
    parts = [
        place_points(mesh, [item.point], f"{source}: effectors.{index}.point", item.max_outside)
        for index, item in enumerate(config.effectors)
    ]
    return MaterialPoints(
        np.concatenate([part.nodes for part in parts]),
        np.concatenate([part.weights for part in parts]),
    )


def place_points(
    mesh: TetMesh, points: list[tuple[float, float, float]], what: str, slack: float
) -> MaterialPoints:
    """`attach`, with its error as a RobotFileError.

    Args:
        mesh: the body.
        points: rest positions [m].
        what: the field they come from, for errors.
        slack: how far outside the body a point may lie [m].
    """
    try:
        return attach(mesh, np.array(points), what, slack)
    except ValueError as error:
        raise RobotFileError(str(error)) from error


def select_surface(settings: SurfaceSettings, mesh: TetMesh, boundary: Ints, source: str) -> Ints:
    """Boundary triangles of a surface of the robot file: (t, 3).

    Args:
        settings: of the surface.
        mesh: the body.
        boundary: (b, 3) all boundary triangles.
        source: the robot file's path, for errors.

    Raises:
        RobotFileError: there are none.
    """
    corners = mesh.nodes[boundary]  # (t, 3, 3)
    chosen = in_box(corners.mean(axis=1), settings.box)
    if settings.normal is not None:
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        wanted = np.array(settings.normal) / np.linalg.norm(settings.normal)
        chosen &= normals @ wanted >= np.cos(np.radians(settings.max_angle_deg))
    if not chosen.any():
        raise RobotFileError(
            f"{source}: surfaces.{settings.name}: no boundary triangle has its centre in "
            f"{settings.box.lower} to {settings.box.upper}"
            + (f" and points along {settings.normal}" if settings.normal else "")
        )
    return boundary[chosen]


def build_contacts(config: RobotConfig, mesh: TetMesh, source: str) -> ContactSet:
    """Candidates and target surfaces of every contact.

    Args:
        config: the robot file.
        mesh: the body.
        source: the robot file's path, for errors.
    """
    boundary = boundary_triangles(mesh.tets)
    surfaces = {s.name: select_surface(s, mesh, boundary, source) for s in config.surfaces}
    pairs = []
    for contact in config.contacts:
        try:
            nodes, weights = spread_points(mesh.nodes, surfaces[contact.candidates], contact.points)
        except ValueError as error:
            raise RobotFileError(f"{source}: contacts.{contact.candidates}: {error}") from error
        name = f"{contact.candidates} on {contact.against}"
        pairs.append(ContactPair(name, nodes, weights, surfaces[contact.against]))
    return ContactSet(pairs, len(mesh.nodes), config.contact.alarm_distance)


def digest(
    body: BodyParts, material: Material, fixed: Bools, cables: CableSet, contacts: ContactSet
) -> str:
    """SHA-256 of everything that contact forces depend on, except loads and control.

    Args:
        body: the body.
        material: of the body.
        fixed: (n_nodes,) which nodes do not move.
        cables: of the robot.
        contacts: the contact pairs.
    """
    hasher = hashlib.sha256()
    arrays: list[NDArray[Any]] = [
        body.mesh.nodes,
        body.mesh.tets,
        fixed,
        cables.owner,
        cables.nodes,
        cables.weights,
        cables.offset,
    ]
    for pair in contacts.pairs:
        arrays += [pair.nodes, pair.weights, pair.triangles]
    for array in arrays:
        hasher.update(np.round(np.ascontiguousarray(array, dtype=float), 12).tobytes())
    hasher.update(repr(material).encode())
    if not body.is_plain:  # plain bodies keep the digest their bases were made with
        hasher.update(repr(body.laws).encode())
        for part in body.domains:
            hasher.update(part.nodes.tobytes() + part.law.tobytes())
    return hasher.hexdigest()
