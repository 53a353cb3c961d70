"""`tauten bench finger` and `tauten bench steps`: times of steps, and errors of the reduction."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from tauten.controller import ControllerSettings
from tauten.model import Enrichment, Robot, Simulator, default_enrichment, load_robot
from tauten.model.numerics import Array, Bools
from tauten.reduction import ContactBasis
from tauten.service.bench.stages import StepTimes, time_steps
from tauten.service.plant import PathSettings, make_path
from tauten.service.process import HostInfo, host_info, one_blas_thread
from tauten.service.replay import Spread, spread

ShareDone = Callable[[float], None]


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


def time_forward(robot: Robot, steps: int, warm_up: int = 5) -> Spread:
    """Times of simulator steps while the cables are pulled to half their limit [ms].

    Args:
        robot: the robot.
        steps: to measure.
        warm_up: steps before them.
    """
    simulator, times = Simulator(robot, contact="none"), []
    for share in np.linspace(0.0, 0.5, steps + warm_up):
        start = perf_counter()
        simulator.step(pull=share * robot.limits.pull_max)
        times.append(1e3 * (perf_counter() - start))
    return spread(times[warm_up:])


def time_inverse(robot: Robot, steps: int, warm_up: int = 5) -> Spread:
    """Times of control steps that follow the tip of a forward simulation [ms].

    Args:
        robot: the robot.
        steps: to measure.
        warm_up: steps before them.
    """
    simulator, targets = Simulator(robot, contact="none"), []
    for share in np.linspace(0.0, 0.5, steps + warm_up):
        simulator.step(pull=share * robot.limits.pull_max)
        targets.append(simulator.effector.ravel())
    times = time_steps(robot, "none", "none", np.array(targets).reshape(-1, 3), warm_up=warm_up)
    return times.whole_ms["step"]
