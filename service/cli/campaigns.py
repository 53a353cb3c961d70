"""The campaigns of `tauten reduce`: over the whole range of the actuators, and within shares of it."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from tauten.service.cli.terminal import progress_bar

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from tauten.model import Robot
    from tauten.reduction.campaign import Design, Ranges, Snapshots, TouchedRobot
    from tauten.reduction.state import Narrower


@dataclass(frozen=True, slots=True, eq=False)
class Campaigns:
    """What the campaigns of one command have in common.

    Attributes:
        plain: the robot.
        spheres: the robot with spheres that press it; None: nothing does.
        design: name of the design, or a CSV file.
        step: of the ramp [m].
        ranges: of the other designs.
        runs: of the Latin hypercube.
        steps: of a run.
        seed: of random numbers.
        folder: of the saved chunks.
        executor: a new one for a number of runs.
    """

    plain: Robot
    spheres: TouchedRobot | None
    design: str
    step: float
    ranges: Ranges
    runs: int
    steps: int
    seed: int
    folder: Path
    executor: Callable[[int], AbstractContextManager[Executor]]

    @property
    def robot(self) -> Robot:
        """The robot that the campaigns move."""
        return self.plain if self.spheres is None else self.spheres.robot

    def whole(self) -> Snapshots:
        """All equilibria over the whole range, with progress bars."""
        from tauten.reduction.campaign import run_campaign

        with progress_bar("range of each actuator") as report:
            plan = self._plan(report)
        with self.executor(len(plan.runs)) as executor:
            return run_campaign(self.robot, plan, self.folder, executor)

    def narrower(self, whole: Snapshots) -> Narrower | None:
        """Campaigns within a share of the positions of the whole range; None: the design has no such."""
        from tauten.reduction.campaign import narrowed, run_campaign

        if self.design.endswith(".csv"):
            return None
        reached = whole.position

        def within(share: float, report: Callable[[float, str], None]) -> Snapshots:
            plain, spheres = narrowed(self.plain, reached, share), self.spheres
            if spheres is not None:  # whose plain robot is that of the campaigns
                robot = narrowed(spheres.robot, reached, share)
                spheres = replace(spheres, robot=robot, plain=plain)
            close = replace(
                self,
                plain=plain,
                spheres=spheres,
                step=share * self.step,
                folder=self.folder / f"within-{100.0 * share:.0f}",
            )
            plan = close._plan(lambda _, what: report(0.0, what))
            done = 0

            def each(count: int) -> None:
                nonlocal done
                done += count
                report(count / plan.size, f"snapshots {done} of {plan.size}")

            with close.executor(len(plan.runs)) as executor:
                found = run_campaign(close.robot, plan, close.folder, executor, each=each)
            return found.select(found.converged)

        return within

    def _plan(self, report: Callable[[float, str], None]) -> Design:
        """The design."""
        from tauten.reduction.campaign import (
            DesignError,
            exploring,
            from_csv,
            latin_hypercube,
            plackett_burman,
            ramp,
        )

        name, robot = self.design, self.plain
        if name == "exploring":
            return exploring(self.robot, self.seed, self.spheres, report)
        if name == "ramp":
            return ramp(robot, self.step)
        if name == "plackett-burman":
            return plackett_burman(robot, self.ranges, self.steps)
        if name == "latin-hypercube":
            return latin_hypercube(robot, self.ranges, self.runs, self.seed, self.steps)
        if not name.endswith(".csv"):
            raise DesignError(
                f"no design {name!r}: allowed are exploring, ramp, plackett-burman, latin-hypercube and "
                "files that end in .csv"
            )
        return from_csv(robot, name)


def new_executor(
    scheduler: str | None, workers: int | None, runs: int
) -> AbstractContextManager[Executor]:
    """A Dask cluster, or at most one process for each run."""
    from tauten.reduction.campaign import dask_cluster, processes

    if scheduler is not None:
        return dask_cluster(scheduler)
    return processes(min(workers or os.cpu_count() or 1, runs))
