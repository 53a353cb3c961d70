"""Targets of the cases: five ways of pulling the cables, as tips that the robot can reach.

A shape in space is out of reach of a robot with one cable, and the distance that remains is no measure
about a controller. So each case is a path of the pulled lengths, and its targets are where the
full-order robot with pointwise contact rests at them: a circle and a figure eight of two cables turn
into a swing and a double swing of one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from tauten.model import Robot, Simulator
from tauten.model.numerics import Array
from tauten.service.plant import PathError

CASES = ("step", "circle", "figure-eight", "random-walk", "contact")

_DEEPEST = 0.95  # of the largest pull
_GRID = 20  # equilibria on the way there, for one cable
_KNOTS = 16  # equilibria of a case, for several
_SETTLED = 1e-4  # m; targets need not be exact equilibria
_NEARLY_SETTLED = 1e-3  # m
_MAX_STEPS = 60


@dataclass(frozen=True, slots=True)
class Case:
    """One case.

    Attributes:
        name: one of `CASES`.
        targets: (s, n_v) goal values, one row a tick.
        from_tick: tick of the jump of "step"; 0 in others.
        jump: its size, by `EffectorLayout.error` [m]; 0 in others.
    """

    name: str
    targets: Array
    from_tick: int
    jump: float = 0.0


class Reachable:
    """Goal values at which a robot's effectors rest at given pulls."""

    def __init__(self, robot: Robot, progress: Callable[[], None]) -> None:
        """Settle a robot with one cable on a grid of pulls; others are settled when a path needs it.

        Args:
            robot: the robot.
            progress: called after each equilibrium.

        Raises:
            PathError: the model finds no equilibrium.
        """
        self._simulator = Simulator(robot, contact="full")
        self._progress = progress
        self._layout = robot.effector_layout
        self._curve: CubicSpline | None = None
        if robot.n_a == 1:
            shares = np.linspace(0.0, _DEEPEST, _GRID + 1)
            self._curve = CubicSpline(shares, self._settled(shares[:, None]))

    def path(self, shares: Callable[[Array], Array], phases: Array) -> Array:
        """Goal values (s, n_v) along a path of pulls.

        Args:
            shares: phases (m,) in 0 to 1 to shares of the largest pull (m, n_a).
            phases: (s,) of the ticks.
        """
        if self._curve is not None:
            return self._with_rotations(self._curve(shares(phases)[:, 0]))
        knots = np.linspace(0.0, 1.0, _KNOTS + 1)
        along = CubicSpline(knots, self._settled(shares(knots)))(phases)
        return self._with_rotations(along)

    def _with_rotations(self, values: Array) -> Array:
        """Values (s, n_v) between goal values, with quaternions of length one."""
        for effector, kind in enumerate(self._layout.kinds):
            if kind == "frame":
                q = values[:, self._layout.values_of(effector)][:, 3:]  # a view
                q /= np.linalg.norm(q, axis=1, keepdims=True)
        return values

    def _settled(self, shares: Array) -> Array:
        """Goal values (m, n_v) at shares (m, n_a) of the largest pull."""
        simulator, limits = self._simulator, self._simulator.robot.limits
        found = []
        for share in shares:
            position = share * limits.farthest_position
            report = simulator.settle(
                position=position, tolerance=_SETTLED, max_iterations=_MAX_STEPS, load_steps=False
            )
            if not report.movement < _NEARLY_SETTLED:
                shown = ", ".join(f"{1e3 * value:.1f}" for value in position)
                name = simulator.robot.name
                raise PathError(f"{name} finds no equilibrium at a pull of {shown} mm")
            found.append(simulator.effector_values)
            self._progress()
        return np.array(found)


def equilibria(n_a: int) -> int:
    """How many equilibria the cases of a robot with n_a cables need."""
    return _GRID + 1 if n_a == 1 else len(CASES) * (_KNOTS + 1)


def make_cases(robot: Robot, seconds: float, seed: int, progress: Callable[[], None]) -> list[Case]:
    """All cases of a robot.

    Args:
        robot: the robot.
        seconds: of each case.
        seed: of the random walk.
        progress: called after each equilibrium.

    Raises:
        PathError: the model finds no equilibrium.
    """
    ticks, reachable = round(seconds / robot.h), Reachable(robot, progress)
    phases = np.linspace(0.0, 1.0, ticks)
    simulator = Simulator(robot, contact="full")
    simulator.settle_start()
    rest = simulator.effector_values  # (n_v,)
    made = []
    for name in CASES:
        targets = reachable.path(shares_of(name, robot.n_a, seed), phases)  # (s, n_v)
        jump, size = 0, 0.0
        if name == "step":
            jump = ticks // 10
            targets[:jump] = rest
            size = robot.effector_layout.error(targets[-1], rest)
        made.append(Case(name, targets, jump, size))
    return made


def shares_of(name: str, n_a: int, seed: int) -> Callable[[Array], Array]:
    """A case's shares of the largest pulls (m, n_a) at phases (m,) from 0 to 1.

    Cable i lags by i / n_a of a turn, so that opposite cables are not pulled together.

    Args:
        name: one of `CASES`.
        n_a: number of cables.
        seed: of the random walk.
    """
    lag = 2.0 * np.pi * np.arange(n_a) / n_a  # (n_a,)

    def turning(phase: Array, turns: float) -> Array:
        angle = 2.0 * np.pi * turns * phase[:, None]
        if n_a == 1:
            return 0.5 * (1.0 - np.cos(angle))
        pulled: Array = np.maximum(np.cos(angle - lag), 0.0)
        return pulled

    def swell(phase: Array) -> Array:
        """From rest and back to it, so that no case begins with a jump."""
        ramp = np.minimum(1.0, 5.0 * np.minimum(phase, 1.0 - phase))[:, None]
        smooth: Array = ramp * ramp * (3.0 - 2.0 * ramp)
        return smooth

    def step(phase: Array) -> Array:
        return np.tile(0.5 * (lag == 0.0), (len(phase), 1))

    def circle(phase: Array) -> Array:
        return 0.6 * swell(phase) * turning(phase, 1.0)

    def figure_eight(phase: Array) -> Array:
        return swell(phase) * (0.4 * turning(phase, 1.0) + 0.2 * turning(phase, 2.0))

    def random_walk(phase: Array) -> Array:
        return swell(phase) * _random_walk(n_a, seed)(phase)

    def contact(phase: Array) -> Array:
        raised: Array = 0.5 * (1.0 - np.cos(2.0 * np.pi * phase[:, None]))
        return _DEEPEST * raised * np.where(lag == 0.0, 1.0, 0.0)

    shapes = (step, circle, figure_eight, random_walk, contact)
    return dict(zip(CASES, shapes, strict=True))[name]


def _random_walk(n_a: int, seed: int) -> Callable[[Array], Array]:
    """A smooth walk between 0 and 0.6, reflected at both."""
    steps = np.random.default_rng(seed).normal(0.0, 0.12, (13, n_a))
    walk = CubicSpline(np.linspace(0.0, 1.0, 13), np.cumsum(steps, axis=0))

    def at(phase: Array) -> Array:
        folded = np.mod(0.3 + walk(phase), 1.2)
        reflected: Array = np.minimum(folded, 1.2 - folded)
        return reflected

    return at
