"""From a robot and a design to a contact basis, as in `tauten reduce`."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal

from tauten.model import Robot, one_blas_thread
from tauten.reduction.campaign import (
    Design,
    Report,
    Snapshots,
    TouchedRobot,
    of_plain_robot,
    run_campaign,
)
from tauten.reduction.contact.basis import ContactBasis
from tauten.reduction.contact.fit import (
    BASIS_METHODS,
    WEIGHTINGS,
    BasisMethod,
    BasisQuality,
    Fit,
    Weighting,
    fit_each,
    quality,
    snapshot_weights,
)
from tauten.reduction.contact.mode_count import ChoiceError, Curve, choose_k, cross_validate, folds
from tauten.reduction.contact.positive_basis import checked_forces
from tauten.reduction.contact.problems import contact_problems
from tauten.reduction.provenance import CurvePoint, Provenance, package_versions

TOLERANCE = 1e-3  # effector error that "auto" allows, relative to the size of the robot


@dataclass(frozen=True, slots=True)
class ReduceSettings:
    """Settings for making a basis from snapshots.

    Attributes:
        k: number of modes; "auto" for the smallest within `tolerance`, and without one, where none is within
            1/1000 of the robot, for that with the least error.
        method: see `fit_each`.
        weighting: of the snapshots, see `snapshot_weights`.
        tolerance: held-out effector error that "auto" allows [m]; None for 1/1000 of the robot.
        seed: of the factorisation.
        curve: compute the error against k even where k is given.
    """

    k: int | Literal["auto"] = "auto"
    method: BasisMethod = "energy"
    weighting: Weighting = "equal"
    tolerance: float | None = None
    seed: int = 0
    curve: bool = False

    def __post_init__(self) -> None:
        if self.method not in BASIS_METHODS:
            raise ChoiceError(
                f"method {self.method!r} is unknown: choose one of {', '.join(BASIS_METHODS)}"
            )
        if self.weighting not in WEIGHTINGS:
            raise ChoiceError(
                f"weighting {self.weighting!r} is unknown: choose one of {', '.join(WEIGHTINGS)}"
            )
        if self.k != "auto" and self.k < 1:
            raise ChoiceError(f"k is {self.k}: allowed are 1 and more, and auto")
        if self.tolerance is not None and not self.tolerance > 0.0:
            raise ChoiceError(f"tolerance is {self.tolerance} m: it must be positive")


@dataclass(frozen=True, slots=True, eq=False)
class Reduction:
    """Result of a reduction.

    Attributes:
        basis: the contact basis.
        snapshots: the converged snapshots of the campaign.
        skipped: number of equilibria that did not converge and were omitted.
        curve: error against k, if it was computed.
    """

    basis: ContactBasis
    snapshots: Snapshots
    skipped: int
    curve: Curve | None


def reduce_robot(
    robot: Robot,
    design: Design,
    folder: str | Path,
    settings: ReduceSettings,
    executor: Executor | None = None,
    touched: TouchedRobot | None = None,
    report: Report = lambda share, what: None,
) -> Reduction:
    """Run the campaign, or load its saved chunks from the folder, and make a basis from it.

    Args:
        robot: the robot.
        design: runs of excitations.
        folder: of the saved campaign.
        settings: number of modes, method, weighting.
        executor: see `tauten.reduction.campaign.executors`; None computes in this process.
        touched: the robot with spheres, where the design presses it with them; the basis is made from
            snapshots without.
        report: called after the campaign, as by `reduce_snapshots`.

    Raises:
        SnapshotError: the folder holds another campaign, or a damaged file.
        ChoiceError: no contact, k beyond the rank, no k within the tolerance.
    """
    if robot.n_c == 0:
        raise ChoiceError(
            f"robot {robot.name} has no contact candidates: there is nothing to reduce"
        )
    moved = robot if touched is None else touched.robot
    everything = run_campaign(moved, design, folder, executor)
    return reduce_snapshots(robot, everything, folder, settings, touched, report)


def reduce_snapshots(
    robot: Robot,
    everything: Snapshots,
    folder: str | Path,
    settings: ReduceSettings,
    touched: TouchedRobot | None = None,
    report: Report = lambda share, what: None,
) -> Reduction:
    """A basis from all equilibria of a campaign.

    Args:
        robot: the robot.
        everything: that the campaign computed, converged or not.
        folder: that has them, for errors.
        settings: number of modes, method, weighting.
        touched: the robot with spheres that the campaign was of.
        report: called with the share that is done since the last call, and with what is being done.

    Raises:
        ChoiceError: no contact, k beyond the rank, no k within the tolerance.
    """
    snapshots = everything.select(everything.converged)
    own = snapshots if touched is None else of_plain_robot(touched, snapshots)
    try:
        basis, curve = make_basis(robot, own, settings, report)
    except ValueError as error:
        raise ChoiceError(f"{folder}: {error}") from error
    return Reduction(basis, snapshots, len(everything) - len(snapshots), curve)


def make_basis(
    robot: Robot,
    snapshots: Snapshots,
    settings: ReduceSettings,
    report: Report = lambda share, what: None,
) -> tuple[ContactBasis, Curve | None]:
    """A basis from snapshots, and the error against k if it was computed.

    All linear algebra runs on one thread, so that the same snapshots give the same basis to the last bit.

    Args:
        robot: the robot of the snapshots.
        snapshots: converged equilibria [N, m].
        settings: number of modes, method, weighting.
        report: called with the share that is done since the last call, and with what is being done.

    Raises:
        ValueError: as `factorise`: no contact, k beyond the rank.
        ChoiceError: no k is within the tolerance.
    """
    weights = snapshot_weights(checked_forces(snapshots.lam), settings.weighting)
    S, method, seed = snapshots.lam * weights, settings.method, settings.seed
    with one_blas_thread():  # the order of sums depends on the number of threads
        report(0.0, "contact problems")
        problems = contact_problems(robot, snapshots)
        curve, k, fewer = None, settings.k, list[int]()
        if k == "auto" or settings.curve:
            curve = cross_validate(
                S, folds(snapshots), problems, method=method, seed=seed, report=report
            )
        if k == "auto":
            assert curve is not None
            given = settings.tolerance
            k = choose_k(curve, given or TOLERANCE * robot.size, needed=given is not None)
            fewer = curve.k[curve.k < k].tolist()  # as good a start as in the curve
        report(0.0, f"{k} contact modes")
        fit = fit_each(S, problems, (*fewer, k), method, seed)[-1]
        found, by_effort = quality(fit.Psi, problems), None
        if robot.actuators.laws.held_by_force.any():
            by_effort = quality(fit.Psi, contact_problems(robot, snapshots, as_held=True)).tip
        origin = provenance(robot, snapshots, settings, fit, found, curve)
    return ContactBasis(fit.Psi, replace(origin, tip_error_as_held=by_effort)), curve


def provenance(
    robot: Robot,
    snapshots: Snapshots,
    settings: ReduceSettings,
    fit: Fit,
    found: BasisQuality,
    curve: Curve | None = None,
) -> Provenance:
    """Origin of a basis made from converged snapshots by a fit, with the errors that were computed."""
    points: list[CurvePoint] = []
    if curve is not None:
        columns = (curve.k, curve.training, curve.held_out, curve.force, curve.tip)
        rows = zip(*(column.tolist() for column in columns), strict=True)
        points = [CurvePoint(*row) for row in rows]
    return Provenance(
        robot=robot.name,
        robot_digest=robot.digest,
        campaign=snapshots.origin.campaign,
        snapshots_digest=snapshots.digest(),
        snapshots=len(snapshots),
        weighting=settings.weighting,
        method=settings.method,
        k=fit.k,
        seed=settings.seed,
        error=fit.error,
        energy_error=found.energy,
        tip_error=found.tip,
        curve=tuple(points),
        created=datetime.now(UTC).isoformat(timespec="seconds"),
        versions=package_versions(),
    )
