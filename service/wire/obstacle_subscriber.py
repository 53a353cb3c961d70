"""Poses of obstacles that arrive at run time: decoded, checked, counted, and continued at their velocity.

A pose is refused that is not finite, of another frame, older than the timeout of its obstacle or not newer
than the last one, or farther from it than the obstacle travels at its largest speed. The first one, and one
after the timeout, is refused too where the obstacle would appear within the robot. Between poses an
obstacle keeps the velocity that led from one to the next. Without a pose for longer than the timeout it
stands still where it is then.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
import zenoh

from tauten.model.contact import ObstaclePose, PoseStream, pose_at, velocity_between
from tauten.model.numerics import Array
from tauten.service.codec import Diagnostic, Level, MessageCounts, Rejection, RejectionReason
from tauten.service.wire.effector_subscriber import Ring, age_by, message_in, waiting

OBSTACLE_RING = 8  # samples of a key that are read in a tick; older ones are dropped unread
SHORTEST = 1e-3  # s between two poses, for their velocity
NEWER = 1e-5  # s, above the rounding of times since the epoch
STILL = 1e-4, 1e-3  # m and rad, that a pose may change by in no time: noise
FARTHEST = 1e3  # m from the origin
_NANO = 1e-9

Depth = Callable[[str, ObstaclePose], float]  # of an obstacle at a pose in the robot [m]


@dataclass(slots=True)
class _Track:
    """The last pose of an obstacle.

    Attributes:
        source: ring of its samples.
        stream: its limits.
        pose: last accepted, with its velocity; None before the first.
        made: monotonic time of it [s].
        moving: whether the obstacle has not been stopped since.
    """

    source: Ring
    stream: PoseStream
    pose: ObstaclePose | None = None
    made: float = -np.inf
    moving: bool = False


class ObstacleSubscriber:
    """Collects poses of a robot's obstacles.

    Attributes:
        counts: messages, accepted and refused by reason.
        stopped: how often a stream has stopped.
    """

    def __init__(
        self, sources: Mapping[str, tuple[Ring, PoseStream]], frame: str, deepest: float
    ) -> None:
        """Start without messages.

        Args:
            sources: ring of samples and limits of each obstacle, by its name.
            frame: the only frame accepted, beside an empty one.
            deepest: how deep an obstacle may be in the robot where it appears [m].
        """
        self._deepest = deepest
        self.counts = MessageCounts()
        self.stopped = 0
        self._frame = frame
        self._tracks = {name: _Track(*source) for name, source in sources.items()}

    def read(
        self, now: float, wall: float, ahead: float, depth_of: Depth
    ) -> dict[str, ObstaclePose]:
        """Read what has arrived; the obstacles that are elsewhere, or move otherwise, than they did before.

        Args:
            now: monotonic time [s].
            wall: time since the Unix epoch [s].
            ahead: after which time the poses are wanted [s].
            depth_of: how deep an obstacle would be in the robot.
        """
        changed = dict[str, ObstaclePose]()
        for name, track in self._tracks.items():
            fresh, samples = False, list(waiting(track.source, OBSTACLE_RING))
            for sample in reversed(samples):  # the newest that is good counts
                refused = self._take(name, track, sample, now, wall, depth_of)
                if refused is None:
                    self.counts.accepted += 1
                    fresh = True
                    break
                self.counts.refuse(refused)
            if track.pose is not None and fresh:
                changed[name] = track.pose.after(now - track.made + ahead)
            elif track.pose is not None and track.moving and self._is_silent(track, now):
                track.pose = track.pose.after(track.stream.timeout).still()
                track.moving = False
                self.stopped += 1
                changed[name] = track.pose
        return changed

    def diagnostic(self, now: float) -> Diagnostic:
        """Counts of poses, and for which obstacles they no longer arrive at a monotonic time [s]."""
        found = self.counts.diagnostic("obstacles")
        silent = [
            name
            for name, one in self._tracks.items()
            if one.pose is not None and self._is_silent(one, now)
        ]
        values = {**found.values, "stopped": str(self.stopped), "silent": ", ".join(silent)}
        if not silent:
            return replace(found, values=values)
        message = f"no poses any more, stand still: {', '.join(silent)}; {found.message}"
        return replace(found, level=Level.WARN, message=message, values=values)

    def _is_silent(self, track: _Track, now: float) -> bool:
        return now - track.made > track.stream.timeout

    def _take(
        self,
        name: str,
        track: _Track,
        sample: zenoh.Sample,
        now: float,
        wall: float,
        depth_of: Depth,
    ) -> Rejection | None:
        """Take a sample for the last pose of an obstacle, see `read`; why it is refused where it is."""
        message = message_in(sample, "frame", name, self._frame)
        if isinstance(message, Rejection):
            return message
        age = age_by(_NANO * message.stamp, wall)
        if sample.timestamp is not None and message.stamp == 0:
            age = age_by(sample.timestamp.get_time().timestamp(), wall)
        if age > track.stream.timeout:
            detail = (
                f"a pose of {name!r} is {age:.3g} s old, allowed are {track.stream.timeout:g} s"
            )
            return Rejection(RejectionReason.TOO_OLD, detail)
        values = np.array(message.values)
        if not (np.abs(values[:3]) <= FARTHEST).all():
            detail = f"a pose of {name!r} is farther than {FARTHEST:g} m from the origin"
            return Rejection(RejectionReason.OUT_OF_REACH, detail)
        pose, made = pose_at(values[:3], values[3:]), now - age
        appears = track.pose is None or made - track.made > track.stream.timeout
        if track.pose is not None:
            moving = _followed(name, track, pose, made)
            if isinstance(moving, Rejection):
                return moving
            pose = moving
        depth = depth_of(name, pose) if appears else 0.0
        if depth > self._deepest:
            detail = (
                f"{name!r} would appear {1e3 * depth:.3g} mm deep in the robot, allowed are "
                f"{1e3 * self._deepest:.3g} mm"
            )
            return Rejection(RejectionReason.NOT_PLAUSIBLE, detail)
        track.pose, track.made, track.moving = pose, made, True
        return None


def _followed(
    name: str, track: _Track, pose: ObstaclePose, made: float
) -> ObstaclePose | Rejection:
    """A pose with the velocity that led to it, or why it is refused."""
    assert track.pose is not None
    seconds, stream = made - track.made, track.stream
    if not seconds > NEWER:
        detail = f"a pose of {name!r} is not newer than the last one"
        return Rejection(RejectionReason.TOO_OLD, detail)
    way = velocity_between(track.pose, pose, 1.0)  # what it moved and turned by
    for what, moved, least, most, unit in (
        ("moved", way.velocity, STILL[0], stream.largest_speed, "m"),
        ("turned", way.spin, STILL[1], stream.largest_spin, "rad"),
    ):
        length = float(np.linalg.norm(moved))
        if length > least + most * seconds:
            detail = (
                f"{name!r} has {what} by {length:.3g} {unit} in {seconds:.3g} s, allowed are "
                f"{most:.3g} {unit}/s"
            )
            return Rejection(RejectionReason.NOT_PLAUSIBLE, detail)
    if seconds > stream.timeout:  # it stood still meanwhile
        return pose
    found = velocity_between(track.pose, pose, max(seconds, SHORTEST))
    return replace(
        found,
        velocity=_at_most(found.velocity, stream.largest_speed),
        spin=_at_most(found.spin, stream.largest_spin),
    )


def _at_most(vector: Array, length: float) -> Array:
    """A vector (3,) that is no longer than a length."""
    own = float(np.linalg.norm(vector))
    return vector if own <= length else vector * (length / own)
