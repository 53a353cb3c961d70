"""`python -m benchmarks gallery`: sizes and step times of the robots of the gallery."""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter

import numpy as np

from tauten.controller import Controller, Order
from tauten.model import Robot, Simulator, one_blas_thread
from tauten.model.numerics import Array
from tauten.reduction.campaign import TOLERANCE, Design, exploring
from tauten.service.plant import PathSettings, make_path
from tauten.service.process import HostInfo, Progress, host_info
from tauten.service.replay import Spread, spread
from tauten.service.setup import Setup, load_setup

WARM_UP = 10  # steps that are not measured
SAMPLED = 5  # equilibria from whose time that of the whole campaign is estimated


@dataclass(frozen=True, slots=True)
class GalleryRow:
    """One robot.

    Attributes:
        robot: its name.
        size_mm: of the robot.
        nodes: of its mesh.
        actuators: number.
        candidates: of contact.
        modes: k of its contact basis; 0 without.
        state_modes: r of its state basis; None without.
        full_ms: whole inverse steps of the full model.
        reduced_ms: of the reduced one; None without.
        tip_mean_mm: mean distance of the reduced model's tip from the full one's, on equilibria held out.
        tip_max_mm: the largest.
        campaign_equilibria: number of equilibria of `tauten reduce`.
        campaign_s: their time in one process, estimated from the first ones.
    """

    robot: str
    size_mm: float
    nodes: int
    actuators: int
    candidates: int
    modes: int
    state_modes: int | None
    full_ms: Spread
    reduced_ms: Spread | None
    tip_mean_mm: float | None
    tip_max_mm: float | None
    campaign_equilibria: int
    campaign_s: float


@dataclass(frozen=True, slots=True)
class GalleryBench:
    """Everything `python -m benchmarks gallery` measures."""

    machine: HostInfo
    robots: tuple[GalleryRow, ...]


def bench_gallery(
    names: tuple[str, ...], steps: int, progress: Progress, model: Order | None = None
) -> GalleryBench:
    """Measure each robot along what its actuators reach.

    Args:
        names: of shipped robots, or robot files.
        steps: inverse steps of each model.
        progress: called with the share of the work done and the robot that comes next.
        model: compared with the full one; None: the one that the robot file serves.
    """
    rows = []
    with one_blas_thread():
        for name in names:
            progress(0.0, name)
            rows.append(_row(name, steps, model))
            progress(1.0 / len(names), name)
    return GalleryBench(host_info(), tuple(rows))


def _row(name: str, steps: int, model: Order | None) -> GalleryRow:
    """All numbers of one robot.

    Args:
        name: of a shipped robot, or a robot file.
        steps: inverse steps of each model.
        model: as in `bench_gallery`.
    """
    setup = load_setup(name, model=model, accept_error=True)
    full = load_setup(name, model="full")
    robot = full.robot
    targets = reach_targets(robot, steps + WARM_UP)
    design = exploring(robot)
    each = equilibrium_seconds(robot, design, SAMPLED)
    origins = [basis.origin for basis in setup.states]
    return GalleryRow(
        robot=robot.name,
        size_mm=1e3 * robot.size,
        nodes=robot.n_nodes,
        actuators=robot.n_a,
        candidates=robot.n_c,
        modes=0 if isinstance(full.contact, str) else full.contact.k,
        state_modes=sum(one.r for one in origins) or None,
        full_ms=inverse_times(full, targets),
        reduced_ms=inverse_times(setup, targets) if origins else None,
        tip_mean_mm=1e3 * max(one.tip_mean for one in origins) if origins else None,
        tip_max_mm=1e3 * max(one.tip_max for one in origins) if origins else None,
        campaign_equilibria=design.size,
        campaign_s=each * design.size,
    )


def reach_targets(robot: Robot, steps: int) -> Array:
    """Goal values (steps, n_v) on the path of `reach` of the first effector; the others rest."""
    path = make_path("reach", robot, PathSettings(period=steps * robot.h, fraction=0.7))
    layout = robot.effector_layout
    values = np.tile(robot.effector_values(robot.rest()), (steps, 1))
    values[:, layout.values_of(0)] = [path.at(k * robot.h) for k in range(steps)]
    return values


def inverse_times(setup: Setup, targets: Array) -> Spread:
    """Times of whole inverse steps, from a target to the advanced model [ms].

    Args:
        setup: robot, contact and settings.
        targets: (s, n_v) goal values, the first `WARM_UP` of which are not measured.
    """
    controller = Controller(setup.robot, setup.contact, settings=setup.controller)
    times = []
    for target in targets:
        start = perf_counter()
        controller.step(target)
        times.append(1e3 * (perf_counter() - start))
    return spread(times[WARM_UP:])


def equilibrium_seconds(robot: Robot, design: Design, count: int) -> float:
    """Mean time of the first equilibria of a design [s].

    Args:
        robot: the robot.
        design: of a campaign.
        count: number of equilibria.
    """
    run = design.runs[0].piece(0, count)
    simulator = Simulator(robot, contact="full")
    start = perf_counter()
    for i in range(len(run)):
        effort = None if run.effort is None else run.effort[:, i]
        simulator.settle(run.position[:, i], effort, TOLERANCE)
    return (perf_counter() - start) / len(run)
