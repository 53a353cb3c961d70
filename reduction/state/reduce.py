"""From a campaign's snapshots to a state basis and its sample of elements, compared with held-out paths."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import partial
from typing import Literal

import numpy as np

from tauten.model import ContactSpace, Robot, one_blas_thread
from tauten.model.numerics import Array
from tauten.reduction.campaign import Report, Snapshots
from tauten.reduction.provenance import package_versions
from tauten.reduction.reduced_body import ElementSample, Reducible, StateBasisError
from tauten.reduction.state.attempts import Attempt, ModelTimes, best_of, step_times
from tauten.reduction.state.basis import StateBasis, StateOrigin
from tauten.reduction.state.bodies import reducible
from tauten.reduction.state.held_out import (
    CHOOSING,
    HELD_OUT,
    checked_on_held_out,
    held_out_snapshots,
    modes_suffice,
)
from tauten.reduction.state.modes import (
    Pod,
    campaign_responses,
    enriched,
    even_weights,
    pod,
    touched_responses,
    with_own,
    without_own,
)

FIRST_MODES, MOST_MODES = 100, 200  # largest r of the first attempt, and of further ones
MOST_ELEMENTS = 3000  # of a sample, from which on no finer one is tried
ATTEMPTS = 6  # at most, until the error on held-out equilibria is within the goal
FAR = 10.0  # times the goal, above which an error with `FIRST_MODES` is not mended by more modes
STALLED = 0.9  # of the error of the last attempt, above which more elements alone are of no use
RANGES = (1.0, 0.5, 0.25)  # of the positions of a campaign, tried one after the other
CAMPAIGN = 0.5  # of the time of a smaller range, for its campaign
# What an attempt may leave out, of what the last one left out.
FINER_MOTION, FINER_SAMPLE = 0.25, 0.3
LEAST_MOTION = 1e-9  # left out, below which there are no more modes


Narrower = Callable[
    [float, Report], Snapshots
]  # of another campaign, within a share of the positions of the first one


@dataclass(frozen=True, slots=True)
class StateSettings:
    """How a state basis is made.

    Attributes:
        r: modes of motion; "auto" for the fewest with a projection error within `motion`.
        motion: relative root mean square projection error that "auto" allows; None: as much as suits the
            norm of the robot.
        responses: static responses added to them, strongest direction first.
        touched: effectors, the last ones, whose static responses at rest are all added.
        sample: relative residual of the sampled elements, see `tauten.reduction.state.tetra.ecsw`.
        seed: of the random directions.
        goal: largest error of the tip on held-out equilibria [m]. Above it more elements, and with "auto"
            more modes, are tried up to a budget, and then smaller ranges of the actuators' positions; None:
            whatever the error is.
    """

    r: int | Literal["auto"] = "auto"
    motion: float | None = None
    responses: int = 10
    touched: int = 0
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
    report: Report = lambda share, what: None,
    narrower: Narrower | None = None,
) -> StateBasis:
    """A state basis, its sample of elements, and its tip errors on equilibria that were held out.

    Where the errors are above the goal of the settings, modes and elements are chosen again, to leave out
    less, until the goal is reached, the budget is spent, or steps of the reduced model take longer than
    those of the full one. Then campaigns within a half, and a quarter, of the actuators' positions take
    the place of the first one: a body that coils at the ends of its range needs more modes there than its
    motion elsewhere.

    All linear algebra runs on one thread, so that the same snapshots give the same basis to the last bit.

    Args:
        robot: the full model.
        snapshots: a campaign's converged equilibria, with their configurations.
        basis: contact modes of the controller that will use the reduced model.
        settings: numbers of modes and tolerances.
        report: called with the share that is done since the last call, and with what is being done.
        narrower: gives the converged equilibria of a campaign within a share of the positions, which it
            reports on as `report` does; None: only the whole range is tried.

    Raises:
        StateBasisError: a robot that has no state bases, snapshots without configurations,
            reduced models that do not find their equilibria, or errors above the goal; names what was tried.
    """
    n_q = len(robot.rest().q)
    if len(snapshots.q) != n_q or len(snapshots) < HELD_OUT:
        raise StateBasisError(
            f"{len(snapshots)} snapshots with {len(snapshots.q)} coordinates: "
            f"expected at least {HELD_OUT} with {n_q}"
        )
    with one_blas_thread():  # the order of sums depends on the number of threads
        return _best(robot.fork(), snapshots, basis, settings, report, narrower)


def _best(
    robot: Robot,
    snapshots: Snapshots,
    basis: ContactSpace,
    settings: StateSettings,
    report: Report,
    narrower: Narrower | None,
) -> StateBasis:
    """As `reduce_states`, arguments checked."""
    attempts: list[Attempt] = []
    times: ModelTimes | None = None
    goal = settings.goal
    ranges = RANGES if goal is not None and narrower is not None else RANGES[:1]
    for share in ranges:
        title = "" if share == 1.0 else f"within {share:.0%} of the positions, "
        part = partial(_part, report, 1.0 / len(ranges), title)
        within = snapshots
        if share < 1.0 and narrower is not None:
            within = narrower(share, partial(_part, part, CAMPAIGN, ""))
            part = partial(_part, part, 1.0 - CAMPAIGN, "")
        found, times = _attempts(robot, within, basis, settings, part)
        attempts += [one.within(share) for one in found]
        if goal is None or any(one.states.origin.tip_max <= goal for one in found):
            break
    return best_of(attempts, goal, times)


def _attempts(
    robot: Robot,
    snapshots: Snapshots,
    basis: ContactSpace,
    settings: StateSettings,
    report: Report,
) -> tuple[list[Attempt], ModelTimes | None]:
    """Attempts until one has an error within the goal, or another one is of no use; times of the last one."""
    report(0.0, "modes of motion and responses")
    training = _training(robot, snapshots, basis, settings.touched)
    held_out = snapshots.select(held_out_snapshots(snapshots))
    motion = training.body.default_motion if settings.motion is None else settings.motion
    sample, goal = settings.sample, settings.goal
    attempts: list[Attempt] = []
    times: ModelTimes | None = None
    most = ATTEMPTS if goal is not None else 1
    for number in range(1, 1 + most):
        part = partial(_part, report, 1.0 / most, f"attempt {number}: ")
        tried = replace(settings, motion=motion, sample=sample)
        limit = FIRST_MODES if number == 1 and settings.r == "auto" else MOST_MODES
        states = _chosen(robot, training, tried, limit, snapshots.digest(), part)
        part(CHOOSING, "")
        try:
            attempt = Attempt(checked_on_held_out(robot, states, basis, held_out, part, goal))
        except StateBasisError as error:
            attempt = Attempt(states, str(error))
        attempts.append(attempt)
        if goal is None or attempt.states.origin.tip_max <= goal:
            break
        times = step_times(robot, states, basis)
        every = len(states.elements) >= min(MOST_ELEMENTS, training.body.n_elements)
        if times.useless or every or stalled(attempts) or far(attempts[-1], goal):
            break
        part(0.0, "do modes or elements lack?")
        if settings.r == "auto" and not modes_suffice(robot, states, basis, held_out, goal):
            motion = finer_motion(training.modes, motion)
        else:
            sample *= FINER_SAMPLE
    return attempts, times


def finer_motion(modes: Pod, motion: float) -> float:
    """A smaller relative projection error, which takes more modes where there are any."""
    before = len(chosen_modes(modes, "auto", motion, MOST_MODES).Phi.T)
    while motion > LEAST_MOTION:
        motion *= FINER_MOTION
        if len(chosen_modes(modes, "auto", motion, MOST_MODES).Phi.T) > before:
            break
    return motion


def stalled(attempts: list[Attempt]) -> bool:
    """Whether the last two attempts are the same, or have all modes allowed and hardly another error."""
    if len(attempts) < 2:
        return False
    before, last = (one.states.origin for one in attempts[-2:])
    same = last.r == before.r and last.sample_tolerance == before.sample_tolerance
    full = last.r == before.r >= MOST_MODES
    return same or (full and last.tip_max > STALLED * before.tip_max)


def far(attempt: Attempt, goal: float) -> bool:
    """Whether an attempt with many modes is so far from the goal [m] that more of them do not reach it."""
    return attempt.states.origin.r >= FIRST_MODES and attempt.states.origin.tip_max > FAR * goal


def _part(report: Report, size: float, title: str, share: float, what: str) -> None:
    """Report a share of a part of the work, and what is done next where that is said."""
    report(size * share, title + what if what else "")


@dataclass(frozen=True, slots=True, eq=False)
class _Training:
    """What modes and elements are chosen from.

    Attributes:
        body: the robot as state reduction sees it.
        snapshots: those that are not held out.
        deviations: (m, s) from rest.
        modes: all that may be used, strongest first.
        touched: (m, 3 t) static responses of places that something touches.
        responses: (m, k) directions of static responses, strongest first.
    """

    body: Reducible
    snapshots: Snapshots
    deviations: Array
    modes: Pod
    touched: Array
    responses: Array


def _training(robot: Robot, snapshots: Snapshots, basis: ContactSpace, touched: int) -> _Training:
    """Modes and responses of the snapshots that are not held out; each run counts the same."""
    body = reducible(robot)
    training = snapshots.select(~held_out_snapshots(snapshots))
    deviations = body.deviations(training.q)  # (m, s)
    modal = without_own(body, deviations) * even_weights(training.run)
    modes = pod(modal, body.weight, MOST_MODES)
    local = touched_responses(robot, body, touched)
    others = campaign_responses(robot, body, basis, training)
    return _Training(body, training, deviations, modes, local, others)


def _chosen(
    robot: Robot,
    training: _Training,
    settings: StateSettings,
    limit: int,
    snapshots_digest: str,
    report: Report,
) -> StateBasis:
    """A state basis, its tip errors not measured."""
    body, weight = training.body, training.body.weight
    assert settings.motion is not None
    found = chosen_modes(training.modes, settings.r, settings.motion, limit)
    added = np.hstack([training.touched, training.responses[:, : settings.responses]])
    Phi = enriched(found.Phi, added, weight) if added.size > 0 else found.Phi
    Phi = with_own(body, Phi).astype(np.float32).astype(float)  # in half as large a file
    report(0.0, f"{Phi.shape[1]} modes, sample of the {body.n_elements} elements")
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
    """Origin of a state basis, its tip errors not measured."""
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


def chosen_modes(found: Pod, r: int | Literal["auto"], allowed: float, limit: int) -> Pod:
    """The first r modes, or for "auto" the fewest within the allowed projection error.

    Args:
        found: the modes.
        r: their number, or "auto".
        allowed: relative root mean square projection error.
        limit: largest number.
    """
    if r == "auto":
        left_out = np.sqrt(
            np.cumsum(found.strength[::-1] ** 2)[::-1]
        )  # (rank,) by modes r, r + 1, …
        good = np.flatnonzero(left_out <= allowed * np.linalg.norm(found.strength))
        r = max(1, int(good[0])) if len(good) else found.Phi.shape[1]
    return Pod(np.ascontiguousarray(found.Phi[:, : min(r, limit)]), found.strength)
