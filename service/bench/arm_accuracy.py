"""Position error of reduced against pointwise contact over the number of modes: the paper's Fig. 12."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

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

LABELS = {"als": "ALS", "energy": "least energy"}


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
    """Error of one basis on runs that end in postures; cables keep their tensions."""
    tolerance = robot.config.contact.tolerance
    enrichment = default_enrichment(tolerance) if certified else None
    result = tip_errors(robot, runs, basis, enrichment, "tension", _MAX_ITERATIONS)
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


def draw_errors(errors: Sequence[PostureError], path: Path) -> None:
    """Mean and largest error over k, a panel a set of postures."""
    names = list(dict.fromkeys(error.postures for error in errors))
    figure = Figure(figsize=(5.2 * len(names), 4.2), layout="constrained")
    panels = figure.subplots(1, len(names), sharey=True, squeeze=False)[0]
    for axes, name in zip(panels, names, strict=True):
        for (method, _, certified), colour in zip(KINDS, ("C3", "C0", "C2"), strict=True):
            points = [
                error
                for error in errors
                if (error.postures, error.method, error.certified) == (name, method, certified)
            ]
            label = LABELS[method] + (", certified" if certified else "")
            k = [point.k for point in points]
            axes.plot(k, [p.mean_mm for p in points], "o-", color=colour, ms=4, label=label)
            axes.plot(k, [p.max_mm for p in points], "^--", color=colour, ms=4, lw=0.8)
        axes.axhline(30.0, color="0.5", lw=0.8, ls=":")
        axes.set(title=f"{name} postures", xlabel="modes k", yscale="log")
        axes.grid(alpha=0.3, which="both", lw=0.4)
    panels[0].set_ylabel("tip error [mm]: mean (line), largest (dashes)")
    panels[0].annotate("paper, k = 23", (0.98, 30.0), xycoords=("axes fraction", "data"),
                       ha="right", va="bottom", fontsize=8, color="0.4")  # fmt: skip
    panels[-1].legend(fontsize=8)
    figure.savefig(path, dpi=150)
