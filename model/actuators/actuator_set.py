"""The actuators of a robot: cables, chambers, forces, drives, transmissions, and their couplings."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Generic, Protocol, TypeVar

import numpy as np

from tauten.model.actuators.chamber import ChamberSet
from tauten.model.actuators.coupling import Coupling
from tauten.model.actuators.drive import DriveSet
from tauten.model.actuators.force import ForceSet
from tauten.model.actuators.transmission import TransmissionSet
from tauten.model.numerics import Array, Ints
from tauten.model.points import Motion, Paths
from tauten.model.rows import Rows, stack

P = TypeVar("P")


class ActuatorRows(Protocol):
    """What a robot asks of its actuators, over points of its body (`tauten.model.points.Motion`)."""

    @property
    def n_a(self) -> int:
        """Number of motors, the length of λ_a."""

    @property
    def motor_coordinates(self) -> Ints:
        """Degrees of freedom that a motor holds: those of drives and drums."""

    @property
    def segment_owners(self) -> Ints:
        """The actuator of every segment that `segments` gives: (s,)."""

    def segments(self, motion: Motion[Any]) -> Array:
        """Segments by which cables, forces and drives are drawn: (s, 2, 3) [m], see `Robot`."""

    def rows(self, motion: Motion[Any]) -> Rows:
        """Positions δ_a and H_a: Rows of (n_a, n)."""


@dataclass(frozen=True, slots=True)
class Loads:
    """Efforts of all single actuators but drives.

    Attributes:
        tension: (cables,) [N].
        pressure: (chambers,) [Pa]; zero where only the positive semidefinite part is wanted.
        push: (forces,) [N].
        transmitted: (transmissions,); zero where only the positive semidefinite part is wanted.
    """

    tension: Array
    pressure: Array
    push: Array
    transmitted: Array


@dataclass(frozen=True)
class ActuatorSet(Generic[P]):
    """The actuators of a robot over points of its body, which are of type P (`tauten.model.points.Motion`).

    Attributes:
        paths: of the cables.
        stations: points that the cables pass.
        chambers: cavities under pressure.
        walls: points of their surfaces, `ChamberSet.used`.
        forces: of fixed direction.
        pushed: the point that each of them acts on.
        drives: what moves a coordinate of the robot directly.
        coupling: of all of these; None: each is driven alone.
        transmissions: functions of points; None: there are none.
    """

    paths: Paths
    stations: P
    chambers: ChamberSet
    walls: P
    forces: ForceSet
    pushed: P
    drives: DriveSet
    coupling: Coupling | None
    transmissions: TransmissionSet[P] | None = None

    @cached_property
    def n_a(self) -> int:
        """Number of motors, the length of λ_a."""
        return self.n_members if self.coupling is None else self.coupling.n_a

    @property
    def motor_coordinates(self) -> Ints:
        """Degrees of freedom that a motor holds: those of drives and drums."""
        return self.drives.columns

    @cached_property
    def n_members(self) -> int:
        """Number of single actuators."""
        transmissions = 0 if self.transmissions is None else len(self.transmissions)
        return self.ends[2] + transmissions + len(self.drives)

    @cached_property
    def ends(self) -> tuple[int, int, int]:
        """Where cables, chambers and forces end among `others`."""
        cables, chambers = self.paths.n_a, len(self.chambers)
        return cables, cables + chambers, cables + chambers + len(self.forces)

    @property
    def others(self) -> Ints:
        """Numbers of cables, chambers, forces, then transmissions among all single actuators."""
        return self.drives.others(self.n_members)

    @property
    def segment_owners(self) -> Ints:
        """The actuator of every segment that `segments` gives: (s,)."""
        others, cables, forces = self.others, self.paths.owner, np.arange(len(self.forces))
        first = self.ends[1]
        parts = [others[cables], others[first + forces]]
        parts.append(self.drives.places[: len(self.drives.axes)])
        if self.transmissions is not None:
            parts.append(others[first + len(forces) + self.transmissions.segment_owners])
        return self.motors(np.concatenate(parts))

    def segments(self, motion: Motion[P]) -> Array:
        """Segments by which all but chambers are drawn: (s, 2, 3) [m], see `Robot`."""
        cables = self.paths.segments(motion.placed(self.stations).y)
        forces = self.forces.segments(motion.placed(self.pushed).y)
        parts = [cables, forces, self.drives.segments(motion.travel)]
        if self.transmissions is not None:
            parts.append(self.transmissions.segments(motion))
        return np.concatenate(parts)

    def chamber_owners(self, triangles: Ints) -> Ints:
        """The actuator whose chamber each of some triangles (t, 3) of nodes encloses; −1 where none: (t,)."""
        members = np.full(len(triangles), -1)
        if len(self.chambers) == 0:
            return members
        number = {tuple(one): i for i, one in enumerate(np.sort(triangles, axis=1).tolist())}
        surface, owner = self.chambers.boundary_triangles()
        for corners, chamber in zip(np.sort(surface, axis=1).tolist(), owner, strict=True):
            if tuple(corners) in number:
                members[number[tuple(corners)]] = self.others[self.paths.n_a + chamber]
        return self.motors(members)

    def motors(self, members: Ints) -> Ints:
        """The actuators (m,) that drive single actuators (m,); −1 remains −1."""
        return members if self.coupling is None else self.coupling.motors_of(members)

    def rows(self, motion: Motion[P]) -> Rows:
        """Positions δ_a and H_a: Rows of (n_a, n)."""
        if self.coupling is not None:
            return self.coupling.rows(self.member_rows(motion))
        return self.member_rows(motion) if len(self.drives.places) > 0 else self.other_rows(motion)

    def member_rows(self, motion: Motion[P]) -> Rows:
        """Rows of the single actuators."""
        others = self.other_rows(motion)
        return self.drives.among(others, motion) if len(self.drives.places) > 0 else others

    def other_rows(self, motion: Motion[P]) -> Rows:
        """Rows of cables, chambers, forces and transmissions, in the order of `others`."""
        parts = [self.paths.rows(motion.placed(self.stations))]
        cables, walled, pushed = self.ends
        if walled > cables:
            parts.append(self.chambers.rows(motion.placed(self.walls)))
        if pushed > walled:
            parts.append(self.forces.rows(motion.placed(self.pushed)))
        if self.transmissions is not None:
            parts.append(self.transmissions.rows(motion))
        return parts[0] if len(parts) == 1 else stack(parts)

    def efforts(self, lam: Array | None) -> Array | None:
        """Efforts on single actuators, in the order of `others`, under those lam (n_a,) of the motors.

        With None those of the offsets of couplings; None where there are none.
        """
        if self.coupling is not None:
            lam = self.coupling.efforts(np.zeros(self.n_a) if lam is None else lam)
        return lam if lam is None or len(self.drives.places) == 0 else lam[self.others]

    def loads(self, efforts: Array | None, exact: bool) -> Loads | None:
        """Efforts, from `efforts`, whose rows turn with the body; None where there are none.

        Unless `exact` without what is not positive semidefinite: pressures, and rods that push.
        """
        if efforts is None:
            return None
        cables, walled, pushed = self.ends
        tension, pressure = efforts[:cables], efforts[cables:walled]
        push, transmitted = efforts[walled:pushed], efforts[pushed:]
        if exact:
            return Loads(tension, pressure, push, transmitted)
        return Loads(
            np.maximum(tension, 0.0), np.zeros(len(pressure)), push, np.zeros(len(transmitted))
        )

    def spread(self, motion: Motion[P], loads: Loads) -> list[tuple[P, Array]]:
        """Forces on the points of forces, then of transmissions: points and vectors (p, 3) [N]."""
        parts = []
        if len(self.forces) > 0:
            parts.append((self.pushed, self.forces.vectors(loads.push)))
        if (moved := self.transmissions) is not None:
            y = motion.placed(moved.points).y
            parts.append((moved.points, moved.vectors(y, loads.transmitted)))
        return parts

    @cached_property
    def is_preloaded(self) -> bool:
        """Whether couplings have offsets."""
        return self.coupling is not None and self.coupling.is_preloaded

    def preload(self, motion: Motion[P]) -> tuple[Array, float] | None:
        """Force (n,) [N] of the offsets of couplings, and its work since rest [J]; None without any."""
        if self.coupling is None or not self.is_preloaded:
            return None
        members, offsets = self.member_rows(motion), self.coupling.offsets
        force: Array = members.H.T @ offsets
        return force, float(offsets @ members.delta)
