"""Stage times of control steps with each kind of contact, and errors of reduced contact."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.steps.stages import StepTimes, time_steps
from tauten.controller import ControllerSettings
from tauten.model import Enrichment, Robot, Simulator, default_enrichment, one_blas_thread
from tauten.model.numerics import Array, Bools
from tauten.reduction import ContactBasis
from tauten.service.bench import Sizes, sizes_of
from tauten.service.plant import PathSettings, make_path
from tauten.service.process import HostInfo, Progress, host_info


@dataclass(frozen=True, slots=True)
class TipError:
    """Tip of reduced against pointwise contact along pulls from rest to the largest.

    Attributes:
        enriched: whether unit columns joined where gaps were deeper than the robot file's tolerance.
        positions: number of equilibria compared.
        mean_mm: mean distance of the tips.
        max_mm: largest.
        deepest_gap_mm: deepest predicted penetration of the reduced one, as a gap.
        extra_columns: largest number of unit columns in play.
        unconverged: equilibria that did not settle, with reduced or with pointwise contact.
    """

    enriched: bool
    positions: int
    mean_mm: float
    max_mm: float
    deepest_gap_mm: float
    extra_columns: int
    unconverged: int


@dataclass(frozen=True, slots=True)
class ControlBench:
    """Everything `python -m benchmarks finger` measures."""

    machine: HostInfo
    robot: str
    rate_hz: float
    factorisation: str
    sizes: Sizes
    control: tuple[StepTimes, ...]
    tip_error: tuple[TipError, ...]


def bench_control(
    robot: Robot,
    basis: ContactBasis,
    settings: ControllerSettings,
    seconds: float,
    positions: int,
    progress: Progress,
) -> ControlBench:
    """Time control steps with contact none, full and reduced; compare reduced with pointwise tips.

    Args:
        robot: what to control.
        basis: its contact basis.
        settings: of the controllers.
        seconds: of the path along what the cables reach, there and back.
        positions: equilibria at which tips are compared.
        progress: called with the share of the work that has just been done.
    """
    path = make_path("reach", robot, PathSettings(period=seconds, fraction=0.9))
    targets = np.array([path.at(t) for t in np.arange(0.0, seconds, robot.h)])
    kinds = (("none", "none"), ("full", "full"), (basis, f"reduced, k = {basis.k}"))
    with one_blas_thread():
        control = []
        for contact, name in kinds:
            control.append(time_steps(robot, contact, name, targets, settings))  # type: ignore[arg-type]
            progress(1.0 / 6.0)
        full = tip_curve(robot, "full", None, positions)
        progress(1.0 / 6.0)
        tolerance = robot.tolerance
        enrichments = (None, default_enrichment(tolerance))
        errors = []
        for enrichment in enrichments:
            errors.append(
                tip_error(full, tip_curve(robot, basis, enrichment, positions), enrichment)
            )
            progress(1.0 / 6.0)
    return ControlBench(
        machine=host_info(),
        robot=robot.name,
        rate_hz=1.0 / robot.h,
        factorisation=robot.body.linear_solver,
        sizes=sizes_of(robot, basis.k),
        control=tuple(control),
        tip_error=tuple(errors),
    )


@dataclass(frozen=True, slots=True)
class _TipCurve:
    tips: Array  # (s, 3) [m]
    converged: Bools  # (s,)
    deepest: float
    extra: int


def tip_curve(
    robot: Robot, contact: object, enrichment: Enrichment | None, positions: int
) -> _TipCurve:
    """Equilibria with every cable pulled in proportion from rest to its largest pull.

    Args:
        robot: the robot.
        contact: "none", "full" or a contact basis.
        enrichment: of the basis; None without.
        positions: number of equilibria.
    """
    simulator = Simulator(robot, contact, enrichment)  # type: ignore[arg-type]
    tips, converged, deepest, extra = [], [], np.inf, 0
    for share in np.linspace(0.0, 1.0, positions):
        report = simulator.settle(position=share * robot.limits.position_max, tolerance=1e-6)
        tips.append(simulator.effector[0])
        converged.append(report.converged)
        deepest = min(deepest, report.deepest_gap)
        extra = max(extra, report.extra_columns)
    return _TipCurve(np.array(tips), np.array(converged), deepest, extra)


def tip_error(full: _TipCurve, reduced: _TipCurve, enrichment: Enrichment | None) -> TipError:
    """Distances between the tips of two curves where both settled.

    Args:
        full: with pointwise contact.
        reduced: with a contact basis.
        enrichment: of the basis; None without.
    """
    both = full.converged & reduced.converged
    distance = 1e3 * np.linalg.norm(full.tips - reduced.tips, axis=1)[both]
    return TipError(
        enriched=enrichment is not None,
        positions=int(both.sum()),
        mean_mm=float(distance.mean()),
        max_mm=float(distance.max()),
        deepest_gap_mm=1e3 * reduced.deepest,
        extra_columns=reduced.extra,
        unconverged=int((~both).sum()),
    )
