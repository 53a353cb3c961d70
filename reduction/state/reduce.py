"""From a campaign's snapshots to a state basis and its sample of elements, compared with held-out paths."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Literal

import numpy as np

from tauten.model import ContactSpace, Robot, default_enrichment, one_blas_thread
from tauten.model.numerics import Array, Bools
from tauten.reduction.campaign import Snapshots
from tauten.reduction.contact import TipErrors, tip_errors
from tauten.reduction.provenance import package_versions
from tauten.reduction.reduced_robot import ElementSample, StateBasisError
from tauten.reduction.state.basis import StateBasis, StateOrigin
from tauten.reduction.state.bodies import reducible
from tauten.reduction.state.modes import (
    Pod,
    campaign_responses,
    enriched,
    pod,
    with_own,
    without_own,
)
from tauten.reduction.state.robot import reduced_robot

HELD_OUT = 5  # every fifth run, or snapshot of few runs, is held out of the training
MANY_RUNS = 20  # from so many runs on, what is held out has neighbours in the training
MOST_MODES = 100  # largest r
CHECKS = 200  # largest number of held-out equilibria compared


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
    """

    r: int | Literal["auto"] = "auto"
    motion: float | None = None
    responses: int = 10
    sample: float = 1e-2
    seed: int = 0

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
    robot: Robot, snapshots: Snapshots, basis: ContactSpace, settings: StateSettings
) -> StateBasis:
    """A state basis, its sample of elements, and its tip errors on equilibria that were held out.

    All linear algebra runs on one thread, so that the same snapshots give the same basis to the last bit.

    Args:
        robot: the full model.
        snapshots: a campaign's converged equilibria, with their configurations.
        basis: contact modes of the controller that will use the reduced model.
        settings: numbers of modes and tolerances.

    Raises:
        StateBasisError: a robot that has no state bases, snapshots without configurations, or
            a reduced model that does not find its equilibria.
    """
    n_q = len(robot.rest().q)
    if len(snapshots.q) != n_q or len(snapshots) < HELD_OUT:
        raise StateBasisError(
            f"{len(snapshots)} snapshots with {len(snapshots.q)} coordinates: "
            f"expected at least {HELD_OUT} with {n_q}"
        )
    with one_blas_thread():  # the order of sums depends on the number of threads
        return _reduced(robot.fork(), snapshots, basis, settings)


def n_elements(robot: Robot) -> int:
    """Number of elements that a sample is taken from.

    Raises:
        StateBasisError: a robot that has no state bases.
    """
    return reducible(robot).n_elements


def _reduced(
    robot: Robot, snapshots: Snapshots, basis: ContactSpace, settings: StateSettings
) -> StateBasis:
    """As `reduce_states`, arguments checked."""
    body = reducible(robot)
    held_out = held_out_snapshots(snapshots)
    training = snapshots.select(~held_out)
    deviations, weight = body.deviations(training.q), body.weight  # (m, s), (m,)
    allowed = body.default_motion if settings.motion is None else settings.motion
    modal = without_own(body, deviations)
    found = chosen_modes(pod(modal, weight, MOST_MODES), settings.r, allowed)
    Phi = found.Phi
    if settings.responses:
        directions = campaign_responses(robot, body, basis, training)[:, : settings.responses]
        Phi = enriched(Phi, directions, weight)
    Phi = with_own(body, Phi)
    alphas = Phi.T @ (weight[:, None] * deviations)  # (r, s)
    sample = body.sample(Phi, alphas, settings.sample, settings.seed)
    responses = Phi.shape[1] - found.Phi.shape[1] - body.own_coordinates
    origin = origin_of(robot, training, snapshots.digest(), found, responses, sample, settings)
    states = StateBasis(Phi, sample.elements, sample.weights, origin)
    return checked_on_held_out(robot, states, basis, snapshots.select(held_out))


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

    Args:
        robot: the full model.
        states: state basis and sample.
        basis: contact modes.
        held_out: equilibria of the full model.
    """
    tolerance = robot.tolerance
    enrichment = default_enrichment(tolerance)
    return tip_errors(reduced_robot(robot, states), held_out, basis, enrichment)


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
            f"the model of {states.r} state modes and {len(states.elements)} elements converges at only "
            f"{len(found)} of {len(errors.error)} held-out equilibria: use more modes, or a smaller "
            "residual of the sample"
        )
    return states.with_tip_errors(float(found.mean()), float(found.max()))
