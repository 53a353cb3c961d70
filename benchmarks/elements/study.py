"""`python -m benchmarks elements`: tension, tip and contact force of every element against a fine mesh."""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from tauten.model import Robot, Simulator, one_blas_thread
from tauten.model.load import robot_path
from tauten.model.materials import SILICONES
from tauten.model.numerics import Array
from tauten.model.schema import (
    ElementName,
    RobotConfig,
    SolidMaterialSettings,
    model_tables,
    read_toml,
    validated,
)
from tauten.service.check import Variant, variant_robot
from tauten.service.process import HostInfo, Progress, host_info
from tauten.service.replay import Spread, spread

ELEMENTS: tuple[ElementName, ...] = ("linear", "smoothed", "quadratic")
LAWS = (
    "corotational",
    "stable-neo-hookean",
    "neo-hookean",
)  # of Young's modulus and Poisson's ratio
TIMED_STEPS = 25


@dataclass(frozen=True, slots=True)
class ElementBenchSettings:
    """What is compared.

    Attributes:
        robot: a robot file, or the name of a shipped robot.
        materials: laws, and silicones scaled to the robot's Young's modulus, see `parse_material`; each is
            compared with a reference of its own.
        positions: shares of every cable's largest pull at which equilibria are compared.
        refinements: of the mesh of linear and smoothed elements, from none to this; quadratic ones have one
            less, as each of their elements has the nodes of eight linear ones.
        reference: refinements of the quadratic mesh that the others are compared with.
        contact: whether surfaces touch.
    """

    robot: str = "finger"
    materials: tuple[str, ...] = ("corotational",)
    positions: tuple[float, ...] = (0.375,)
    refinements: int = 1
    reference: int = 1
    contact: bool = False


@dataclass(frozen=True, slots=True)
class ElementEquilibrium:
    """A robot at rest under pulled lengths.

    Attributes:
        position: share of the largest pull.
        converged: whether it was found.
        factorisations: linearised steps it took from the pull before.
        effort: of every cable [N].
        tip: of every effector [m], three numbers each.
        contact_force: sum of all contact forces [N].
        tension_error: largest relative difference of a tension from the reference.
        tip_error: largest distance of an effector from the reference [m].
        contact_error: relative difference of the contact force, None where nothing touches.
    """

    position: float
    converged: bool
    factorisations: int
    effort: tuple[float, ...]
    tip: tuple[float, ...]
    contact_force: float
    tension_error: float | None = None
    tip_error: float | None = None
    contact_error: float | None = None


@dataclass(frozen=True, slots=True)
class ElementVariant:
    """What is made of a robot file.

    Attributes:
        element: type of the mesh's elements.
        material: law, or name of a silicone.
        refinements: how often its mesh is refined.
    """

    element: ElementName
    material: str
    refinements: int


@dataclass(frozen=True, slots=True)
class ElementCase:
    """One element, material and mesh.

    Attributes:
        element: type of the mesh's elements.
        material: law, or name of a silicone.
        refinements: how often the file's mesh was refined.
        nodes: nodes.
        nonzeros: entries of the tangent.
        assembly_ms: forces and tangent of a state.
        step_ms: a simulator's step without contact.
        equilibria: at each pull.
    """

    element: ElementName
    material: str
    refinements: int
    nodes: int
    nonzeros: int
    assembly_ms: Spread
    step_ms: Spread
    equilibria: tuple[ElementEquilibrium, ...]


@dataclass(frozen=True, slots=True)
class ElementBench:
    """Everything `python -m benchmarks elements` measures.

    Attributes:
        machine: where.
        robot: its name.
        factorisation: back end.
        references: the fine quadratic mesh with each material.
        cases: what is compared with it.
    """

    machine: HostInfo
    robot: str
    factorisation: str
    references: tuple[ElementCase, ...]
    cases: tuple[ElementCase, ...]


def bench_elements(settings: ElementBenchSettings, progress: Progress) -> ElementBench:
    """Compare elements.

    Args:
        settings: what.
        progress: called with the share of the work that is about to be done, and what it is.

    Raises:
        RobotFileError: a file that is not of a robot made of tetrahedra.
    """
    plan: list[tuple[ElementName, int]] = [
        (element, count)
        for element in ELEMENTS
        for count in range(settings.refinements + (element != "quadratic"))
    ]
    share = 1.0 / (len(settings.materials) * (len(plan) + 1))
    references, cases = [], []
    with one_blas_thread():
        for material in settings.materials:
            progress(share, f"reference, {material}")
            fine = ElementVariant("quadratic", material, settings.reference)
            robot = load_variant(settings.robot, fine)
            reference = measure_elements(robot, settings, fine)
            references.append(reference)
            for element, count in plan:
                progress(share, f"{element}, {material}, {count} refinements")
                if (element, count) == ("quadratic", settings.reference):
                    continue
                variant = ElementVariant(element, material, count)
                robot = load_variant(settings.robot, variant)
                cases.append(compared(measure_elements(robot, settings, variant), reference))
    machine = host_info()
    return ElementBench(
        machine, robot.name, robot.body.linear_solver, tuple(references), tuple(cases)
    )


def parse_material(name: str) -> str:
    """The name, where it is that of a law of Young's modulus and Poisson's ratio, or of a silicone.

    Raises:
        ValueError: it is neither.
    """
    known = (*LAWS, *(item.name for item in SILICONES))
    if name not in known:
        raise ValueError(f"material is {name!r}, to compare are {', '.join(known)}")
    return name


def load_variant(name: str, variant: ElementVariant) -> Robot:
    """A robot file with another element and another material outside of `materials`.

    Young's modulus and density are those of the file; a silicone has its own Poisson's ratio.
    """
    path = robot_path(name)
    config = validated(RobotConfig, model_tables(read_toml(path)), path)
    if config.material is None:
        raise ValueError(f"{path}: material: the comparison of elements needs one for all bodies")
    own = config.material
    if variant.material in LAWS:
        material = own.model_copy(update={"law": variant.material})
    else:
        material = SolidMaterialSettings.model_validate(
            {
                "silicone": variant.material,
                "young_modulus": own.young_modulus,
                "density": own.density,
                "total_mass": own.total_mass,
            }
        )
    mesh = Variant(variant.element, variant.refinements)
    return variant_robot(config.model_copy(update={"material": material}), path, mesh)


def measure_elements(
    robot: Robot, settings: ElementBenchSettings, variant: ElementVariant
) -> ElementCase:
    """Equilibria along the pulls, then times at the last one.

    Args:
        robot: of one kind of element.
        settings: pulls and contact.
        variant: which elements and refinement.
    """
    simulator = Simulator(robot, contact="full" if settings.contact else "none")
    equilibria = []
    for position in settings.positions:
        report = simulator.settle(position=position * robot.limits.position_max, tolerance=1e-6)
        equilibria.append(
            ElementEquilibrium(
                position=position,
                converged=report.converged,
                factorisations=report.iterations,
                effort=tuple(simulator.effort.tolist()),
                tip=tuple(simulator.effector.ravel().tolist()),
                contact_force=float(simulator.lam_c.sum()),
            )
        )
    assembly, step = time_step(robot, settings.positions[-1] * robot.limits.position_max)
    return ElementCase(
        element=variant.element,
        material=variant.material,
        refinements=variant.refinements,
        nodes=robot.n_nodes,
        nonzeros=len(robot.forces(robot.rest())[1]),
        assembly_ms=assembly,
        step_ms=step,
        equilibria=tuple(equilibria),
    )


def time_step(robot: Robot, position: Array) -> tuple[Spread, Spread]:
    """Times of assembly and of a step while the cables are pulled to `position` (n_a,) [ms]."""
    simulator, assembly, step = Simulator(robot, contact="none"), [], []
    for share in np.linspace(0.0, 1.0, TIMED_STEPS + 3):
        start = perf_counter()
        simulator.step(position=share * position)
        step.append(1e3 * (perf_counter() - start))
        start = perf_counter()
        simulator.robot.forces(simulator.state, simulator.effort, exact=True)
        assembly.append(1e3 * (perf_counter() - start))
    return spread(assembly[3:]), spread(step[3:])


def compared(case: ElementCase, reference: ElementCase) -> ElementCase:
    """The case with its differences from the reference."""
    pairs = zip(case.equilibria, reference.equilibria, strict=True)
    return replace(case, equilibria=tuple(with_errors(one, other) for one, other in pairs))


def with_errors(one: ElementEquilibrium, reference: ElementEquilibrium) -> ElementEquilibrium:
    """An equilibrium with its differences from the reference; without any where one of them was not found."""
    if not (one.converged and reference.converged):
        return one
    effort, fine = np.array(one.effort), np.array(reference.effort)
    tips = np.array([one.tip, reference.tip]).reshape(2, -1, 3)
    touching = reference.contact_force > 0.0
    contact = one.contact_force / reference.contact_force - 1.0 if touching else None
    relative = (effort - fine) / np.maximum(np.abs(fine), 1e-9)
    return replace(
        one,
        tension_error=float(relative[np.abs(relative).argmax()]),
        tip_error=float(np.linalg.norm(tips[0] - tips[1], axis=1).max()),
        contact_error=contact,
    )
