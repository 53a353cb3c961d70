"""From a campaign's snapshots to a state basis and its sample of elements, compared with held-out paths."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import Literal

import numpy as np

from tauten.model import ContactSpace, Robot, default_enrichment, one_blas_thread
from tauten.model.numerics import Array, Bools
from tauten.reduction.campaign import Snapshots
from tauten.reduction.contact import TipErrors, tip_errors
from tauten.reduction.provenance import package_versions
from tauten.reduction.reduced_body import ElementSample, Reducible, StateBasisError
from tauten.reduction.state.basis import StateBasis, StateOrigin
from tauten.reduction.state.bodies import reducible
from tauten.reduction.state.modes import (
    Pod,
    campaign_responses,
    enriched,
    even_weights,
    pod,
    with_own,
    without_own,
)
from tauten.reduction.state.robot import reduced_robot

HELD_OUT = 5  # every fifth run, or snapshot of few runs, is held out of the training
MANY_RUNS = 20  # from so many runs on, what is held out has neighbours in the training
MOST_MODES = 100  # largest r
MOST_ELEMENTS = 1500  # of a sample, from which on no finer one is tried
CHECKS = 100  # largest number of held-out equilibria compared
ATTEMPTS = 4  # at most, until the error on held-out equilibria is within the goal
FINER_MOTION, FINER_SAMPLE = (
    0.4,
    0.5,
)  # what an attempt may leave out, of what the last one left out

Report = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class StateSettings:
    """How a state basis is made.

    Attributes:
        r: modes of motion; "auto" for the fewest with a projection error within `motion`.
        motion: relative root mean square projection error that "auto" allows; None: as much as suits the
            norm of the robot.
        responses: static responses added to them, strongest direction first.
        sample: relative residual of the sampled elements, see `tauten.reduction.state.tetra.ecsw`.
        seed: of the random directions.
        goal: error of the tip on held-out equilibria [m] above which more elements, and with "auto" more
            modes, are tried up to a budget; None: whatever the error is.
    """

    r: int | Literal["auto"] = "auto"
    motion: float | None = None
    responses: int = 10
    sample: float = 1e-2
    seed: int = 0
    goal: float | None = None

    def __post_init__(self) -> None:
        if self.r != "auto" and self.r < 1:
            raise StateBasisError(f"{self.r} state modes: allowed are 1 and more, and auto")
        motion = 0.5 if self.motion is None else self.motion
        if not 0.0 < motion < 1.0 or not 0.0 < self.sample < 1.0 or self.responses < 0:
            raise StateBasisError(
                f"motion left out {self.motion}, sample residual {self.sample}, {self.responses} "
                "responses: allowed are shares of 0 to 1, without the ends, and no negative number"
            )


def reduce_states(
    robot: Robot,
    snapshots: Snapshots,
    basis: ContactSpace,
    settings: StateSettings,
    report: Report = lambda _: None,
) -> StateBasis:
    """A state basis, its sample of elements, and its tip errors on equilibria that were held out.

    Where the errors are above the goal of the settings, modes and elements are chosen again, to leave out
    less, until the goal, the budget or the last attempt is reached. The basis with the smallest error
    counts.

    All linear algebra runs on one thread, so that the same snapshots give the same basis to the last bit.

    Args:
        robot: the full model.
        snapshots: a campaign's converged equilibria, with their configurations.
        basis: contact modes of the controller that will use the reduced model.
        settings: numbers of modes and tolerances.
        report: called with what is being done, in words.

    Raises:
        StateBasisError: a robot that has no state bases, snapshots without configurations, or
            reduced models that do not find their equilibria.
    """
    n_q = len(robot.rest().q)
    if len(snapshots.q) != n_q or len(snapshots) < HELD_OUT:
        raise StateBasisError(
            f"{len(snapshots)} snapshots with {len(snapshots.q)} coordinates: "
            f"expected at least {HELD_OUT} with {n_q}"
        )
    with one_blas_thread():  # the order of sums depends on the number of threads
        return _best(robot.fork(), snapshots, basis, settings, report)


def n_elements(robot: Robot) -> int:
    """Number of elements that a sample is taken from.

    Raises:
        StateBasisError: a robot that has no state bases.
    """
    return reducible(robot).n_elements


def _best(
    robot: Robot,
    snapshots: Snapshots,
    basis: ContactSpace,
    settings: StateSettings,
    report: Report,
) -> StateBasis:
    """As `reduce_states`, arguments checked."""
    report("modes of motion and responses")
    training = _training(robot, snapshots, basis)
    held_out = snapshots.select(held_out_snapshots(snapshots))
    motion = training.body.default_motion if settings.motion is None else settings.motion
    sample, best, failure = settings.sample, None, None
    for attempt in range(1, 1 + (ATTEMPTS if settings.goal is not None else 1)):
        tried = replace(settings, motion=motion, sample=sample)
        states = _chosen(robot, training, tried, snapshots.digest(), attempt, report)
        report(
            f"attempt {attempt}: {states.r} modes, {len(states.elements)} elements, held-out loads"
        )
        try:
            states = checked_on_held_out(robot, states, basis, held_out)
        except StateBasisError as error:
            failure = error
        else:
            if best is None or states.origin.tip_max < best.origin.tip_max:
                best = states
        met = (
            best is not None and settings.goal is not None and best.origin.tip_max <= settings.goal
        )
        spent = len(states.elements) >= min(MOST_ELEMENTS, training.body.n_elements)
        if met or spent:
            break
        motion, sample = motion * FINER_MOTION, sample * FINER_SAMPLE
    if best is None:
        assert failure is not None
        raise StateBasisError(f"{failure}; {attempt} attempts were made") from failure
    return best


@dataclass(frozen=True, slots=True, eq=False)
class _Training:
    """What modes and elements are chosen from.

    Attributes:
        body: the robot as state reduction sees it.
        snapshots: those that are not held out.
        deviations: (m, s) from rest.
        modes: all that may be used, strongest first.
        responses: (m, k) directions of static responses, strongest first.
    """

    body: Reducible
    snapshots: Snapshots
    deviations: Array
    modes: Pod
    responses: Array


def _training(robot: Robot, snapshots: Snapshots, basis: ContactSpace) -> _Training:
    """Modes and responses of the snapshots that are not held out; each run counts the same.

    Args:
        robot: the full model.
        snapshots: of a campaign.
        basis: contact modes.
    """
    body = reducible(robot)
    training = snapshots.select(~held_out_snapshots(snapshots))
    deviations = body.deviations(training.q)  # (m, s)
    modal = without_own(body, deviations) * even_weights(training.run)
    modes = pod(modal, body.weight, MOST_MODES)
    return _Training(
        body, training, deviations, modes, campaign_responses(robot, body, basis, training)
    )


def _chosen(
    robot: Robot,
    training: _Training,
    settings: StateSettings,
    snapshots_digest: str,
    attempt: int,
    report: Report,
) -> StateBasis:
    """A state basis, its tip errors not measured.

    Args:
        robot: the full model.
        training: what it is chosen from.
        settings: numbers of modes and tolerances; `motion` is given.
        snapshots_digest: of all snapshots.
        attempt: its number, for the report.
        report: called with what is being done.
    """
    body, weight = training.body, training.body.weight
    assert settings.motion is not None
    found = chosen_modes(training.modes, settings.r, settings.motion)
    Phi = found.Phi
    if settings.responses:
        Phi = enriched(Phi, training.responses[:, : settings.responses], weight)
    Phi = with_own(body, Phi)
    report(f"attempt {attempt}: {Phi.shape[1]} modes, sample of the {body.n_elements} elements")
    alphas = Phi.T @ (weight[:, None] * training.deviations)  # (r, s)
    sample = body.sample(Phi, alphas, settings.sample, settings.seed)
    responses = Phi.shape[1] - found.Phi.shape[1] - body.own_coordinates
    origin = origin_of(
        robot, training.snapshots, snapshots_digest, found, responses, sample, settings
    )
    return StateBasis(Phi, sample.elements, sample.weights, origin)


def origin_of(
    robot: Robot,
    training: Snapshots,
    snapshots_digest: str,
    modes: Pod,
    responses: int,
    sample: ElementSample,
    settings: StateSettings,
) -> StateOrigin:
    """Origin of a state basis, its tip errors not measured.

    Args:
        robot: the full model.
        training: the snapshots of the training.
        snapshots_digest: of all snapshots.
        modes: modes of motion.
        responses: number of static responses.
        sample: sampled elements.
        settings: tolerances and seed.
    """
    return StateOrigin(
        robot=robot.name,
        robot_digest=robot.digest,
        campaign=training.origin.campaign,
        snapshots_digest=snapshots_digest,
        snapshots=len(training),
        r=modes.Phi.shape[1] + responses + reducible(robot).own_coordinates,
        responses=responses,
        projection_error=modes.error,
        sample=len(sample.elements),
        sample_tolerance=settings.sample,
        sample_error=sample.error,
        tip_mean=float("nan"),
        tip_max=float("nan"),
        seed=settings.seed,
        created=datetime.now(UTC).isoformat(timespec="seconds"),
        versions=package_versions(),
    )


def held_out_snapshots(snapshots: Snapshots) -> Bools:
    """Which snapshots are held out of the training: (s,) bool; whole runs where there are enough."""
    runs = np.unique(snapshots.run)
    if len(runs) >= MANY_RUNS:
        held: Bools = np.searchsorted(runs, snapshots.run) % HELD_OUT == HELD_OUT - 1
    else:
        held = np.arange(len(snapshots)) % HELD_OUT == HELD_OUT - 1
    return held


def chosen_modes(found: Pod, r: int | Literal["auto"], allowed: float) -> Pod:
    """The first r modes, or for "auto" the fewest within the allowed projection error.

    Args:
        found: the modes.
        r: their number, or "auto".
        allowed: relative root mean square projection error.
    """
    if r == "auto":
        left_out = np.sqrt(
            np.cumsum(found.strength[::-1] ** 2)[::-1]
        )  # (rank,) by modes r, r + 1, …
        good = np.flatnonzero(left_out <= allowed * np.linalg.norm(found.strength))
        r = max(1, int(good[0])) if len(good) else found.Phi.shape[1]
    return Pod(np.ascontiguousarray(found.Phi[:, :r]), found.strength)


def check_errors(
    robot: Robot, states: StateBasis, basis: ContactSpace, held_out: Snapshots
) -> TipErrors:
    """Tip errors of the reduced model, with the enrichment of a controller, at full-order equilibria.

    At equal positions of the actuators, and where the robot holds some by their effort at equal efforts too,
    as of chambers at equal volume and at equal pressure: the larger of both.

    Args:
        robot: the full model.
        states: state basis and sample.
        basis: contact modes.
        held_out: equilibria of the full model.
    """
    tolerance = robot.tolerance
    enrichment = default_enrichment(tolerance)
    reduced = reduced_robot(robot, states)
    found = tip_errors(reduced, held_out, basis, enrichment)
    if not robot.actuators.laws.held_by_force.any():
        return found
    other = tip_errors(reduced, held_out, basis, enrichment, held="as held")
    return TipErrors(
        error=np.maximum(found.error, other.error),  # NaN where one of both was not found
        converged=found.converged & other.converged,
        extra_columns=np.maximum(found.extra_columns, other.extra_columns),
    )


def checked_on_held_out(
    robot: Robot, states: StateBasis, basis: ContactSpace, held_out: Snapshots
) -> StateBasis:
    """The basis with its tip errors on held-out equilibria.

    Args:
        robot: the full model.
        states: state basis without tip errors.
        basis: contact modes.
        held_out: equilibria of the full model.

    Raises:
        StateBasisError: the reduced model does not converge at half of them or more.
    """
    stride = -(-len(held_out) // CHECKS)
    errors = check_errors(
        robot, states, basis, held_out.select(np.arange(0, len(held_out), stride))
    )
    found: Array = errors.error[np.isfinite(errors.error)]
    if 2 * len(found) <= len(errors.error):
        raise StateBasisError(
            f"the model of {states.r} state modes and {len(states.elements)} elements, from "
            f"{states.origin.snapshots} snapshots, converges at only {len(found)} of {len(errors.error)} "
            "held-out equilibria: use more modes, or a smaller residual of the sample"
        )
    return states.with_tip_errors(float(found.mean()), float(found.max()))
