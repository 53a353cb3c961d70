"""`python -m benchmarks equilibria`: linearised steps that a robot needs to settle, from any start."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path
from typing import TypeAlias

import numpy as np

from benchmarks.physics.loads import CableLoad
from benchmarks.physics.sofa_robots import TRUNK_CABLES, diamond, trunk
from tauten.model import Integration, Robot, Simulator, State, load_robot, one_blas_thread
from tauten.model.body import SparseBody
from tauten.model.numerics import Array, Factorisation
from tauten.service.process import HostInfo, Progress, host_info

LoadedStart: TypeAlias = tuple[State | None, CableLoad]  # None: at rest

GRAVITIES = ((0.0, 0.0, 0.0), (0.0, -9.81, 0.0))  # m/s², none and across the trunk
LONG_CABLES = 4  # of the trunk, along its whole length
TRUNK_PULL, DIAMOND_TENSION = 0.050, 10.0  # m, N
FARTHEST, LARGEST_LOAD = 0.1, 0.8  # of the robot's size, of the largest pull or tension


@dataclass(frozen=True, slots=True)
class EquilibriaSettings:
    """What is settled.

    Attributes:
        robots: names or files, each from random starts under random loads.
        starts: how many for each.
        data: folder with the models of trunk and diamond; None: they are left out.
        seed: of the random starts.
        contact: whether the robots from random starts touch themselves.
    """

    robots: tuple[str, ...] = ("finger", "manipulator")
    starts: int = 200
    data: Path | None = None
    seed: int = 0
    contact: bool = False


@dataclass(frozen=True, slots=True)
class EquilibriumGroup:
    """Searches of one kind.

    Attributes:
        name: what is settled.
        searches: how many.
        converged: how many found an equilibrium.
        median: linearised steps, each solved with one factorisation.
        most: of the longest search.
        endings: of the others, with their number.
    """

    name: str
    searches: int
    converged: int
    median: float
    most: int
    median_factorisations: float
    most_factorisations: int
    endings: dict[str, int]


class CountedFactorisation:
    """A workspace of the linear solver that counts the matrices it is given, as its forks do.

    Attributes:
        name: of the solver.
        count: matrices so far, those that were not definite included.
    """

    def __init__(self, workspace: Factorisation) -> None:
        """Count those of this workspace."""
        self._workspace = workspace
        self.name, self.count = workspace.name, 0

    def refactor(self, values: Array) -> None:
        """See `Factorisation`."""
        self.count += 1
        self._workspace.refactor(values)

    def solve(self, B: Array) -> Array:
        """See `Factorisation`."""
        return self._workspace.solve(B)

    def fork(self) -> CountedFactorisation:
        """A workspace of its own, that counts from zero."""
        return CountedFactorisation(self._workspace.fork())


@dataclass(frozen=True, slots=True)
class EquilibriaBench:
    """Everything `python -m benchmarks equilibria` measures."""

    machine: HostInfo
    groups: tuple[EquilibriumGroup, ...]


def bench_equilibria(settings: EquilibriaSettings, progress: Progress) -> EquilibriaBench:
    """Settle everything.

    Args:
        settings: what.
        progress: called with the share of the work that is about to be done, and what it is.

    Raises:
        RobotFileError, MeshError: a robot that cannot be loaded.
    """
    groups = []
    with one_blas_thread():
        plan = list(planned(settings))
        for name, robot, searches, contact in plan:
            progress(1.0 / len(plan), name)
            groups.append(settled(name, robot, searches, contact))
    return EquilibriaBench(host_info(), tuple(groups))


def planned(settings: EquilibriaSettings) -> Iterator[tuple[str, Robot, list[LoadedStart], bool]]:
    """Names, robots, searches, and whether the robot touches itself."""
    if settings.data is not None:
        for gravity in GRAVITIES:
            weight = "with gravity across it" if any(gravity) else "without gravity"
            robot = trunk(settings.data, gravity=gravity)
            yield f"trunk to 50 mm on one cable, {weight}", robot, trunk_searches(1), False
            yield f"trunk to 50 mm on two cables, {weight}", robot, trunk_searches(2), False
        held: list[LoadedStart] = [
            (None, CableLoad(effort=DIAMOND_TENSION * row)) for row in np.eye(4)
        ]
        yield "diamond to 10 N on one leg", diamond(settings.data), held, False
    for name in settings.robots:
        robot_ = load_robot(name)
        generator = np.random.default_rng(settings.seed)
        searches = [random_search(robot_, generator) for _ in range(settings.starts)]
        yield f"{robot_.name} from random starts", robot_, searches, settings.contact


def trunk_searches(cables: int) -> list[LoadedStart]:
    """From rest to 50 mm on each of the long cables, or on two of them that are not opposite."""
    found: list[LoadedStart] = []
    for chosen in combinations(range(LONG_CABLES), cables):
        if cables == 2 and chosen[1] - chosen[0] == 2:
            continue  # opposite cables compress the trunk
        position = np.zeros(len(TRUNK_CABLES))
        position[list(chosen)] = TRUNK_PULL
        found.append((None, CableLoad(position=position)))
    return found


def random_search(robot: Robot, generator: np.random.Generator) -> LoadedStart:
    """From the displacement under random nodal forces, scaled to a random size, to a random load.

    One cable is pulled to a length. Several may pull against each other: they get tensions.
    """
    rest = robot.rest()
    system = robot.linearise(rest, integration=Integration(robot.integration.rate, static=True))
    move = system.solve(generator.standard_normal((robot.n, 1)))[:, 0]  # (n,)
    size = FARTHEST * robot.size * generator.uniform()
    dq = (size / robot.displacement(rest, move)) * move
    still = State(robot.advance(rest, dq, 1.0).q, rest.v)
    load = generator.uniform(0.0, LARGEST_LOAD, robot.n_a)
    if robot.n_a == 1:
        return still, CableLoad(position=load * robot.limits.position_max)
    return still, CableLoad(effort=load * robot.limits.effort_max)


def settled(
    name: str, robot: Robot, searches: list[LoadedStart], contact: bool
) -> EquilibriumGroup:
    """Settle a robot under each of some loads.

    Args:
        name: of the group.
        robot: the robot.
        searches: starts and loads.
        contact: whether it touches itself.
    """
    body = robot.body
    assert isinstance(body, SparseBody)
    counted = replace(body, factorisation=CountedFactorisation(body.factorisation))
    simulator = Simulator(replace(robot, body=counted), contact="full" if contact else "none")
    reports, factorised = [], []
    assert isinstance(simulator.robot.body, SparseBody)
    counter = simulator.robot.body.factorisation
    assert isinstance(counter, CountedFactorisation)
    for state, load in searches:
        simulator.reset()
        counter.count = 0
        if state is not None:
            simulator.start_from(state)
        reports.append(load.settle(simulator))
        factorised.append(counter.count)
    taken = [report.iterations for report in reports]
    failed = [report.ending for report in reports if not report.converged]
    return EquilibriumGroup(
        name=name,
        searches=len(reports),
        converged=len(reports) - len(failed),
        median=float(np.median(taken)),
        most=max(taken),
        median_factorisations=float(np.median(factorised)),
        most_factorisations=max(factorised),
        endings={ending.value: count for ending, count in Counter(failed).items()},
    )
