"""From a robot and a design to a contact basis: what `tauten reduce` does."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal

from tauten.model.robot import Robot
from tauten.reduction.campaign import run_campaign
from tauten.reduction.choose import Curve, choose_k, cross_validate, folds
from tauten.reduction.contact_basis import ContactBasis
from tauten.reduction.designs import Design
from tauten.reduction.positive_basis import Factorisation, Method, factorise
from tauten.reduction.provenance import Provenance, versions
from tauten.reduction.snapshots import Snapshots
from tauten.reduction.weighting import Weighting, snapshot_weights


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
    k: int | Literal["auto"] = 5,
    method: Method = "hals",
    seed: int = 0,
    weighting: Weighting = "equal",
    tolerance: float = 0.1,
    executor: Executor | None = None,
    show_progress: bool = True,
) -> Reduction:
    """Run the campaign, or take what the folder holds of it, and make a basis from it.

    Args:
        robot: what the basis is for.
        design: what the robot is shown.
        folder: where the campaign is kept.
        k: number of modes; "auto" for the smallest within `tolerance`.
        method: of factorisation, see `factorise`.
        seed: of the factorisation.
        weighting: how much each snapshot counts, see `snapshot_weights`.
        tolerance: held-out relative force error that "auto" accepts.
        executor: see `tauten.reduction.executors`; None works in this process.
        show_progress: draw a bar on the terminal.

    Raises:
        SnapshotError: the folder holds another campaign, or a damaged file.
        ChoiceError: no k is within the tolerance.
        ValueError: as `factorise`: no contact at all, k beyond the rank.
    """
    everything = run_campaign(robot, design, folder, executor, show_progress)
    snapshots = everything.select(everything.converged)
    curve = None
    if k == "auto":
        curve = cross_validate(
            snapshots.lam, folds(snapshots), method=method, seed=seed, weighting=weighting
        )
        k = choose_k(curve, tolerance)
    weights = snapshot_weights(snapshots.lam, weighting)
    found = factorise(snapshots.lam * weights, k, method, seed)
    basis = ContactBasis(found.Psi, provenance(robot, snapshots, found, weighting, curve))
    return Reduction(basis, snapshots, len(everything) - len(snapshots), curve)


def provenance(
    robot: Robot,
    snapshots: Snapshots,
    found: Factorisation,
    weighting: Weighting,
    curve: Curve | None = None,
) -> Provenance:
    """Where a basis made from these snapshots by this factorisation comes from."""
    pairs = [] if curve is None else zip(curve.k.tolist(), curve.held_out.tolist(), strict=True)
    return Provenance(
        robot=robot.name,
        robot_digest=robot.digest,
        campaign=snapshots.origin.campaign,
        snapshots_digest=snapshots.digest(),
        snapshots=len(snapshots),
        weighting=weighting,
        method=found.method,
        k=found.k,
        seed=found.seed,
        error=found.error,
        curve=tuple(pairs),
        created=datetime.now(UTC).isoformat(timespec="seconds"),
        versions=versions(),
    )
