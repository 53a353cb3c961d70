"""Errors of a reduced model under loads and in motions that took no part in its training.

The postures are random ones of a seed of their own, the loads lie at the ends of the ranges that a robot is
expected to meet: gravity turned by 20° about both horizontal axes, and the payload of the training that
pushes on the effectors along each axis. The motion is a swing of two seconds in small time steps, which both
models take, so that what is measured is the error of the reduction and not of the time step.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from scipy.linalg import null_space
from scipy.spatial.transform import Rotation

from tauten.model import Command, ContactSpace, Robot, Simulator, default_enrichment
from tauten.model.numerics import Array, FactorisationError
from tauten.reduction.campaign import (
    TOLERANCE,
    CommandRange,
    command_range,
    latin_hypercube_levels,
    payload,
)
from tauten.reduction.state import ReducedBody, ReducedParts

TILT = np.radians(20.0)  # of gravity
POSTURES = 3  # beside rest
SEED = 2026  # of the postures; campaigns begin at 0
MAX_ITERATIONS = 200  # of an equilibrium: with ribs in contact beams take up to 100
SWING, SWING_RATE = 2.0, 200.0  # s; steps in a second
SWING_SHARE = 0.9  # of the range of each actuator

LoadKind = Literal["own weight", "tilt", "payload", "motion"]
KINDS: tuple[LoadKind, ...] = ("own weight", "tilt", "payload", "motion")


@dataclass(frozen=True, slots=True)
class ForeignLoadError:
    """Distances of the effectors of reduced and full model under loads of one kind.

    Attributes:
        kind: "own weight" (postures under the gravity of the robot file), "tilt", "payload" or "motion".
        cases: equilibria, or time steps, that both models found.
        lost: those that only the full model found.
        mean: mean distance [m]; NaN without cases.
        largest: the largest [m]; NaN without cases.
        at: where the largest is, in words.
    """

    kind: LoadKind
    cases: int
    lost: int
    mean: float
    largest: float
    at: str


@dataclass(frozen=True, slots=True, eq=False)
class ForeignLoad:
    """A load of the comparison.

    Attributes:
        kind: which table row it belongs to.
        name: in words.
        gravity: (3,) [m/s²].
        force: (3 p,) on the effectors [N].
    """

    kind: LoadKind
    name: str
    gravity: Array
    force: Array


def load_errors(
    full: Robot,
    reduced: Robot[ReducedBody | ReducedParts],
    contact: Literal["none", "full"] | ContactSpace,
    progress: Callable[[str], None] = lambda _: None,
) -> tuple[ForeignLoadError, ...]:
    """Compare a reduced model with the full one under loads of each kind and in motion.

    Commands are those of `tauten.reduction.campaign.command_range`: positions of winches that do not pay out
    and of drives, efforts of all others. With their efforts given, cables leave a robot softer than with
    their positions, so that loads move it more.

    Args:
        full: the full robot.
        reduced: the same, reduced.
        contact: of the reduced model, as in a controller; the full one has pointwise contact.
        progress: called with what comes next.
    """
    found = command_range(full)
    pairs = _Pair.of(full, reduced, contact)
    each: dict[LoadKind, list[tuple[float, str]]] = {kind: [] for kind in KINDS}
    for name, command in postures(full, found):
        progress(name)
        for load, distance in pairs.in_posture(command, loads(full)):
            each[load.kind].append((distance, f"{load.name}, {name}"))
    fast = _Pair.of(at_rate(full, SWING_RATE), at_rate(reduced, SWING_RATE), contact)
    for name, shares in swings(full, found):
        progress(name)
        each["motion"] += [(distance, name) for distance in fast.in_motion(found, shares)]
    return tuple(_summary(kind, each[kind]) for kind in KINDS)


def postures(robot: Robot, found: CommandRange) -> list[tuple[str, Command]]:
    """Rest, and random commands within the ranges of the actuators, each with a name."""
    n_a = robot.n_a
    chosen = [("at rest", found.command(np.zeros(n_a)))]
    levels = latin_hypercube_levels(POSTURES, n_a, SEED) if n_a else np.zeros((0, 0))
    shares = np.where(found.least < 0.0, 2.0 * levels - 1.0, levels)
    return chosen + [(f"posture {i + 1}", found.command(share)) for i, share in enumerate(shares)]


def swings(robot: Robot, found: CommandRange) -> list[tuple[str, Array]]:
    """Shares (n_a,) of the ranges at the ends of swings: of the first actuator, and of all of several."""
    first = np.zeros(robot.n_a)
    first[:1] = SWING_SHARE
    chosen = [("swing of the first actuator", first)]
    if robot.n_a > 1:
        rng = np.random.default_rng(SEED)
        levels = rng.uniform(-1.0, 1.0, robot.n_a)
        shares = np.where(found.least < 0.0, levels, np.abs(levels))
        chosen.append(("swing of all actuators", SWING_SHARE * shares))
    return chosen


def loads(robot: Robot) -> list[ForeignLoad]:
    """Own weight, gravity tilted to four sides, payloads along six directions."""
    gravity, p = robot.gravity, len(robot.effector_names)
    nothing = np.zeros(3 * p)
    every = [ForeignLoad("own weight", "own weight", gravity, nothing)]
    if gravity.any():
        for i, axis in enumerate(null_space(gravity[None]).T):
            for sign, side in ((1.0, "+"), (-1.0, "-")):
                turned = Rotation.from_rotvec(sign * TILT * axis).apply(gravity)
                every.append(
                    ForeignLoad("tilt", f"gravity tilted {side}{'ab'[i]}", turned, nothing)
                )
    for i in range(3):
        for sign, side in ((1.0, "+"), (-1.0, "-")):
            force = np.zeros((p, 3))
            force[:, i] = sign * payload(robot, len(robot.effector_names))
            every.append(
                ForeignLoad("payload", f"payload {side}{'xyz'[i]}", gravity, force.ravel())
            )
    return every


def at_rate(robot: Robot, rate: float) -> Robot:
    """The robot with another time step, 1 / rate."""
    return robot.with_integration(replace(robot.integration, rate=rate))


@dataclass(frozen=True, slots=True, eq=False)
class _Pair:
    """Simulators of both models, taken through the same loads.

    Attributes:
        full, reduced: the simulators.
    """

    full: Simulator
    reduced: Simulator

    @classmethod
    def of(
        cls,
        full: Robot,
        reduced: Robot,
        contact: Literal["none", "full"] | ContactSpace,
    ) -> _Pair:
        """Simulators at rest.

        Args:
            full: the full robot.
            reduced: the reduced one.
            contact: of the reduced one.
        """
        enrichment = None if isinstance(contact, str) else default_enrichment(full.tolerance)
        pointwise: Literal["none", "full"] = "none" if contact == "none" else "full"
        return cls(Simulator(full, pointwise), Simulator(reduced, contact, enrichment))

    def in_posture(
        self, command: Command, every: list[ForeignLoad]
    ) -> Iterator[tuple[ForeignLoad, float]]:
        """Loads that the full model has an equilibrium under, with the distance there: NaN where lost.

        Args:
            command: of the posture, the same under all loads.
            every: loads, the first of which is the own weight.
        """
        full = self.full
        self._load(every[0])
        full.reset()
        self.reduced.reset()
        if not full.settle(command.position, command.effort, TOLERANCE, MAX_ITERATIONS).converged:
            return
        start = full.state, full.forces
        near = self._settled(self.reduced, command)
        own = self.reduced.state, self.reduced.forces
        yield every[0], self._apart() if near else np.nan
        for load in every[1:]:
            self._load(load)
            full.start_from(*start)
            self.reduced.start_from(*own)
            if self._settled(full, command):
                yield load, self._apart() if self._settled(self.reduced, command) else np.nan

    def in_motion(self, found: CommandRange, shares: Array) -> Iterator[float]:
        """Distance in each step of a swing there and back; NaN from where the reduced model diverges.

        Args:
            found: ranges of the actuators.
            shares: (n_a,) of these at the end of the swing.
        """
        for simulator in (self.full, self.reduced):
            simulator.settle_start()
        steps = round(SWING * SWING_RATE)
        for i in range(1, steps + 1):
            command = found.command(0.5 * (1.0 - np.cos(2.0 * np.pi * i / steps)) * shares)
            try:
                self.full.step(command.position, command.effort)
            except FactorisationError:
                return
            try:
                self.reduced.step(command.position, command.effort)
            except FactorisationError:
                yield np.nan
                return
            yield self._apart()

    def _load(self, load: ForeignLoad) -> None:
        for simulator in (self.full, self.reduced):
            simulator.load(load.gravity, load.force)

    def _apart(self) -> float:
        """Largest error of an effector [m]."""
        layout = self.full.robot.effector_layout
        return layout.error(self.reduced.effector_values, self.full.effector_values)

    @staticmethod
    def _settled(simulator: Simulator, command: Command) -> bool:
        """Whether an equilibrium was found."""
        try:
            return simulator.settle(
                command.position, command.effort, TOLERANCE, MAX_ITERATIONS
            ).converged
        except FactorisationError:
            return False


def _summary(kind: LoadKind, found: list[tuple[float, str]]) -> ForeignLoadError:
    """Mean and largest of the distances of one kind."""
    good = [(distance, at) for distance, at in found if np.isfinite(distance)]
    if not good:
        return ForeignLoadError(kind, 0, len(found), float("nan"), float("nan"), "")
    largest, at = max(good)
    mean = float(np.mean([distance for distance, _ in good]))
    return ForeignLoadError(kind, len(good), len(found) - len(good), mean, largest, at)
