"""`python -m benchmarks closed-loop`: models of contact, and robots of another stiffness.

Five cases with three models of contact, each in open and closed loop, against a full-order robot as modelled;
then the step again with a robot a fifth softer and stiffer, whose winches pull the tensions commanded: with
pulled lengths the shape hardly depends on the stiffness.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from benchmarks.control.outcome import Outcome, case_outcome
from benchmarks.control.targets import Case, equilibria, make_cases
from tauten.controller import Controller
from tauten.model import ContactSpace, Simulator, load_robot, one_blas_thread
from tauten.service.bench import Trace, follow, warmed
from tauten.service.plant import Drive, DrivenRobot, own_steps
from tauten.service.process import HostInfo, Progress, StopFlag, host_info
from tauten.service.setup import Setup

CONTACTS = ("reduced", "full", "none")
MISMATCHES = (0.8, 1.2)

_TARGETS_SHARE = 0.05  # of the work, for the targets


@dataclass(frozen=True, slots=True)
class ContactLoops:
    """Everything the benchmark measures.

    Attributes:
        machine: facts about it.
        robot: name.
        rate_hz: ticks a second.
        seconds: of each case.
        seed: of the random walk.
        plant_steps: steps of the plant in a period.
        plant_error_percent: how far twice as many move it in a trial motion, of its way.
        mesh_error: of the mesh that model and plant are made of, in a sentence.
        outcomes: one a run of a case.
        complete: whether all runs were done.
    """

    machine: HostInfo
    robot: str
    rate_hz: float
    seconds: float
    seed: int
    plant_steps: int
    plant_error_percent: float
    mesh_error: str
    outcomes: tuple[Outcome, ...]
    complete: bool


@dataclass(frozen=True, slots=True)
class Group:
    """Runs that one figure shows: a case, a plant, and (contact, closed) of each controller."""

    name: str
    case: Case
    young_scale: float
    drive: Drive
    controllers: tuple[tuple[str, bool], ...]


@dataclass(frozen=True, slots=True)
class CaseRuns:
    """All runs of a case with one plant, for a figure.

    Attributes:
        name: of the group of runs.
        case: its targets.
        runs: numbers and course of each run.
    """

    name: str
    case: Case
    runs: tuple[tuple[Outcome, Trace], ...]


def planned(cases: list[Case]) -> Iterator[Group]:
    """All runs."""
    both = tuple((contact, closed) for contact in CONTACTS for closed in (False, True))
    for case in cases:
        yield Group(case.name, case, 1.0, "pull", both)
    for scale in MISMATCHES:
        name = f"stiffness-{scale:g}"
        yield Group(name, cases[0], scale, "tension", (("reduced", False), ("reduced", True)))


def bench_cases(
    setup: Setup, seconds: float, seed: int, stop: StopFlag, progress: Progress
) -> tuple[ContactLoops, tuple[CaseRuns, ...]]:
    """Run all cases, or as many as are done when `stop` is raised.

    Args:
        setup: the robot, with the contact of "reduced".
        seconds: of each case.
        seed: of the random walk.
        stop: raised to end early.
        progress: called with the share of the work that has just been done, and what comes next.

    Returns:
        The numbers, and the runs they come from.

    Raises:
        PathError: the robot finds no equilibrium to take targets from.
    """
    robot, done = setup.robot, list[CaseRuns]()
    with one_blas_thread():
        progress(0.0, "plant")
        bench = CaseRunner(setup)
        share = _TARGETS_SHARE / equilibria(robot.n_a)
        cases = make_cases(robot, seconds, seed, lambda: progress(share, "targets in reach"))
        groups = list(planned(cases))
        share = (1.0 - _TARGETS_SHARE) / sum(len(group.controllers) for group in groups)
        for group in groups:
            found = []
            for contact, closed in group.controllers:
                if stop.requested:
                    break
                progress(0.0, f"{group.name}, {contact} contact")
                found.append(bench.run(group, contact, closed))
                progress(share, group.name)
            if found:
                done.append(CaseRuns(group.name, group.case, tuple(found)))
    result = ContactLoops(
        machine=host_info(),
        robot=robot.name,
        rate_hz=1.0 / robot.h,
        seconds=seconds,
        seed=seed,
        plant_steps=bench.own.count,
        plant_error_percent=100.0 * bench.own.error,
        mesh_error=setup.mesh_error,
        outcomes=tuple(outcome for one in done for outcome, _ in one.runs),
        complete=not stop.requested,
    )
    return result, tuple(done)


class CaseRunner:
    """Controllers and plants, made once and returned to the equilibrium under their loads before each run.

    Attributes:
        own: steps of the plants.
    """

    def __init__(self, setup: Setup) -> None:
        """Make the controllers, and the plant as modelled."""
        kinds: dict[str, Literal["none", "full"] | ContactSpace] = {
            "reduced": setup.contact, "full": "full", "none": "none",
        }  # fmt: skip
        self._setup = setup
        self._controllers = {
            name: Controller(setup.robot, kind, settings=setup.controller)
            for name, kind in kinds.items()
        }
        plant = self._simulator(1.0)
        self.own = own_steps(plant)
        self._plants = {1.0: DrivenRobot(plant, self.own.count)}
        for controller in self._controllers.values():
            controller.settle_start()
            warmed(controller, self._plants[1.0], setup.service)

    def run(self, group: Group, contact: str, closed: bool) -> tuple[Outcome, Trace]:
        """One run, from the equilibrium under the loads with the actuators at rest.

        Args:
            group: case and plant.
            contact: model of contact in the controller, one of `CONTACTS`.
            closed: whether measurements correct the targets.
        """
        controller, case, scale = self._controllers[contact], group.case, group.young_scale
        if scale not in self._plants:
            self._plants[scale] = DrivenRobot(self._simulator(scale), self.own.count)
        trace = follow(
            controller, self._plants[scale], case.targets, self._setup.service, closed, group.drive
        )
        h = controller.robot.h
        return case_outcome(case, trace, h, contact, closed, scale, group.drive), trace

    def _simulator(self, young_scale: float) -> Simulator:
        rate = 1.0 / self._setup.robot.h
        made = Simulator(load_robot(self._setup.path, rate=rate, young_scale=young_scale), "full")
        made.settle_start()
        return made
