"""The closed-loop benchmark: its runs and its results.

First a path in reach at some periods, with the distance of model and plant divided into its shares
(`tauten.service.bench.following`). Then, where they are asked for, five cases with three models of contact,
each in open and closed loop, against a full-order robot as modelled; then the step again with a robot a fifth
softer and stiffer, whose winches pull the tensions commanded: with pulled lengths the shape hardly depends on
the stiffness.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from tauten.controller import Controller, controller_settings
from tauten.model import ContactSpace, Robot, Simulator, load_robot
from tauten.model.schema import read_toml
from tauten.service.bench.closed_loop_cases import Case, equilibria, make_cases
from tauten.service.bench.closed_loop_run import Drive, Outcome, Trace, case_outcome, follow
from tauten.service.bench.following import Following, follow_path
from tauten.service.check import mesh_error_text
from tauten.service.plant import DrivenRobot, own_steps
from tauten.service.process import HostInfo, Progress, StopFlag, host_info, one_blas_thread
from tauten.service.settings import service_settings

CONTACTS = ("reduced", "full", "none")
MISMATCHES = (0.8, 1.2)

Contact = Literal["none", "full"] | ContactSpace
_CASES_SHARE = 0.05  # of the work of all cases, for their targets
_PATHS_SHARE = 0.1  # of the whole work, where there are cases too
_WARM_UP = 12  # ticks
_NEARBY = 0.01  # of the robot's size


@dataclass(frozen=True, slots=True)
class ClosedLoopSettings:
    """What to run.

    Attributes:
        seconds: of each case.
        seed: of the random walk.
        periods: of the path in reach [s].
        cases: whether the cases run.
    """

    seconds: float
    seed: int
    periods: tuple[float, ...] = ()
    cases: bool = True


@dataclass(frozen=True, slots=True)
class ClosedLoopBench:
    """Everything `tauten bench closed-loop` measures.

    Attributes:
        machine: facts about it.
        robot: name.
        rate_hz: ticks a second.
        seconds: of each case.
        seed: of the random walk.
        plant: order of the plant.
        plant_steps: its steps in a period.
        plant_error_percent: how far twice as many move it in a trial motion, of its way.
        plant_speed: its simulated time over real time there.
        plant_unknowns: degrees of freedom of the plant.
        model_unknowns: of the controller's model.
        mesh_error: of the mesh that both are made of, in a sentence.
        following: one a period.
        outcomes: one a run of a case.
        complete: whether all runs were done.
    """

    machine: HostInfo
    robot: str
    rate_hz: float
    seconds: float
    seed: int
    plant: str
    plant_steps: int
    plant_error_percent: float
    plant_speed: float
    plant_unknowns: int
    model_unknowns: int
    mesh_error: str
    following: tuple[Following, ...]
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


def bench_closed_loop(
    robot: Robot,
    path: Path,
    basis: Contact,
    settings: ClosedLoopSettings,
    stop: StopFlag,
    progress: Progress,
) -> tuple[ClosedLoopBench, tuple[CaseRuns, ...]]:
    """Run all cases, or as many as are done when `stop` is raised.

    Args:
        robot: the model.
        path: its file.
        basis: its contact basis, or its model of contact where it has none.
        settings: what to run.
        stop: raised to end early.
        progress: called with the share of the work that has just been done, and what comes next.

    Returns:
        The numbers, and the runs they come from.

    Raises:
        PathError: the robot finds no equilibrium to take targets from, or has several effectors and periods
            are given.
    """
    done: list[CaseRuns] = []
    followed: list[Following] = []
    with one_blas_thread():
        progress(0.0, "plant")
        bench = ClosedLoopRunner(robot, path, basis)
        ahead = _PATHS_SHARE if settings.cases else 1.0
        for period in settings.periods:
            if stop.requested:
                break
            progress(0.0, f"path in reach, {period:g} s")
            followed.append(bench.follow(period))
            progress(ahead * period / sum(settings.periods), f"path in reach, {period:g} s")
        if settings.cases:
            rest = 1.0 - ahead if settings.periods else 1.0
            done = _cases(bench, robot, settings, stop, progress, rest)
    result = ClosedLoopBench(
        machine=host_info(),
        robot=robot.name,
        rate_hz=1.0 / robot.h,
        seconds=settings.seconds,
        seed=settings.seed,
        plant="full",
        plant_steps=bench.own.count,
        plant_error_percent=100.0 * bench.own.error,
        plant_speed=bench.own.speed,
        plant_unknowns=bench.unknowns,
        model_unknowns=robot.n,
        mesh_error=mesh_error_text(path, robot.digest),
        following=tuple(followed),
        outcomes=tuple(outcome for one in done for outcome, _ in one.runs),
        complete=not stop.requested,
    )
    return result, tuple(done)


def _cases(
    bench: ClosedLoopRunner,
    robot: Robot,
    settings: ClosedLoopSettings,
    stop: StopFlag,
    progress: Progress,
    whole: float,
) -> list[CaseRuns]:
    """All cases, or as many as are done when `stop` is raised.

    Args:
        bench: controllers and plants.
        robot: the model.
        settings: what to run.
        stop: raised to end early.
        progress: as of `bench_closed_loop`.
        whole: share of the whole work that the cases are.
    """
    done: list[CaseRuns] = []
    share = whole * _CASES_SHARE / equilibria(robot.n_a)
    cases = make_cases(
        robot, settings.seconds, settings.seed, lambda: progress(share, "targets in reach")
    )
    groups = list(planned(cases))
    share = whole * (1.0 - _CASES_SHARE) / sum(len(group.controllers) for group in groups)
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
    return done


class ClosedLoopRunner:
    """Controllers and plants, made once and returned to the equilibrium under their loads before each run.

    Attributes:
        own: steps of the plants.
        unknowns: of the plants.
    """

    def __init__(self, robot: Robot, path: Path, basis: Contact) -> None:
        """Make the controllers.

        Args:
            robot: the model.
            path: its file, for plants.
            basis: its contact basis, or its model of contact where it has none.
        """
        contents = read_toml(path)
        settings = controller_settings(contents, path)
        self._service = service_settings(contents, path)
        contacts: dict[str, Contact] = {"reduced": basis, "full": "full", "none": "none"}
        self._controllers = {
            name: Controller(robot, kind, settings=settings) for name, kind in contacts.items()
        }
        for controller in self._controllers.values():
            controller.settle_start()
        self._path, self._rate = path, 1.0 / robot.h
        self._plants: dict[float, DrivenRobot] = {}
        plant = Simulator(load_robot(path, rate=self._rate), "full")
        plant.settle_start()
        self.own, self.unknowns = own_steps(plant), plant.robot.n
        self._plants[1.0] = DrivenRobot(plant, self.own.count)
        self._warm: set[str] = set()

    def follow(self, period: float) -> Following:
        """Follow the path in reach once, with the reduced model of contact.

        Args:
            period: of the path [s].

        Raises:
            PathError: the robot has several effectors, or no equilibria.
        """
        return follow_path(self._warmed("reduced"), self._plant(1.0), period, self._service)

    def run(self, group: Group, contact: str, closed: bool) -> tuple[Outcome, Trace]:
        """One run, from the equilibrium under the loads with the actuators at rest.

        Args:
            group: case and plant.
            contact: model of contact in the controller, "reduced", "full" or "none".
            closed: whether measurements correct the targets.
        """
        controller, plant = self._warmed(contact), self._plant(group.young_scale)
        case = group.case
        trace = follow(controller, plant, case, closed, group.drive, self._service)
        h, scale = controller.robot.h, group.young_scale
        return case_outcome(case, trace, h, contact, closed, scale, group.drive), trace

    def _warmed(self, contact: str) -> Controller:
        """The controller with a model of contact, after a few ticks towards a target nearby."""
        controller = self._controllers[contact]
        if contact not in self._warm:
            goal = controller.shifted(_NEARBY * controller.robot.size)
            short = Case("warm-up", np.tile(goal, (_WARM_UP, 1)), 0)
            follow(controller, self._plant(1.0), short, False, "pull", self._service)
            self._warm.add(contact)
        return controller

    def _plant(self, young_scale: float) -> DrivenRobot:
        if young_scale not in self._plants:
            robot = load_robot(self._path, rate=self._rate, young_scale=young_scale)
            simulator = Simulator(robot, "full")
            simulator.settle_start()
            self._plants[young_scale] = DrivenRobot(simulator, self.own.count)
        return self._plants[young_scale]
