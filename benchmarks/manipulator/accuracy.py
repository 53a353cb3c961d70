"""Position error of reduced against pointwise contact over the number of modes: the paper's Fig. 12."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tauten.model import Robot, default_enrichment
from tauten.reduction import ContactBasis
from tauten.reduction.campaign import Snapshots
from tauten.reduction.contact import (
    BasisMethod,
    Weighting,
    contact_problems,
    fit_each,
    snapshot_weights,
    tip_errors,
)

_MAX_ITERATIONS = 200  # equilibria on the way are far apart

# The paper's way, weights included, and this package's default without and with certified gaps.
KINDS: tuple[tuple[BasisMethod, Weighting, bool], ...] = (
    ("als", "force", False),
    ("energy", "equal", False),
    ("energy", "equal", True),
)


@dataclass(frozen=True, slots=True)
class PostureError:
    """Tip of reduced against pointwise contact under the same tensions.

    Attributes:
        method: of the basis.
        k: its modes.
        certified: whether unit columns joined where gaps were deeper than the robot file's tolerance.
        postures: "training" or "held-out".
        mean_mm: mean error of the postures' ends.
        max_mm: largest.
        path_max_mm: largest, equilibria on the way to the postures included.
        extra_columns: largest number of unit columns in play.
        unsettled: equilibria that were not found.
    """

    method: str
    k: int
    certified: bool
    postures: str
    mean_mm: float
    max_mm: float
    path_max_mm: float
    extra_columns: int
    unsettled: int


def errors_over_k(
    robot: Robot,
    shipped: ContactBasis,
    campaign: Snapshots,
    postures: dict[str, Snapshots],
    ks: Sequence[int],
    progress: Callable[[float], None],
) -> tuple[PostureError, ...]:
    """Errors of bases of several sizes and kinds.

    Args:
        robot: the arm.
        shipped: its basis, for what is known of the campaign.
        campaign: converged snapshots that bases are made from.
        postures: runs to follow, by name.
        ks: numbers of modes, ascending.
        progress: called with the share of the work that has just been done.
    """
    found, share = [], 1.0 / (len(KINDS) * len(ks) * len(postures))
    bases = _bases(robot, shipped, campaign, ks)
    for method, _, certified in KINDS:
        for basis in bases[method]:
            for name, runs in postures.items():
                found.append(posture_error(robot, basis, runs, name, certified))
                progress(share)
    return tuple(found)


def _bases(
    robot: Robot, shipped: ContactBasis, campaign: Snapshots, ks: Sequence[int]
) -> dict[BasisMethod, list[ContactBasis]]:
    """Bases of all sizes by each method."""
    problems = contact_problems(robot, campaign)
    found: dict[BasisMethod, list[ContactBasis]] = {}
    for method, weighting in dict.fromkeys((method, weighting) for method, weighting, _ in KINDS):
        S = campaign.lam * snapshot_weights(campaign.lam, weighting)
        origin = replace(shipped.provenance, method=method, weighting=weighting)
        fits = fit_each(S, problems, ks, method)
        found[method] = [ContactBasis(fit.Psi, replace(origin, k=fit.k)) for fit in fits]
    return found


def posture_error(
    robot: Robot, basis: ContactBasis, runs: Snapshots, name: str, certified: bool
) -> PostureError:
    """Error of one basis on runs that end in postures, under the same tensions.

    Args:
        robot: the arm.
        basis: of contact forces.
        runs: equilibria with pointwise contact.
        name: of the set of postures.
        certified: whether unit columns are added where gaps are deeper than the tolerance.
    """
    tolerance = robot.tolerance
    enrichment = default_enrichment(tolerance) if certified else None
    result = tip_errors(robot, runs, basis, enrichment, "effort", _MAX_ITERATIONS)
    last = np.append(np.diff(runs.run) != 0, True)
    ends = 1e3 * result.error[last]
    return PostureError(
        method=basis.provenance.method,
        k=basis.k,
        certified=certified,
        postures=name,
        mean_mm=float(np.nanmean(ends)),
        max_mm=float(np.nanmax(ends)),
        path_max_mm=float(1e3 * np.nanmax(result.error)),
        extra_columns=int(result.extra_columns.max(initial=0)),
        unsettled=int(np.isnan(result.error).sum()),
    )
