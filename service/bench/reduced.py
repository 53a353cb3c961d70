"""`tauten bench reduced`: state modes and sampled elements against error and step time."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tauten.model import (
    ContactSpace,
    Robot,
    Simulator,
    default_enrichment,
    load_robot,
    one_blas_thread,
)
from tauten.model.numerics import Array
from tauten.reduction import ContactBasis
from tauten.reduction.campaign import Ranges, Snapshots, latin_hypercube, ramp, run_campaign
from tauten.reduction.contact import snapshot_values
from tauten.reduction.state import StateSettings, held_out_snapshots, reduce_states, reduced_robot
from tauten.service.bench.following import reach_targets
from tauten.service.bench.steps import time_control
from tauten.service.process import HostInfo, Progress, host_info
from tauten.service.replay import Spread

REACH = 0.9  # of the range of each actuator, on the path that is followed
RAMP_STEPS = 200  # equilibria of the training campaign
# loads outside the training
FOREIGN = Ranges(position=(0.5, 1.0), tilt=np.radians(20.0), force=0.02)
FOREIGN_RUNS, FOREIGN_STEPS = 6, 20
FOLLOWED = 40  # equilibria of the training path at which tips are compared
STATE_SETTINGS = (
    *(StateSettings(r=r, responses=0) for r in (5, 10, 15, 20, 30, 40, 60)),
    *(StateSettings(r=r, responses=10) for r in (5, 10, 20, 30)),
    *(StateSettings(r=10, responses=10, sample=sample) for sample in (1e-1, 3e-2, 3e-3)),
)


@dataclass(frozen=True, slots=True)
class PathAccuracy:
    """Reduced against full model along a path of equilibria, with contact as in a controller.

    Attributes:
        equilibria: number of them that both found.
        lost: number that the reduced model did not settle in.
        mean_mm: mean distance of the tips; None without equilibria.
        max_mm: largest.
        deepest_gap_mm: deepest predicted penetration, as a gap.
    """

    equilibria: int
    lost: int
    mean_mm: float | None
    max_mm: float | None
    deepest_gap_mm: float


@dataclass(frozen=True, slots=True)
class ReducedCase:
    """One state basis with its sample.

    Attributes:
        modes: modes of motion.
        responses: static responses among the unknowns beside them.
        sample: allowed relative residual of the sample.
        elements: in the sample.
        motion_left_out: of the training states, relative.
        training: along the training path, at states that took no part in it.
        foreign: under loads that are not in the training campaign.
        step_ms: of control steps along the reach path.
    """

    modes: int
    responses: int
    sample: float
    elements: int
    motion_left_out: float
    training: PathAccuracy
    foreign: PathAccuracy
    step_ms: Spread


@dataclass(frozen=True, slots=True)
class ReducedBench:
    """Everything `tauten bench reduced` measures."""

    machine: HostInfo
    robot: str
    size_mm: float
    rate_hz: float
    contact_modes: int
    cases: tuple[ReducedCase, ...]


def bench_reduced(
    robot_file: str, basis: ContactBasis, folder: Path, seconds: float, progress: Progress
) -> ReducedBench:
    """Measure all cases.

    Args:
        robot_file: name or path.
        basis: its contact basis.
        folder: where campaigns are kept.
        seconds: of the path along what the cables reach.
        progress: called with the share of the work that has just been done, and what comes next.
    """
    step = 1.0 / (len(STATE_SETTINGS) + 2.0)
    with one_blas_thread():
        robot = load_robot(robot_file)
        progress(0.0, "campaign of the training path")
        training = ramp_snapshots(robot, folder / "ramp", RAMP_STEPS)
        progress(step, "campaign of foreign loads")
        design = latin_hypercube(robot, FOREIGN, FOREIGN_RUNS, seed=0, steps=FOREIGN_STEPS)
        foreign = run_campaign(robot, design, folder / "foreign")
        foreign = foreign.select(foreign.converged)
        targets = reach_targets(robot, seconds, REACH)
        cases = []
        for settings in STATE_SETTINGS:
            about = f"{settings.r} modes, {settings.responses} responses"
            progress(step, f"{about}, sample {settings.sample:g}")
            cases.append(run_case(robot, basis, training, foreign, settings, targets))
        progress(step)
    size, rate = 1e3 * robot.size, 1.0 / robot.h
    return ReducedBench(host_info(), robot.name, size, rate, basis.k, tuple(cases))


def ramp_snapshots(robot: Robot, folder: Path, steps: int) -> Snapshots:
    """Equilibria of the ramp of the cables."""
    design = ramp(robot, float(np.abs(robot.limits.farthest_position).min()) / steps)
    found = run_campaign(robot, design, folder)
    return found.select(found.converged)


def run_case(
    robot: Robot,
    basis: ContactBasis,
    training: Snapshots,
    foreign: Snapshots,
    settings: StateSettings,
    targets: Array,
) -> ReducedCase:
    """Compute a state basis and measure it.

    Args:
        robot: the full robot.
        basis: its contact basis.
        training: snapshots to compute the basis from.
        foreign: snapshots under other loads.
        settings: of the basis.
        targets: (s, 3) to follow while steps are timed [m].
    """
    states = reduce_states(robot, training, basis, settings)
    reduced, origin = reduced_robot(robot, states), states.origin
    return ReducedCase(
        modes=origin.r - origin.responses,
        responses=origin.responses,
        sample=settings.sample,
        elements=origin.sample,
        motion_left_out=origin.projection_error,
        training=path_accuracy(reduced, basis, unseen(training)),
        foreign=path_accuracy(reduced, basis, foreign),
        step_ms=time_control(reduced, basis, targets),
    )


def unseen(training: Snapshots) -> Snapshots:
    """States of the training path that took no part in the training, at most `FOLLOWED` of them."""
    held_out = training.select(held_out_snapshots(training))
    return held_out.select(np.arange(0, len(held_out), -(-len(held_out) // FOLLOWED)))


def path_accuracy(robot: Robot, basis: ContactSpace, snapshots: Snapshots) -> PathAccuracy:
    """Settle along stored equilibria of the full model and compare effectors."""
    enrichment = default_enrichment(robot.tolerance)
    simulator = Simulator(robot, basis, enrichment)
    layout, wanted = robot.effector_layout, snapshot_values(robot, snapshots)
    apart, deepest, lost = [], np.inf, 0
    for i in range(len(snapshots)):
        if i == 0 or snapshots.run[i] != snapshots.run[i - 1]:
            simulator.reset()
        simulator.load(snapshots.gravity[:, i], snapshots.effector_force[:, i])
        report = simulator.settle(
            position=snapshots.position[:, i], tolerance=1e-6, max_iterations=60
        )
        if not report.converged:
            lost += 1
            continue
        apart.append(1e3 * layout.error(simulator.effector_values, wanted[i]))
        deepest = min(deepest, 1e3 * report.deepest_gap)
    return PathAccuracy(
        equilibria=len(apart),
        lost=lost,
        mean_mm=float(np.mean(apart)) if apart else None,
        max_mm=max(apart) if apart else None,
        deepest_gap_mm=deepest if np.isfinite(deepest) else 0.0,
    )
