"""From a robot and a design to a contact basis: what `tauten reduce` does."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal

from tauten.model import Robot
from tauten.reduction.campaign import Design, Snapshots, run_campaign
from tauten.reduction.contact.basis import ContactBasis
from tauten.reduction.contact.fit import BASIS_METHODS, BasisMethod, Fit, Quality, fit_each, quality
from tauten.reduction.contact.mode_count import ChoiceError, Curve, choose_k, cross_validate, folds
from tauten.reduction.contact.positive_basis import checked
from tauten.reduction.contact.problems import contact_problems
from tauten.reduction.contact.weighting import WEIGHTINGS, Weighting, snapshot_weights
from tauten.reduction.provenance import CurvePoint, Provenance, versions

TOLERANCE = 1e-3  # of the robot's size: the effector error that "auto" accepts


@dataclass(frozen=True, slots=True)
class ReduceSettings:
    """How a basis is made from snapshots.

    Attributes:
        k: number of modes; "auto" for the smallest within `tolerance`.
        method: see `fit_each`.
        weighting: how much each snapshot counts, see `snapshot_weights`.
        tolerance: held-out effector error that "auto" accepts [m]; None for 1/1000 of the robot.
        seed: of the factorisation.
        curve: find the error against k even where k is given.
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
    """What a reduction gives.

    Attributes:
        basis: the contact basis.
        snapshots: what it was made from, the converged ones.
        skipped: number of equilibria that did not converge and were left out.
        curve: error against k, when k was to be chosen.
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
    show_progress: bool = True,
) -> Reduction:
    """Run the campaign, or take what the folder holds of it, and make a basis from it.

    Args:
        robot: what the basis is for.
        design: what the robot is shown.
        folder: where the campaign is kept.
        settings: how the basis is made.
        executor: see `tauten.reduction.campaign.executors`; None works in this process.
        show_progress: draw a bar on the terminal.

    Raises:
        SnapshotError: the folder holds another campaign, or a damaged file.
        ChoiceError: no contact at all, k beyond the rank, no k within the tolerance.
    """
    if robot.n_c == 0:
        raise ChoiceError(
            f"robot {robot.name} has no contact candidates: there is nothing to reduce"
        )
    everything = run_campaign(robot, design, folder, executor, show_progress)
    snapshots = everything.select(everything.converged)
    try:
        basis, curve = make_basis(robot, snapshots, settings)
    except ValueError as error:
        raise ChoiceError(f"{folder}: {error}") from error
    return Reduction(basis, snapshots, len(everything) - len(snapshots), curve)


def make_basis(
    robot: Robot, snapshots: Snapshots, settings: ReduceSettings
) -> tuple[ContactBasis, Curve | None]:
    """A basis from snapshots, and the error against k if it was found.

    Raises:
        ValueError: as `factorise`: no contact at all, k beyond the rank.
        ChoiceError: no k is within the tolerance.
    """
    weights = snapshot_weights(checked(snapshots.lam), settings.weighting)
    S, method, seed = snapshots.lam * weights, settings.method, settings.seed
    problems = contact_problems(robot, snapshots)
    curve, k = None, settings.k
    if k == "auto" or settings.curve:
        curve = cross_validate(S, folds(snapshots), problems, method=method, seed=seed)
    if k == "auto":
        assert curve is not None
        k = choose_k(curve, settings.tolerance or TOLERANCE * robot.size)
    (fit,) = fit_each(S, problems, (k,), method, seed)
    found = quality(fit.Psi, problems)
    return ContactBasis(fit.Psi, provenance(robot, snapshots, settings, fit, found, curve)), curve


def provenance(
    robot: Robot,
    snapshots: Snapshots,
    settings: ReduceSettings,
    fit: Fit,
    found: Quality,
    curve: Curve | None = None,
) -> Provenance:
    """Where a basis made from these snapshots by this fit comes from."""
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
        versions=versions(),
    )
