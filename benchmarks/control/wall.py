"""A trunk whose tip slides along a wall with 1 N, under controllers that know the wall and that do not.

Targets go to and fro along the wall. For the controller that does not know it they are behind it, by so much
that it presses with `FORCE` in the middle of the path. "wall and force" keeps the sum of the normal forces
between it and a tenth more, with the reduced model of the trunk as the others, and with that of full order.
The error is that along the wall.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.control.plants import (
    EXAMPLES,
    ObservedRobot,
    changed_example,
    force_of,
    observed,
    ramp,
)
from tauten.controller import Controller
from tauten.model import Simulator, load_robot
from tauten.model.numerics import Array
from tauten.service.bench import follow, rms
from tauten.service.replay import Spread, spread

FILE = EXAMPLES / "wall.toml"
FORCE = 1.0  # N
CONTROLLERS = ("no wall", "wall", "wall and force", "wall and force, full order")

_START = np.array([0.022, 0.0, -0.150])  # m, of the tip where it touches the wall
_WAY = 0.012  # m, along the wall to either side
_APPROACH, _REST, _PERIOD = 0.6, 0.4, 3.0  # s
_DEEPEST = 0.03  # m, behind the wall
_DEPTHS = 4  # that are tried


@dataclass(frozen=True, slots=True)
class WallRun:
    """A run along the wall.

    Attributes:
        controller: what it knows, one of `CONTROLLERS`.
        closed: whether measurements correct the targets.
        along_rms_mm: of the distance between target and tip along the wall.
        along_max_mm: largest.
        force_n: mean of the force on the wall.
        force_least_n: least.
        force_largest_n: largest.
        step_ms: of the whole control step.
        unusable: decisions that could not be used.
    """

    controller: str
    closed: bool
    along_rms_mm: float
    along_max_mm: float
    force_n: float
    force_least_n: float
    force_largest_n: float
    step_ms: Spread
    unusable: int


class WallBench:
    """The plant and its controllers.

    Attributes:
        plant: of full order.
        depth: of targets behind the wall, of the controller that does not know it [m].
    """

    def __init__(self, depth: float | None = None, steps: int | None = None) -> None:
        """Make plant and controllers.

        Args:
            depth: of targets behind the wall [m]; None: it is found.
            steps: of the plant in a period; None: as many as it needs.
        """
        with TemporaryDirectory() as folder:
            bounds = f"min_force = {FORCE}\nmax_force = {1.1 * FORCE}"
            changes = {"friction = 0.3": f"friction = 0.3\n{bounds}"}
            file = changed_example(FILE.name, Path(folder), changes)
            pressing = Controller.of(file), Controller.of(file, model="full")
        made = Controller.of("trunk"), Controller.of(FILE), *pressing
        self._controllers = dict(zip(CONTROLLERS, made, strict=True))
        h = self._controllers["wall"].period
        simulator = Simulator(load_robot(FILE, rate=1.0 / h), "full")
        self.plant: ObservedRobot = observed(simulator, _seen, steps)
        self.depth = self._pressing_depth() if depth is None else depth

    def run(self, controller: str, closed: bool, seconds: float = _PERIOD) -> WallRun:
        """One run, from the start.

        Args:
            controller: one of `CONTROLLERS`.
            closed: whether measurements correct the targets.
            seconds: of the way along the wall.
        """
        used = self._controllers[controller]
        targets = self.targets(self.depth if controller == "no wall" else 0.0, seconds)
        trace = follow(used, self.plant, targets, closed=closed)
        first = len(targets) - round(seconds / used.period)
        seen = np.array(self.plant.seen)[first:]  # (s, 4) tip and force
        along = np.linalg.norm(seen[:, 1:3] - targets[first:, 1:3], axis=1)
        force = seen[:, 3]
        return WallRun(
            controller=controller,
            closed=closed,
            along_rms_mm=1e3 * rms(along),
            along_max_mm=1e3 * float(along.max()),
            force_n=float(force.mean()),
            force_least_n=float(force.min()),
            force_largest_n=float(force.max()),
            step_ms=spread((1e3 * trace.step[first:]).tolist()),
            unusable=int(trace.unusable.sum()),
        )

    def targets(self, depth: float, seconds: float) -> Array:
        """Positions (s, 3) of the tip, one a period [m].

        Args:
            depth: behind the wall [m].
            seconds: of the way along it.
        """
        used = self._controllers["no wall"]
        used.reset()
        rest, wanted = used.effector[0], _START + np.array([depth, 0.0, 0.0])
        approach = rest + ramp(round(_APPROACH / used.period))[:, None] * (wanted - rest)
        still = np.tile(wanted, (round(_REST / used.period), 1))
        phase = 2.0 * np.pi * used.period / _PERIOD * np.arange(1, round(seconds / used.period) + 1)
        way = np.zeros((len(phase), 3))
        way[:, 1] = _WAY * np.sin(phase)
        found: Array = np.concatenate([approach, still, wanted + way])
        return found

    def _pressing_depth(self) -> float:
        """How far behind the wall targets are for `FORCE`, by bisection [m]."""
        low, high = 0.0, _DEEPEST
        used = self._controllers["no wall"]
        for _ in range(_DEPTHS):
            middle = 0.5 * (low + high)
            follow(used, self.plant, self.targets(middle, 0.0))
            low, high = (middle, high) if self.plant.seen[-1][3] < FORCE else (low, middle)
        return 0.5 * (low + high)


def _seen(simulator: Simulator) -> Array:
    """Tip and force on the wall: (4,) [m, N]."""
    return np.append(simulator.tip, 0.0 - force_of(simulator, 0)[0])
