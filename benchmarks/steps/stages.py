"""Times of the stages of a control step along a path of targets."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter
from typing import Literal, TypeVar

import numpy as np

from tauten.controller import Controller, ControllerSettings, decide, prepare
from tauten.controller.qpcc import solve_qpcc
from tauten.model import ContactSpace, Robot, row_compliance
from tauten.model.numerics import Array
from tauten.service.replay import Spread, spread

T = TypeVar("T")

# factorisation is what a linearisation takes beside assembly: factors and one solution;
# the QPCC is part of decide, which goes on to predict all gaps
STAGES = ("assembly", "factorisation", "detection", "reduction", "compliance", "qpcc")
WHOLE = ("prepare", "decide", "advance", "step")


@dataclass(frozen=True, slots=True)
class StepTimes:
    """Times of control steps along a path.

    Attributes:
        contact: contact model of the controller.
        steps: number of steps measured.
        stages_ms: of each stage, measured beside the step on the same state.
        whole_ms: of prepare, decide, advance and all three together.
        rows: median number of contact rows in the QPCC.
        in_range: median number of candidates within the alarm distance.
        tip_error_mm: distance of the model's tip from the target.
        deepest_gap_mm: deepest predicted penetration, as a gap; None without any candidate in range.
        statuses: number of decisions by status.
    """

    contact: str
    steps: int
    stages_ms: dict[str, Spread]
    whole_ms: dict[str, Spread]
    rows: float
    in_range: float
    tip_error_mm: Spread
    deepest_gap_mm: float | None
    statuses: dict[str, int]


class _Watch:
    """Times of named pieces of work [ms]."""

    def __init__(self) -> None:
        self.times: dict[str, list[float]] = {}

    def time(self, name: str, work: Callable[[], T]) -> T:
        """Do the work and note how long it took."""
        start = perf_counter()
        result = work()
        self.times.setdefault(name, []).append(1e3 * (perf_counter() - start))
        return result

    def spreads(self, names: tuple[str, ...]) -> dict[str, Spread]:
        """Percentiles of the named ones."""
        return {name: spread(self.times.get(name, [])) for name in names}


def time_steps(
    robot: Robot,
    contact: Literal["none", "full"] | ContactSpace,
    name: str,
    targets: Array,
    settings: ControllerSettings | None = None,
    warm_up: int = 20,
) -> StepTimes:
    """Follow targets with a controller at rest and measure every step after the warm-up.

    Args:
        robot: what to control.
        contact: "none", "full" or a basis.
        name: of `contact`, for tables.
        targets: (s, p, 3) [m], one a step.
        settings: of the controller; default: those of a file that does not set any.
        warm_up: first steps, which are not measured.
    """
    return time_controller(Controller(robot, contact, settings=settings), name, targets, warm_up)


def time_controller(
    controller: Controller, name: str, targets: Array, warm_up: int = 20
) -> StepTimes:
    """Follow targets from the state of a controller and measure every step after the warm-up.

    Args:
        controller: decides.
        name: of its contact model, for tables.
        targets: (s, p, 3) [m], one a step.
        warm_up: first steps, which are not measured.
    """
    watch = _Watch()
    errors, gaps, rows, in_range = [], [np.inf], [], []
    statuses: Counter[str] = Counter()
    for index, target in enumerate(targets):
        if index == warm_up:
            watch.times.clear()
            statuses.clear()
        rows.append(_time_stages(controller, watch, target.ravel()))
        start = perf_counter()
        watch.time("prepare", controller.prepare)
        in_range.append(len(controller.contacts))
        actuation = watch.time("decide", lambda goal=target: controller.decide(goal))  # type: ignore[misc]
        watch.time("advance", controller.advance)
        watch.times.setdefault("step", []).append(1e3 * (perf_counter() - start))
        statuses[actuation.status.name] += 1
        errors.append(1e3 * float(np.linalg.norm(controller.effector - target, axis=1).max()))
        gaps.append(1e3 * actuation.certificate.deepest_gap)
    deepest = float(np.nanmin(gaps))
    return StepTimes(
        contact=name,
        steps=len(targets) - warm_up,
        stages_ms=watch.spreads(STAGES),
        whole_ms=watch.spreads(WHOLE),
        rows=float(np.median(rows)),
        in_range=float(np.median(in_range)),
        tip_error_mm=spread(errors),
        deepest_gap_mm=deepest if np.isfinite(deepest) else None,
        statuses=dict(statuses),
    )


def _time_stages(controller: Controller, watch: _Watch, target: Array) -> int:
    """Run the stages of a step one by one on the controller's state; its number of contact rows.

    The controller's own step follows and overwrites the factorisation used here.

    Args:
        controller: its robot, state and settings.
        watch: where the times are added.
        target: (n_e,) [m].
    """
    robot, state, forces = controller.robot, controller.state, controller.forces
    space, settings = controller.space, controller.settings
    watch.time("assembly", lambda: robot.forces(state, forces.effort, exact=True))
    start = perf_counter()
    robot.linearise(state, forces.effort)
    factors = 1e3 * (perf_counter() - start) - watch.times["assembly"][-1]
    watch.times.setdefault("factorisation", []).append(factors)
    contacts = space.k > 0 or settings.enrichment.rounds > 0
    rows = watch.time("detection", lambda: robot.rows(state, contacts=contacts))
    watch.time("reduction", lambda: space.reduce(rows.contacts))
    prepared = prepare(
        controller.horizon, space, state, forces, controller.position, settings.enrichment
    )
    step = prepared.step
    H, delta = step.compliance.H, step.compliance.delta_free
    watch.time("compliance", lambda: row_compliance(step.system, H, delta))
    decision = decide(robot, prepared, target, controller.position, settings)
    problem, warm = decision.problem, decision.start
    assert problem is not None
    watch.time("qpcc", lambda: solve_qpcc(problem, warm, settings.qpcc))
    return step.n_contacts
