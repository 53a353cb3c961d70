"""`tauten check`: everything about a robot's mesh and body in one result."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from tauten.model import MeshError, Robot, RobotFileError, load_robot, one_blas_thread
from tauten.model.load import (
    Bodies,
    build_bodies,
    is_shipped,
    mesh_files,
    part_path,
    read_bodies,
    robot_path,
)
from tauten.model.mesh import read_unchecked_mesh
from tauten.model.schema import (
    ACTUATOR_TABLES,
    PartRobotConfig,
    PartsConfig,
    RobotConfig,
    model_tables,
    read_toml,
    validated,
)
from tauten.service.check.actuator_findings import actuator_findings
from tauten.service.check.body_findings import VIBRATION, body_findings, not_held
from tauten.service.check.contact_findings import contact_finding, idle_obstacles, untouched
from tauten.service.check.control_findings import control_findings
from tauten.service.check.extension_findings import extension_findings
from tauten.service.check.findings import Finding, Level, worst
from tauten.service.check.mesh_error import MESH_ERROR, MeshErrorEstimate, estimate_error
from tauten.service.check.mesh_findings import chamber_findings, mesh_findings, thin_layers
from tauten.service.check.mesh_variants import (
    LoadedState,
    Variant,
    VariantStates,
    chosen_variants,
    equilibria,
    make_loads,
    variant_robot,
)
from tauten.service.check.parts_findings import parts_findings
from tauten.service.check.region_findings import RegionParts, region_parts
from tauten.service.process import Interrupted, Progress, StopFlag


@dataclass(frozen=True, slots=True)
class CheckSettings:
    """What is checked.

    Attributes:
        robot: a robot file, or the name of a shipped robot.
        shares: of every cable's largest pull, at which meshes are compared; none: no comparison.
        refinements: of the robot's mesh to compare with, 0 to 3; three meshes or more are extrapolated.
    """

    robot: str
    shares: tuple[float, ...] = (0.25, 0.5)
    refinements: int = 1


@dataclass(frozen=True, slots=True)
class RobotCheck:
    """What was found.

    Attributes:
        robot: its name.
        findings: line by line.
        estimate: error of the mesh; None for beams, where it was not wanted, and where the robot cannot be
            built.
        refused: why the robot cannot be built; "" where it can.
        complete: whether everything was looked at.
        digest: SHA-256 of the robot's model; "" where it cannot be built.
    """

    robot: str
    findings: tuple[Finding, ...]
    estimate: MeshErrorEstimate | None = None
    refused: str = ""
    complete: bool = True
    digest: str = ""

    @property
    def level(self) -> Level:
        """The worst level of all findings."""
        return "wrong" if self.refused else worst(self.findings)


def check_robot(settings: CheckSettings, stop: StopFlag, progress: Progress) -> RobotCheck:
    """Check a robot; when `stop` is raised, what was found until then.

    Raises:
        RobotFileError: the robot file cannot be read.
        MeshError: its mesh file cannot be read.
    """
    with one_blas_thread():
        found = check_model(settings, stop, progress)
        if found.refused or stop.requested:
            return found
        progress(0.0, "first decisions")
        try:
            with stop.interruptible():
                slower = not any(
                    item.advice
                    for item in found.findings
                    if item.subject in (MESH_ERROR, VIBRATION)
                )
                control = tuple(control_findings(robot_path(settings.robot), slower))
        except Interrupted:
            return replace(found, complete=False)
    return replace(found, findings=(*found.findings, *control))


def check_model(settings: CheckSettings, stop: StopFlag, progress: Progress) -> RobotCheck:
    """Check a robot as a model, without its controller.

    Raises:
        RobotFileError, MeshError: as of `check_robot`.
    """
    path = robot_path(settings.robot)
    raw = model_tables(read_toml(path))
    with one_blas_thread():
        if "parts" in raw:
            return check_parts(settings, path, stop, progress)
        config = validated(RobotConfig, raw, path)
        progress(0.0, "mesh")
        files = [file for file in mesh_files(config, path) if file is not None]
        meshes = [
            read_unchecked_mesh(file, mesh.length_unit)
            for file, mesh in zip(files, config.meshes, strict=True)
        ]
        findings = tuple(mesh_findings(config, meshes))
        element = config.meshes[0].element if config.meshes else "beam"
        own = Variant(element, 0)
        try:
            robot = variant_robot(config, path, own)
        except (RobotFileError, MeshError) as error:
            return RobotCheck(config.name, findings, refused=str(error))
        bodies = bodies_of(config, path)
        regions = region_parts(config, bodies)
        findings += tuple(part.finding for part in regions if not part.of_beams)
        findings += tuple(chamber_findings(config, path.parent))
        progress(0.02, "body")
        free = tuple(body.name for body in config.bodies if body.free)
        lone = untouched(robot, bodies, config)
        density, shipped = least_density(config), is_shipped(path)
        findings += tuple(body_findings(robot, free, lone, density, shipped))
        findings += tuple(extension_findings(robot))
        if config.meshes:
            findings += (contact_finding(robot, bodies, config.contact.tolerance),)
        findings += tuple(idle_obstacles(config))
        progress(0.08, own.name)
        findings += tuple(actuator_findings(robot, config, held=not free))
        found, complete = None, True
        if free:
            findings += (Finding(MESH_ERROR, "fine", not_held(free)),)
        elif settings.shares:
            variants = chosen_variants(element, settings.refinements)
            make = partial(variant_robot, config, path)
            found = compare_meshes(settings, robot, variants, make, stop, progress)
            findings, complete = findings + found.findings, found.complete
        else:
            findings += tuple(thin_layers(config, meshes))
        return RobotCheck(config.name, findings, found, complete=complete, digest=robot.digest)


def least_density(config: RobotConfig) -> float | None:
    """The least density that the materials of a robot have [kg/m³]; None where masses are given instead."""
    materials = [body.material for body in config.all_bodies]
    known = [one.density for one in materials if one is not None and one.total_mass is None]
    return min(known, default=None)


def check_parts(
    settings: CheckSettings, path: Path, stop: StopFlag, progress: Progress
) -> RobotCheck:
    """What applies to each part of a robot, every robot file once.

    Raises:
        RobotFileError, MeshError: as of `check_robot`.
    """
    robot = load_robot(path)
    config = validated(PartsConfig, model_tables(read_toml(path)), path)
    files = {part.robot: part_path(part.robot, path) for part in config.parts}
    contents = {name: read_toml(file) for name, file in files.items()}
    configs = {
        name: validated(PartRobotConfig, model_tables(contents[name]), file)
        for name, file in files.items()
    }
    findings = list(
        parts_findings(robot, config, {one.name: configs[one.robot] for one in config.parts})
    )
    findings += extension_findings(robot, {one.name for one in config.obstacles})
    findings += idle_obstacles(config)
    complete = True
    for written, file in files.items():
        name, given = written.removesuffix(".toml"), contents[written]
        moved = not given.keys().isdisjoint(ACTUATOR_TABLES)  # others are objects
        if not (moved and given.get("effectors")):
            missing = "effector" if moved else "actuator"
            findings.append(Finding(f"{name}: no {missing}", "fine", "its mesh is not compared"))
            continue

        def of_part(share: float, what: str = "", name: str = name) -> None:
            progress(share / len(files), f"{name}: {what}")

        found = check_model(replace(settings, robot=str(file)), stop, of_part)
        findings += [replace(item, subject=f"{name}: {item.subject}") for item in found.findings]
        complete = complete and found.complete
    return RobotCheck(robot.name, tuple(findings), complete=complete, digest=robot.digest)


def bodies_of(config: RobotConfig, path: Path) -> Bodies:
    """The bodies of a robot file."""
    return build_bodies(config, read_bodies(config, path), str(path))


def selected(name_or_path: str) -> tuple[Robot, tuple[RegionParts, ...]]:
    """A robot, and what the regions of its file select.

    Raises:
        RobotFileError: it cannot be built, or has parts.
        MeshError: its mesh cannot be used.
    """
    path = robot_path(name_or_path)
    raw = model_tables(read_toml(path))
    if "parts" in raw:
        raise RobotFileError(f"{path}: regions are drawn of the robot file of each part")
    config = validated(RobotConfig, raw, path)
    return load_robot(path), tuple(region_parts(config, bodies_of(config, path)))


def compare_meshes(
    settings: CheckSettings,
    robot: Robot,
    variants: tuple[Variant, ...],
    make: Callable[[Variant], Robot],
    stop: StopFlag,
    progress: Progress,
) -> MeshErrorEstimate:
    """The same loads on the robot's mesh and on others."""
    antagonists = variants[0].element == "beam"
    loads = make_loads(robot, settings.shares, antagonists)
    total = sum(variant.relative_cost for variant in variants) * len(loads)
    found: list[VariantStates] = []
    for variant in variants:
        if stop.requested:
            break
        states: list[LoadedState] = []
        nodes, failure = 0, ""
        try:
            made = robot if variant == variants[0] else make(variant)
            nodes = made.n_nodes
            with suppress(Interrupted), stop.interruptible():
                for state in equilibria(made, loads, antagonists):
                    states.append(state)
                    progress(0.9 * variant.relative_cost / total, variant.name)
        except Exception as error:  # whatever it is, the equilibria of the other meshes are kept
            failure = f"{type(error).__name__}: {error}"
        found.append(VariantStates(variant, nodes, tuple(states), failure))
    last = found[-1] if len(found) == len(variants) else None
    complete = last is not None and (len(last.states) == len(loads) or bool(last.failure))
    names = {kind.effort.name for kind in robot.actuators.kinds}
    effort_name = names.pop() if len(names) == 1 else "effort"
    return estimate_error(loads, tuple(found), robot.size, complete, effort_name)
