"""Steps per second of the manipulator, straight and bent, full and reduced: the paper's Table II."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import cycle
from time import perf_counter
from typing import Literal

import numpy as np

from benchmarks.contact_basis import solve_pgs
from benchmarks.manipulator.postures import arm_in_equilibrium
from benchmarks.steps import StepTimes, time_controller
from tauten.controller import Controller, load_controller_settings
from tauten.model import (
    Enrichment,
    Forces,
    Robot,
    Simulator,
    default_enrichment,
    row_compliance,
    row_layout,
)
from tauten.model.numerics import Array
from tauten.reduction import ContactBasis

_SWEEPS, _TOLERANCE = 1000, 1e-6  # of Gauss-Seidel; 1 µm is coarse, for the reference's benefit
_STEPS = 220  # whose stages are timed
_WOBBLE = 0.02  # of the tensions from step to step, so that contact forces have to be found again


@dataclass(frozen=True, slots=True)
class Speed:
    """Median step times in one posture, tensions up and down by a fiftieth.

    Attributes:
        candidates: n_c.
        posture: "straight" or "bent".
        in_range: candidates within the alarm distance.
        pushing: candidates that push.
        gauss_seidel_ms: forward step, all candidates in range as rows, projected Gauss-Seidel (13) from
            the forces of the step before.
        sweeps: of it, median.
        gauss_seidel_converged: whether it met its tolerance in every step.
        full_ms: forward step of this package's own solver of pointwise contact.
        reduced_ms: forward step with the basis and certified gaps.
        control_full_ms: control step, target to advanced model, with pointwise contact.
        control_reduced_ms: the same with the basis and certified gaps.
        control_reduced_p99_ms: its 99th percentile.
    """

    candidates: int
    posture: str
    in_range: int
    pushing: int
    gauss_seidel_ms: float
    sweeps: int
    gauss_seidel_converged: bool
    full_ms: float
    reduced_ms: float
    control_full_ms: float
    control_reduced_ms: float
    control_reduced_p99_ms: float


def measure_speed(robot: Robot, basis: ContactBasis, effort: Array, posture: str) -> Speed:
    """Times of steps of all kinds around an equilibrium.

    Args:
        robot: the arm.
        basis: its contact basis.
        effort: (n_a,) of the equilibrium [N].
        posture: its name.
    """
    there = arm_in_equilibrium(robot, effort)
    enrichment = default_enrichment(robot.tolerance)
    sweeps: list[int] = []
    good: list[bool] = []
    start, wobbling = there.lam_c, wobble(effort)

    def gauss_seidel() -> None:
        nonlocal start
        start, count, converged = gauss_seidel_step(there, next(wobbling), start)
        sweeps.append(count)
        good.append(converged)

    reduced = times(_control(there, basis), 200)
    return Speed(
        candidates=robot.n_c,
        posture=posture,
        in_range=int(np.isfinite(there.gaps).sum()),
        pushing=int((there.lam_c > 0.0).sum()),
        gauss_seidel_ms=float(np.median(times(gauss_seidel, 5, warm_up=1))),
        sweeps=int(np.median(sweeps)),
        gauss_seidel_converged=all(good),
        full_ms=float(np.median(times(_forward(there, "full", None, effort), 60))),
        reduced_ms=float(np.median(times(_forward(there, basis, enrichment, effort), 100))),
        control_full_ms=float(np.median(times(_control(there, "full"), 60))),
        control_reduced_ms=float(np.median(reduced)),
        control_reduced_p99_ms=float(np.percentile(reduced, 99)),
    )


def times(work: Callable[[], object], count: int, warm_up: int = 10) -> Array:
    """Times of repeated calls: (count,) [ms].

    Args:
        work: to call.
        count: calls to measure.
        warm_up: calls before them.
    """
    for _ in range(warm_up):
        work()
    found = np.empty(count)
    for i in range(count):
        start = perf_counter()
        work()
        found[i] = 1e3 * (perf_counter() - start)
    return found


def _forward(
    there: Simulator,
    contact: Literal["full"] | ContactBasis,
    enrichment: Enrichment | None,
    effort: Array,
) -> Callable[[], object]:
    simulator = Simulator(there.robot, contact, enrichment)
    simulator.start_from(there.state, replace(simulator.forces, effort=effort))
    wobbling = wobble(effort)
    return lambda: simulator.step(effort=next(wobbling))


def wobble(effort: Array) -> Iterator[Array]:
    """Tensions (n_a,) and a little less, in turns."""
    return cycle(((1.0 - _WOBBLE) * effort, effort))


def _control(there: Simulator, contact: Literal["full"] | ContactBasis) -> Callable[[], object]:
    """Steps of a controller that holds the tip where it is."""
    controller, goal = _controller(there, contact), there.effector
    return lambda: controller.step(goal)


def _controller(there: Simulator, contact: Literal["full"] | ContactBasis) -> Controller:
    controller = Controller(
        there.robot, contact, settings=load_controller_settings(there.robot.name)
    )
    none = np.zeros(0, dtype=np.int64)
    forces = Forces(there.effort, np.zeros(controller.space.k), none, np.zeros(0))
    controller.start_from(there.state, forces, there.position)
    return controller


def stage_times(robot: Robot, basis: ContactBasis, effort: Array) -> StepTimes:
    """Times of the stages of control steps that hold the tip at an equilibrium.

    Args:
        robot: the arm.
        basis: its contact basis.
        effort: (n_a,) of the equilibrium [N].
    """
    there = arm_in_equilibrium(robot, effort)
    targets = np.repeat(there.effector[None], _STEPS, axis=0)  # (s, p, 3)
    return time_controller(_controller(there, basis), f"reduced, k = {basis.k}", targets)


def gauss_seidel_step(there: Simulator, effort: Array, start: Array) -> tuple[Array, int, bool]:
    """A forward step as the paper takes it; the state is left where it is.

    Args:
        there: robot and state.
        effort: (n_a,) [N].
        start: (n_c,) forces to start from [N].

    Returns:
        Contact forces (n_c,), sweeps, whether the tolerance was met.
    """
    robot, state = there.robot, there.state
    system = robot.linearise(state, effort)
    rows = robot.rows(state)
    H = np.vstack([rows.actuators.dense(), rows.contacts.rows.dense()])
    delta = np.concatenate([rows.actuators.delta, rows.contacts.rows.delta])
    response, slots = row_compliance(system, H, delta), rows.contacts.slots
    layout = row_layout(0, robot.n_a)
    a, c = layout.actuators, layout.contacts
    gaps = response.delta_free[c] + response.W[c, a] @ effort
    found = solve_pgs(response.W[c, c], gaps, start[slots], _TOLERANCE, _SWEEPS)
    response.pushed(np.concatenate([effort, found.lam]))
    forces = np.zeros(robot.n_c)
    forces[slots] = found.lam
    return forces, found.iterations, found.converged
