"""`tauten bench finger`, `steps` and `sofa-meshes`: times of steps, and errors of the reduction."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np

from tauten.controller import ControllerSettings
from tauten.model import Enrichment, Robot, Simulator, default_enrichment, load_robot
from tauten.model.numerics import Array, Bools
from tauten.reduction import ContactBasis
from tauten.service.bench.physics import diamond, finger, trunk
from tauten.service.bench.stages import StepTimes, time_steps
from tauten.service.plant import PathSettings, make_path
from tauten.service.process import HostInfo, host_info, one_blas_thread
from tauten.service.replay import Spread, spread

ShareDone = Callable[[float], None]

WARM_UP = 5  # steps that are not measured

# Median of SOFA v25.06 with SoftRobots.Inverse on a quiet AMD EPYC at 2.25 GHz with 2 cores, one thread, as
# published with the reference data and, of the finger, with the request for these times [ms]
SOFA_MS = {"diamond inverse": 22.0, "trunk forward": 8.4, "finger forward": 22.4}


@dataclass(frozen=True, slots=True)
class Sizes:
    """Sizes of a robot's problems."""

    nodes: int
    elements: int
    unknowns: int
    cables: int
    candidates: int
    modes: int


@dataclass(frozen=True, slots=True)
class TipError:
    """Tip of reduced against pointwise contact along pulls from rest to the largest.

    Attributes:
        enriched: whether unit columns joined where gaps were deeper than the robot file's tolerance.
        pulls: number of equilibria compared.
        mean_mm: mean distance of the tips.
        max_mm: largest.
        deepest_gap_mm: deepest predicted penetration of the reduced one, as a gap.
        extra_columns: largest number of unit columns in play.
        unconverged: equilibria that did not settle, with reduced or with pointwise contact.
    """

    enriched: bool
    pulls: int
    mean_mm: float
    max_mm: float
    deepest_gap_mm: float
    extra_columns: int
    unconverged: int


@dataclass(frozen=True, slots=True)
class ControlBench:
    """Everything `tauten bench finger` measures."""

    machine: HostInfo
    robot: str
    rate_hz: float
    factorisation: str
    sizes: Sizes
    control: tuple[StepTimes, ...]
    tip_error: tuple[TipError, ...]


@dataclass(frozen=True, slots=True)
class SizeTimes:
    """Steps of one mesh without contact.

    Attributes:
        sizes: of its problems.
        factorisation: back end.
        forward_ms: a simulator's step under a pulled length.
        inverse_ms: a controller's step, target to advanced model.
    """

    sizes: Sizes
    factorisation: str
    forward_ms: Spread
    inverse_ms: Spread


@dataclass(frozen=True, slots=True)
class StepBench:
    """Everything `tauten bench steps` measures."""

    machine: HostInfo
    robot: str
    meshes: tuple[SizeTimes, ...]


@dataclass(frozen=True, slots=True)
class SofaMeshTimes:
    """Steps of one robot on the mesh that SOFA computed with, without contact.

    Attributes:
        robot: its name.
        sizes: of its problems.
        forward_ms: a simulator's step under a growing pull of all its cables, of the trunk of the first one.
        inverse: a controller's steps with their stages.
        sofa_ms: published medians of SOFA by kind of step, from another computer.
    """

    robot: str
    sizes: Sizes
    forward_ms: Spread
    inverse: StepTimes
    sofa_ms: dict[str, float]


@dataclass(frozen=True, slots=True)
class SofaMeshBench:
    """Everything `tauten bench sofa-meshes` measures."""

    machine: HostInfo
    robots: tuple[SofaMeshTimes, ...]


def sizes_of(robot: Robot, modes: int = 0) -> Sizes:
    """Sizes of a robot's problems."""
    return Sizes(robot.n_nodes, robot.n_elements, robot.n, robot.n_a, robot.n_c, modes)


def bench_control(
    robot: Robot,
    basis: ContactBasis,
    settings: ControllerSettings,
    seconds: float,
    pulls: int,
    progress: ShareDone,
) -> ControlBench:
    """Time control steps with contact none, full and reduced; compare reduced with pointwise tips.

    Args:
        robot: what to control.
        basis: its contact basis.
        settings: of the controllers.
        seconds: of the path along what the cables reach, there and back.
        pulls: equilibria at which tips are compared.
        progress: called with the share of the work that has just been done.
    """
    path = make_path("reach", robot, PathSettings(period=seconds, fraction=0.9))
    targets = np.array([path.at(t) for t in np.arange(0.0, seconds, robot.h)])
    kinds = (("none", "none"), ("full", "full"), (basis, f"reduced, k = {basis.k}"))
    with one_blas_thread():
        control = []
        for contact, name in kinds:
            control.append(time_steps(robot, contact, name, targets, settings))  # type: ignore[arg-type]
            progress(1.0 / 6.0)
        full = tip_curve(robot, "full", None, pulls)
        progress(1.0 / 6.0)
        tolerance = robot.tolerance
        enrichments = (None, default_enrichment(tolerance))
        errors = []
        for enrichment in enrichments:
            errors.append(tip_error(full, tip_curve(robot, basis, enrichment, pulls), enrichment))
            progress(1.0 / 6.0)
    return ControlBench(
        machine=host_info(),
        robot=robot.name,
        rate_hz=1.0 / robot.h,
        factorisation=robot.linear_solver,
        sizes=sizes_of(robot, basis.k),
        control=tuple(control),
        tip_error=tuple(errors),
    )


@dataclass(frozen=True, slots=True)
class _TipCurve:
    tips: Array  # (s, 3) [m]
    converged: Bools  # (s,)
    deepest: float
    extra: int


def tip_curve(
    robot: Robot, contact: object, enrichment: Enrichment | None, pulls: int
) -> _TipCurve:
    """Equilibria with every cable pulled in proportion from rest to its largest pull.

    Args:
        robot: the robot.
        contact: "none", "full" or a contact basis.
        enrichment: of the basis; None without.
        pulls: number of equilibria.
    """
    simulator = Simulator(robot, contact, enrichment)  # type: ignore[arg-type]
    tips, converged, deepest, extra = [], [], np.inf, 0
    for share in np.linspace(0.0, 1.0, pulls):
        report = simulator.settle(pull=share * robot.limits.pull_max, tolerance=1e-6)
        tips.append(simulator.effector[0])
        converged.append(report.converged)
        deepest = min(deepest, report.deepest_gap)
        extra = max(extra, report.extra_columns)
    return _TipCurve(np.array(tips), np.array(converged), deepest, extra)


def tip_error(full: _TipCurve, reduced: _TipCurve, enrichment: Enrichment | None) -> TipError:
    """Distances between the tips of two curves where both settled.

    Args:
        full: with pointwise contact.
        reduced: with a contact basis.
        enrichment: of the basis; None without.
    """
    both = full.converged & reduced.converged
    distance = 1e3 * np.linalg.norm(full.tips - reduced.tips, axis=1)[both]
    return TipError(
        enriched=enrichment is not None,
        pulls=int(both.sum()),
        mean_mm=float(distance.mean()),
        max_mm=float(distance.max()),
        deepest_gap_mm=1e3 * reduced.deepest,
        extra_columns=reduced.extra,
        unconverged=int((~both).sum()),
    )


def bench_steps(
    robot_file: str, refinements: int, factorisation: str, steps: int, progress: ShareDone
) -> StepBench:
    """Time forward and inverse steps without contact on a mesh and its uniform refinements.

    The pull grows from zero to half its limit.

    Args:
        robot_file: name or path.
        refinements: of the mesh.
        factorisation: back end, or "auto".
        steps: to measure on each mesh.
        progress: called with the share of the work that has just been done.
    """
    meshes = []
    for count in range(refinements + 1):
        robot = load_robot(robot_file, None, count, factorisation)
        with one_blas_thread():
            meshes.append(
                SizeTimes(
                    sizes=sizes_of(robot),
                    factorisation=robot.linear_solver,
                    forward_ms=time_forward(robot, steps),
                    inverse_ms=time_inverse(robot, steps),
                )
            )
        progress(1.0 / (refinements + 1))
    return StepBench(host_info(), robot.name, tuple(meshes))


def time_forward(robot: Robot, steps: int) -> Spread:
    """Times of simulator steps while the cables are pulled to half their limit [ms].

    Args:
        robot: the robot.
        steps: to measure, after some that are not.
    """
    simulator, times = Simulator(robot, contact="none"), []
    for share in np.linspace(0.0, 0.5, steps + WARM_UP):
        start = perf_counter()
        simulator.step(pull=share * robot.limits.pull_max)
        times.append(1e3 * (perf_counter() - start))
    return spread(times[WARM_UP:])


def time_inverse(robot: Robot, steps: int) -> Spread:
    """Times of control steps that follow the tip of a forward simulation [ms].

    Args:
        robot: the robot.
        steps: to measure, after some that are not.
    """
    times = time_steps(robot, "none", "none", forward_tips(robot, steps), warm_up=WARM_UP)
    return times.whole_ms["step"]


def forward_tips(robot: Robot, steps: int) -> Array:
    """Positions (steps + WARM_UP, p, 3) of the effectors as `time_forward` moves them [m]."""
    simulator, tips = Simulator(robot, contact="none"), []
    for share in np.linspace(0.0, 0.5, steps + WARM_UP):
        simulator.step(pull=share * robot.limits.pull_max)
        tips.append(simulator.effector.copy())
    return np.array(tips).reshape(len(tips), -1, 3)


def bench_sofa_meshes(data: Path, steps: int, progress: ShareDone) -> SofaMeshBench:
    """Time forward and inverse steps of trunk, diamond and finger on the meshes that SOFA computed with.

    SOFA is not run: its medians are published ones, from another computer. The trunk moves forward with its
    first cable alone, as there, and inversely with all eight.

    Args:
        data: folder of the reference data.
        steps: to measure of each kind.
        progress: called with the share of the work that has just been done.
    """
    models = data / "sofa_robots"
    legs, bent = diamond(models), finger(data, refinements=1)
    cases = (
        ("diamond", legs, legs, circle(np.array([0.0, 0.0, 0.115]), steps)),
        ("trunk", trunk(models, ("L0",)), trunk(models), circle(np.array([0.0, 0.0, 0.19]), steps)),
        ("finger", bent, bent, None),
    )
    found = []
    with one_blas_thread():
        for name, pulled, led, targets in cases:
            followed = forward_tips(led, steps) if targets is None else targets
            found.append(
                SofaMeshTimes(
                    robot=name,
                    sizes=sizes_of(led),
                    forward_ms=time_forward(pulled, steps),
                    inverse=time_steps(led, "none", "none", followed, warm_up=WARM_UP),
                    sofa_ms={
                        kind: SOFA_MS[f"{name} {kind}"]
                        for kind in ("forward", "inverse")
                        if f"{name} {kind}" in SOFA_MS
                    },
                )
            )
            progress(1.0 / len(cases))
    return SofaMeshBench(host_info(), tuple(found))


def circle(centre: Array, steps: int, radius: float = 0.02) -> Array:
    """Targets (steps + WARM_UP, 1, 3) once round a circle in a plane of constant z [m].

    Args:
        centre: (3,) of the circle [m].
        steps: on the circle; before them the target moves from its centre to its first point.
        radius: of the circle [m].
    """
    angle = np.concatenate([np.zeros(WARM_UP), np.linspace(0.0, 2.0 * np.pi, steps)])
    size = radius * np.concatenate([np.linspace(0.0, 1.0, WARM_UP), np.ones(steps)])
    offset = np.stack([size * np.cos(angle), size * np.sin(angle), np.zeros_like(angle)], axis=1)
    targets: Array = (centre + offset)[:, None]
    return targets
