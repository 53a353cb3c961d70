"""Attempts at a state basis: what each came to, what a time step costs, and the sentence of a refusal."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from statistics import median

import numpy as np

from tauten.model import ContactSpace, Robot, Simulator, default_enrichment, one_blas_thread
from tauten.reduction.reduced_body import StateBasisError
from tauten.reduction.state.basis import StateBasis, reduced_robot

STEPS = 5  # that are timed, of each model
FAST = 5e-3  # s; no full model with faster steps makes a reduced one useless
SLOWER = 1.2  # how much slower a reduced step is than a full one before it counts as slower


@dataclass(frozen=True, slots=True)
class ModelTimes:
    """Processor time of a time step from rest, with contact modes, on one thread.

    Attributes:
        full: of the full model [s].
        reduced: of the reduced model [s].
    """

    full: float
    reduced: float

    @property
    def slower(self) -> bool:
        """Whether a step of the reduced model takes longer than one of the full model."""
        return self.reduced > SLOWER * self.full

    @property
    def useless(self) -> bool:
        """Whether it does, and steps of the full model are not fast either."""
        return self.full > FAST and self.slower

    def __str__(self) -> str:
        return (
            f"a time step takes {1e3 * self.reduced:.3g} ms of processor time, "
            f"one of the full model {1e3 * self.full:.3g} ms"
        )


def step_times(robot: Robot, states: StateBasis, basis: ContactSpace) -> ModelTimes:
    """Median times of steps of the full and the reduced model, alternating, with the same contact modes."""
    enrichment = default_enrichment(robot.tolerance)
    models = (robot, reduced_robot(robot, states))
    simulators = [Simulator(model, basis, enrichment) for model in models]
    rest = robot.actuators.laws.held(np.zeros(robot.n_a), np.zeros(robot.n_a))
    taken: list[list[float]] = [[], []]
    with one_blas_thread():
        for _ in range(1 + STEPS):  # the first one loads kernels
            for simulator, times in zip(simulators, taken, strict=True):
                simulator.reset()
                start = time.process_time()
                simulator.step(rest.position, rest.effort)
                times.append(time.process_time() - start)
    full, reduced = (median(times[1:]) for times in taken)
    return ModelTimes(full, reduced)


@dataclass(frozen=True, slots=True)
class Attempt:
    """A state basis with errors on held-out equilibria, NaN where too few were found; or a failure."""

    states: StateBasis
    failure: str = ""

    def within(self, share: float) -> Attempt:
        """The same of a basis for a share of the actuators' positions."""
        origin = replace(self.states.origin, position_share=share)
        return replace(self, states=replace(self.states, origin=origin))

    def __str__(self) -> str:
        origin = self.states.origin
        size = f"{origin.r} modes and {origin.sample} elements"
        if origin.position_share < 1.0:
            size += f" within {origin.position_share:.0%} of the positions"
        if self.failure:
            return f"{size} {self.failure}"
        return (
            f"{size} take the tip up to {1e3 * origin.tip_max:.3g} mm "
            f"(mean {1e3 * origin.tip_mean:.3g} mm) away"
        )


def best_of(attempts: list[Attempt], goal: float | None, times: ModelTimes | None) -> StateBasis:
    """The basis with the smallest error on held-out equilibria.

    Args:
        attempts: all that were made, at least one.
        goal: largest error of the tip that is allowed [m]; None: any.
        times: of a step with the basis of the last attempt, where they were measured.

    Raises:
        StateBasisError: there is none, or its error is larger than the goal.
    """
    found = [attempt.states for attempt in attempts if not attempt.failure]
    best = min(found, key=lambda states: states.origin.tip_max, default=None)
    if best is not None and (goal is None or best.origin.tip_max <= goal):
        return best
    origin = attempts[-1].states.origin
    allowed = "" if goal is None else f", where {1e3 * goal:.3g} mm are allowed"
    text = (
        f"no state basis of robot {origin.robot} from {origin.snapshots} snapshots follows the full model at "
        f"held-out loads{allowed}. {len(attempts)} tried: {'; '.join(map(str, attempts))}"
    )
    if times is not None:
        text += f". With the last one {times}"
    if times is not None and times.slower:
        text += ". Serve the full model"
    else:
        text += ". Use more modes, a finer sample or a wider campaign"
    raise StateBasisError(
        f"{text}, narrow the limits of the actuators, or accept the error of a state basis"
    )
