"""Obstacles: shapes in places, which may move; what they do is given to a robot, it does not compute it.

A pose is where the frame of a shape stands in that of the robot, with the velocity of its origin and its
spin. `ObstaclePoses` are those of all obstacles at one time, and a value: `after` gives them a time later,
along the path of an obstacle that has one, and otherwise at the velocity of its pose. `ContactSet.placed`
gives the contacts with obstacles in other poses.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import cast

import numpy as np

from tauten.model.contact.shapes import DrawnShape, NearShape, Shape, distances_fault, outline_fault
from tauten.model.extension_error import answer_of
from tauten.model.numerics import Array, Ints, product, rotations_between, turned


@dataclass(frozen=True, eq=False)
class ObstaclePose:
    """Where the frame of an obstacle stands, and how it moves.

    Attributes:
        position: (3,) of its origin in the robot's frame [m].
        quaternion: (4,) unit quaternion w, x, y, z of its rotation.
        velocity: (3,) of its origin [m/s].
        spin: (3,) its angular velocity about the axes of the robot's frame [rad/s].
    """

    position: Array
    quaternion: Array
    velocity: Array
    spin: Array

    @cached_property
    def moves(self) -> bool:
        """Whether it has a velocity."""
        return bool(self.velocity.any() or self.spin.any())

    @cached_property
    def is_upright(self) -> bool:
        """Whether the axes of the obstacle's frame are those of the robot's."""
        return not self.quaternion[1:].any()

    @cached_property
    def Q(self) -> Array:
        """(3, 3) rotation from the obstacle's frame to the robot's."""
        w, x, y, z = self.quaternion.tolist()
        return np.array([
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ])  # fmt: skip

    def velocity_at(self, points: Array) -> Array:
        """Velocities (m, 3) of what is fixed in the frame at points (m, 3) of the robot's frame [m/s]."""
        found: Array = self.velocity + np.cross(self.spin, points - self.position)
        return found

    def still(self) -> ObstaclePose:
        """The same place without velocity."""
        return replace(self, velocity=np.zeros(3), spin=np.zeros(3))

    def after(self, seconds: float) -> ObstaclePose:
        """A time later at the same velocity."""
        if not self.moves:
            return self
        turn = (self.spin * seconds)[None]
        there = turned(self.quaternion[None], turn)[0]
        return replace(self, position=self.position + seconds * self.velocity, quaternion=there)

    def within(self, place: ObstaclePose) -> ObstaclePose:
        """The same pose where the frame that it refers to stands, and stays, at a place in another one."""
        Q = place.Q
        turn = product(_tuple(place.quaternion), _tuple(self.quaternion))
        return ObstaclePose(
            place.position + Q @ self.position, np.array(turn), Q @ self.velocity, Q @ self.spin
        )


def _tuple(quaternion: Array) -> tuple[float, float, float, float]:
    w, x, y, z = quaternion.tolist()
    return (w, x, y, z)


def pose_at(
    position: Array | Sequence[float] | None = None,
    quaternion: Array | Sequence[float] | None = None,
    velocity: Array | Sequence[float] | None = None,
    spin: Array | Sequence[float] | None = None,
) -> ObstaclePose:
    """A pose.

    Args:
        position: (3,) [m]; None: the origin.
        quaternion: (4,) w, x, y, z of any length but zero; None: no rotation.
        velocity: (3,) of the origin [m/s]; None: zero.
        spin: (3,) about the axes of the robot's frame [rad/s]; None: zero.

    Raises:
        ValueError: other numbers of numbers, some that are not finite, or a quaternion without length.
    """
    given = (position, velocity, spin)
    try:
        turn = np.array([1.0, 0.0, 0.0, 0.0] if quaternion is None else quaternion, dtype=float)
        vectors = [np.array(np.zeros(3) if one is None else one, dtype=float) for one in given]
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"a pose has numbers only: {error}") from error
    found = [*vectors, turn]
    if turn.shape != (4,) or any(one.shape != (3,) for one in vectors):
        raise ValueError(
            "a pose has a position, a velocity and a spin of 3 numbers and a quaternion of 4, found "
            f"{', '.join(str(one.shape) for one in found)}"
        )
    length = float(np.linalg.norm(turn))
    if not all(np.isfinite(one).all() for one in found) or not length > 1e-9:
        raise ValueError(
            "a pose needs finite numbers and a quaternion that is not zero, found "
            f"{', '.join(str(one.tolist()) for one in found)}"
        )
    return ObstaclePose(vectors[0], turn / length, vectors[1], vectors[2])


def velocity_between(before: ObstaclePose, after: ObstaclePose, seconds: float) -> ObstaclePose:
    """The second pose, with the velocity and spin that lead there from the first.

    Args:
        before: the first pose.
        after: the second one.
        seconds: between them.
    """
    turn = rotations_between(before.quaternion[None], after.quaternion[None])[0]
    return replace(
        after, velocity=(after.position - before.position) / seconds, spin=turn / seconds
    )


@dataclass(frozen=True, slots=True, eq=False)
class ObstaclePath:
    """Poses at times, between which an obstacle moves evenly.

    Attributes:
        times: (k,) ascending from zero [s].
        poses: at these times.
        loop: whether it starts again after the last one; otherwise it stays there.
    """

    times: Array
    poses: tuple[ObstaclePose, ...]
    loop: bool

    def at(self, time: float) -> ObstaclePose:
        """Pose and velocity at a time from the start [s]."""
        end = float(self.times[-1])
        if self.loop:
            time = time % end
        elif time >= end:
            return self.poses[-1]
        leg = int(np.searchsorted(self.times, time, side="right")) - 1
        leg = min(max(leg, 0), len(self.poses) - 2)  # rounding leads to just before the start
        start, seconds = self.poses[leg], float(self.times[leg + 1] - self.times[leg])
        moving = velocity_between(start, self.poses[leg + 1], seconds)
        from_start = replace(start, velocity=moving.velocity, spin=moving.spin)
        return from_start.after(time - float(self.times[leg]))

    def within(self, place: ObstaclePose) -> ObstaclePath:
        """The same path where the frame that it refers to stands in another one."""
        return replace(self, poses=tuple(pose.within(place) for pose in self.poses))


@dataclass(frozen=True, slots=True)
class PoseStream:
    """What poses of an obstacle may arrive at run time.

    Attributes:
        largest_speed: at which it may move [m/s].
        largest_spin: likewise [rad/s].
        timeout: without a pose after which it stands still [s].
    """

    largest_speed: float
    largest_spin: float
    timeout: float


@dataclass(frozen=True, slots=True, eq=False)
class Obstacle:
    """A shape with a name, and where it is at the start.

    Attributes:
        name: of the robot file, with that of the part in front where it belongs to one.
        shape: in its own frame.
        pose: of that frame at the start.
        path: along which it moves; None: it moves only where its pose has a velocity.
        stream: of poses that may arrive; None: none may.
        max_force: sum of the normal forces on it that decisions keep at most [N].
    """

    name: str
    shape: Shape
    pose: ObstaclePose
    path: ObstaclePath | None = None
    stream: PoseStream | None = None
    max_force: float = math.inf

    @property
    def start(self) -> ObstaclePose:
        """Where it is at the start: at the beginning of its path, or at its pose."""
        return self.pose if self.path is None else self.path.at(0.0)

    @property
    def may_move(self) -> bool:
        """Whether it follows a path or a stream of poses."""
        return self.path is not None or self.stream is not None

    def within(self, name: str, place: ObstaclePose) -> Obstacle:
        """The same obstacle by another name, where the frame of its part stands in that of a robot."""
        path = self.path and self.path.within(place)
        return replace(self, name=name, pose=self.pose.within(place), path=path)

    def closest(self, points: Array, pose: ObstaclePose, reach: float) -> tuple[Array, Array]:
        """Signed distances (m,) of points (m, 3) [m], and their gradients (m, 3).

        Args:
            points: in the robot's frame [m].
            pose: of the obstacle.
            reach: distance up to which all are wanted [m].
        """
        Q = None if pose.is_upright else pose.Q
        own = points - pose.position if pose.position.any() else points
        gap, normal = self.closest_own(own if Q is None else own @ Q, reach)
        return gap, normal if Q is None else normal @ Q.T

    def closest_own(self, points: Array, reach: float) -> tuple[Array, Array]:
        """Signed distances (m,) of points (m, 3) in its own frame, up to `reach` [m], and gradients (m, 3).

        Raises:
            ExtensionError: the shape of another package has failed, or gives no distances.
        """
        if hasattr(self.shape, "closest_within"):  # faster than to ask for the protocol
            return cast(NearShape, self.shape).closest_within(points, reach)
        fault = partial(distances_fault, m=len(points))
        gap, normal = answer_of(
            f"shape of obstacle {self.name!r}", fault, self.shape.closest, points
        )
        unknown = np.isnan(gap)
        if np.logical_or.reduce(unknown):
            unknown &= np.isfinite(points).all(axis=1)
            # contacts of no finite distance, with which nothing is decided
            gap = np.where(unknown, -np.inf, gap)
            normal = np.where(unknown[:, None], np.nan, normal)
        return gap, normal

    def outline(self, pose: ObstaclePose, centre: Array, extent: float) -> tuple[Array, Ints]:
        """Vertices (v, 3) [m] in its own frame and triangles (t, 3); none of a shape that is not drawn.

        Args:
            pose: of the obstacle.
            centre: (3,) in the robot's frame that shapes without end are drawn around [m].
            extent: how much of them is drawn [m].

        Raises:
            ExtensionError: the shape of another package has failed, or gives no triangles.
        """
        if not isinstance(self.shape, DrawnShape):
            return np.zeros((0, 3)), np.zeros((0, 3), np.int64)
        what, own = f"outline of the shape of obstacle {self.name!r}", centre - pose.position
        vertices, triangles = answer_of(
            what, outline_fault, self.shape.outline, own @ pose.Q, extent
        )
        return vertices, triangles


@dataclass(frozen=True, eq=False)
class ObstaclePoses:
    """Where all obstacles of a robot are at one time.

    Attributes:
        obstacles: what they are.
        poses: of each.
        time: since the start, for those that move along paths [s].
        given: of each, whether its pose was given, and is not that of its path.
    """

    obstacles: tuple[Obstacle, ...]
    poses: tuple[ObstaclePose, ...]
    time: float = 0.0
    given: tuple[bool, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Of the obstacles."""
        return tuple(one.name for one in self.obstacles)

    @cached_property
    def move(self) -> bool:
        """Whether one moves."""
        return any(pose.moves for pose in self.poses)

    @cached_property
    def change(self) -> bool:
        """Whether one moves now or may do so later along its path."""
        return self.move or any(one.path is not None for one in self.obstacles)

    @property
    def by_name(self) -> dict[str, ObstaclePose]:
        """The poses by the names of the obstacles."""
        return dict(zip(self.names, self.poses, strict=True))

    def number(self, name: str) -> int:
        """Of an obstacle.

        Raises:
            ValueError: there is none of this name.
        """
        if name not in self.names:
            raise ValueError(
                f"there is no obstacle {name!r}, known are {', '.join(self.names) or 'none'}"
            )
        return self.names.index(name)

    def after(self, seconds: float) -> ObstaclePoses:
        """A time later: along their paths, others at their velocities."""
        if seconds == 0.0 or not self.change:
            return self
        time = self.time + seconds
        poses = tuple(
            pose.after(seconds) if one.path is None or given else one.path.at(time)
            for one, pose, given in zip(self.obstacles, self.poses, self.given, strict=True)
        )
        return replace(self, poses=poses, time=time)

    def still(self) -> ObstaclePoses:
        """The same places without velocities."""
        if not self.move:
            return self
        return replace(self, poses=tuple(pose.still() for pose in self.poses))

    def at_start(self) -> ObstaclePoses:
        """Those at the start."""
        return poses_at_start(self.obstacles)

    def with_given(self, seen: ObstaclePoses) -> ObstaclePoses:
        """The poses of others of the same obstacles where they were given; else those of this one."""
        chosen = zip(self.poses, seen.poses, seen.given, strict=True)
        poses = tuple(theirs if given else own for own, theirs, given in chosen)
        return replace(self, poses=poses, given=seen.given)

    def with_pose(self, name: str, pose: ObstaclePose) -> ObstaclePoses:
        """One obstacle at another pose; it no longer follows a path.

        Raises:
            ValueError: there is none of this name.
        """
        i = self.number(name)
        poses = (*self.poses[:i], pose, *self.poses[i + 1 :])
        given = (*self.given[:i], True, *self.given[i + 1 :])
        return replace(self, poses=poses, given=given)


def poses_at_start(obstacles: tuple[Obstacle, ...]) -> ObstaclePoses:
    """Where obstacles are at the start: at the beginning of their paths, others at the pose of the file."""
    poses = tuple(one.start for one in obstacles)
    return ObstaclePoses(obstacles, poses, given=(False,) * len(obstacles))
