"""From a robot file to a robot."""

from __future__ import annotations

import os
import shlex
from collections.abc import Sequence
from dataclasses import replace
from functools import cache, partial
from importlib import resources
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from tauten.model.actuators import coupled_nodes, nodal_curvature
from tauten.model.constraints import ConstrainedBody
from tauten.model.load.actuators import build_actuators
from tauten.model.load.beams import build_beam_robot, of_beams_alone, touched_triangles
from tauten.model.load.bodies import Bodies, Shape, build_bodies, read_bodies, robot_with
from tauten.model.load.constraints import build_constraints, constrained
from tauten.model.load.contacts import contact_set, contact_surfaces
from tauten.model.load.effectors import build_nodal_effectors
from tauten.model.load.held import groups_of_bodies, loose_nodes
from tauten.model.load.parts import LoadedPart, body_surface, build_parts
from tauten.model.load.places import MeshPlaces
from tauten.model.numerics import Ints, make_factorisation
from tauten.model.parts import PartsBody
from tauten.model.points import points_at
from tauten.model.robot import Robot
from tauten.model.schema import (
    Changes,
    MaterialSettings,
    PartRobotConfig,
    PartsConfig,
    RobotConfig,
    RobotFileError,
    SectionSettings,
    model_tables,
    read_toml,
    validated,
)
from tauten.model.system import free_dof, integration_of, make_pattern
from tauten.model.tetra import (
    NodalBody,
    Tetrahedra,
    deforming_domains,
    make_solid,
    make_viscoelasticity,
)

M = TypeVar("M", bound=MaterialSettings)


def robot_path(name_or_path: str | Path) -> Path:
    """The robot file: a path as it is, a bare name looked up among the shipped robots.

    Raises:
        TypeError, RobotFileError: no text or path; neither exists.
    """
    if not isinstance(name_or_path, str | os.PathLike):
        raise TypeError(
            "expected the name of a shipped robot or the path of a robot file, found "
            f"{type(name_or_path).__name__}"
        )
    path = Path(name_or_path)
    if path.suffix == ".toml":
        return path
    shipped = {item.stem: item for item in sorted(shipped_folder().glob("*.toml"))}
    if (name := str(name_or_path)) not in shipped:
        inside = path / f"{path.name}.toml"  # as `tauten new` writes it
        if os.path.isfile(inside):  # noqa: PTH113  (pathlib raises for "a" * 5000)
            raise RobotFileError(f"{path}: is a folder; its robot file is {inside}")
        raise RobotFileError(
            f"no robot {name[:40]!r}: give a path to a .toml file or one of {', '.join(shipped)}"
        )
    return shipped[name]


def shipped_folder() -> Path:
    """Where the files of the shipped robots are."""
    return Path(str(resources.files("tauten.model.robots")))


def is_shipped(path: Path) -> bool:
    """Whether a file is one of those of the shipped robots."""
    return path.resolve().parent == shipped_folder().resolve()


def command_name(path: Path) -> str:
    """What a command is given for the robot file at `path`: a shipped robot's name, otherwise the path."""
    return path.stem if is_shipped(path) else shlex.quote(str(path))


def load_robot(
    name_or_path: str | Path,
    rate: float | None = None,
    refinements: int = 0,
    factorisation: str | None = None,
    young_scale: float = 1.0,
    threads: int | None = None,
) -> Robot:
    """Load a robot by name ("finger") or from a robot file.

    Args:
        name_or_path: name of a shipped robot, or a path that ends in .toml.
        rate: another control rate than the file's [Hz]; the time step is 1 / rate.
        refinements: how often every tetrahedron is cut into eight, 0 to 4.
        factorisation: another back end than the file's.
        young_scale: Young's modulus as a multiple of the file's, for robots that are not as modelled.
        threads: of the sparse factorisation in place of the file's, by default 1; see `make_factorisation`.

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
        "threads": threads,
    }
    changes = validated(Changes, given, f"{path}: load_robot")
    return make_robot(read_toml(path), path, changes)


def make_robot(contents: dict[str, Any], path: Path, changes: Changes) -> Robot:
    """Build the robot of a robot file that has been read but not validated, with changes in it.

    Tables of other layers are left to them.

    Raises:
        RobotFileError, MeshError: see `load_robot`.
    """
    raw = model_tables(contents)
    if "parts" in raw:
        return make_parts(contents, path, changes)
    return make_part(contents, path, changes).robot


def make_parts(contents: dict[str, Any], path: Path, changes: Changes) -> Robot[PartsBody]:
    """`make_robot` of a robot file with parts."""
    config = validated(PartsConfig, model_tables(contents), path)
    if changes.rate is not None:
        period = config.controller.model_copy(update={"rate": changes.rate})
        config = config.model_copy(update={"controller": period})
    own = changes.model_copy(update={"rate": config.controller.rate})

    @cache
    def read(name: str) -> LoadedPart:
        file = part_path(name, path)
        if not file.exists():
            raise RobotFileError(f"{path}: parts: robot: no such file {name!r}")
        return make_part(read_toml(file), file, own, PartRobotConfig)

    return build_parts(config, read, str(path))


def part_path(name: str, beside: Path) -> Path:
    """The robot file of a part, relative to the one `beside` it that names it, or that of a shipped robot.

    Raises:
        RobotFileError: it does not exist.
    """
    path = robot_path(name)
    return beside.parent / path if name.endswith(".toml") else path


def load_part(contents: dict[str, Any], path: Path) -> LoadedPart:
    """A robot without parts from the contents of a file, not validated; it may lack actuators and effectors.

    Raises:
        RobotFileError, MeshError: see `load_robot`.
    """
    return make_part(contents, path, Changes(), PartRobotConfig)


def make_part(
    contents: dict[str, Any], path: Path, changes: Changes, kind: type[RobotConfig] = RobotConfig
) -> LoadedPart:
    """Build a robot that has no parts of its own, with the surfaces that its file names.

    Raises:
        RobotFileError, MeshError: see `load_robot`.
    """
    raw = model_tables(contents)
    if "parts" in raw:
        raise RobotFileError(f"{path}: parts: a part of a robot has no parts of its own")
    file = validated(kind, raw, path)
    config = changed(file, changes, path)
    shapes = read_bodies(config, path, changes.refinements)
    bodies = build_bodies(config, shapes, str(path))
    surface = partial(body_surface, bodies.touching, str(path))
    if of_beams_alone(config):
        surface = partial(touched_surface, bodies, str(path))
    return LoadedPart(robot_of(config, shapes, bodies, str(path)), surface, file)


def touched_surface(bodies: Bodies, source: str, name: str | None) -> Ints:
    """`body_surface` of a robot of beams alone, whose vertices are those that may touch."""
    return touched_triangles(bodies, body_surface(bodies.touching, source, name))


def changed(config: RobotConfig, changes: Changes, path: Path) -> RobotConfig:
    """A robot file with what the caller of `load_robot` changes in it.

    Raises:
        RobotFileError: the scaled Young's modulus is not allowed.
    """
    update: dict[str, Any] = {}
    if changes.rate is not None:
        update["controller"] = config.controller.model_copy(update={"rate": changes.rate})
    solver = {"factorisation": changes.factorisation, "threads": changes.threads}
    given = {name: value for name, value in solver.items() if value is not None}
    if given:
        update["integration"] = config.integration.model_copy(update=given)
    if changes.young_scale != 1.0:
        what = f"{path}: scaled by {changes.young_scale:g}"
        stiffer = partial(scaled, factor=changes.young_scale, source=what)
        if config.material is not None:
            update["material"] = stiffer(config.material, prefix="material")
        update["materials"] = tuple(
            stiffer(item, prefix=f"materials.{index}")
            for index, item in enumerate(config.materials)
        )
        update["bodies"] = tuple(
            body.model_copy(
                update={
                    "material": body.material
                    and stiffer(body.material, prefix=f"bodies.{b}.material"),
                    "materials": tuple(
                        stiffer(item, prefix=f"bodies.{b}.materials.{index}")
                        for index, item in enumerate(body.materials)
                    ),
                }
            )
            for b, body in enumerate(config.bodies)
        )
        update["profiles"] = tuple(
            item.scaled(changes.young_scale) if isinstance(item, SectionSettings) else item
            for item in config.profiles
        )
    return config.model_copy(update=update)


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


def build_robot(config: RobotConfig, shapes: Shape | Sequence[Shape], source: str) -> Robot:
    """Build a robot from a validated robot file and the checked mesh or beams of each of its bodies.

    Raises:
        RobotFileError: a region is empty or a point lies outside the mesh; the text names `source`.
    """
    every = shapes if isinstance(shapes, Sequence) else [shapes]
    return robot_of(config, every, build_bodies(config, every, source), source)


def robot_of(config: RobotConfig, shapes: Sequence[Shape], bodies: Bodies, source: str) -> Robot:
    """`build_robot` where the bodies are built."""
    body, fixed = bodies.parts, bodies.fixed
    constraints = build_constraints(config, bodies)
    of_body, group = groups_of_bodies(bodies, constraints)
    loose = loose_nodes(config, bodies, constraints, (of_body, group))
    if of_beams_alone(config):
        return build_beam_robot(config, shapes, bodies, group[of_body], source)
    places = MeshPlaces(bodies, config.extrapolate_from)
    actuators = build_actuators(config, places, free_dof(fixed))
    moving = deforming_domains(body.domains, constraints.carriers(fixed))
    pattern = make_pattern(fixed, [*(part.nodes for part in moving), *coupled_nodes(actuators)])
    surfaces = contact_surfaces(config, bodies.touching)
    contacts = contact_set(config, body.mesh.nodes, surfaces, group[of_body], source)
    mass = body.mass[~fixed]  # (n / 3,)
    elements = deforming = make_solid(body.domains, body.laws, pattern, body.n_elements)
    if moving != body.domains:
        deforming = make_solid(moving, body.laws, pattern, body.n_elements)
    viscosity = None
    if body.is_viscous:
        viscosity = make_viscoelasticity(elements, body.laws, body.viscosities)
    tetrahedra = Tetrahedra(
        mesh=body.mesh,
        pattern=pattern,
        elements=elements,
        deforming=deforming,
        mass=np.repeat(mass, 3),
        load=np.outer(mass, config.gravity).ravel(),
        curvature=nodal_curvature(actuators, pattern),
        viscosity=viscosity,
    )
    scheme, solver = integration_of(config), config.integration
    scheme = replace(scheme, viscous=viscosity is not None)
    made: NodalBody | ConstrainedBody
    if constraints:
        made = constrained(tetrahedra, constraints, config, bodies, scheme, actuators, loose)
    else:
        made = NodalBody(
            gravity=np.array(config.gravity),
            integration=scheme,
            actuator_set=actuators,
            pattern=pattern,
            factorisation=make_factorisation(
                pattern.indptr, pattern.indices, solver.factorisation, solver.threads
            ),
            floating=np.repeat(loose[~fixed], 3),
            tetrahedra=tetrahedra,
        )
    effectors = build_nodal_effectors(config.effectors, places, pattern.dof, pattern.n)
    vertices = points_at(np.arange(len(body.mesh.nodes)))
    return robot_with(config, shapes, source, made, effectors, contacts, vertices)
