"""Zenoh keys of a robot.

The first effector has the plain keys `target` and `effector`; the others of a robot that has
several add their name, `target/<name>`. Behind zenoh-bridge-ros2dds these are ROS 2 topics.
"""

from __future__ import annotations

from dataclasses import dataclass

ROOT = "tauten"


class _Key:
    """A key of a robot by its parts after the robot's name."""

    def __init__(self, *parts: str) -> None:
        self._parts = parts

    def __get__(self, keys: Keys | None, _owner: type) -> str:
        return "" if keys is None else keys._key(*self._parts)


@dataclass(frozen=True, slots=True)
class Keys:
    """Keys of one robot.

    Attributes:
        robot: its name.
    """

    robot: str

    #: Liveliness token of the node.
    token = _Key()
    #: Liveliness token of a node from the moment in which it begins to get ready.
    starting = _Key("starting")
    #: Queryable: the robot's description as JSON.
    description = _Key("description")
    #: Published by an operator, std_msgs/String, see `tauten.service.wire.commands`.
    command = _Key("command")
    #: Queryable: counters and histograms of the node as Prometheus text.
    metrics = _Key("metrics")
    #: Published by the node each tick, sensor_msgs/JointState: pull [m] and tension [N].
    actuation = _Key("actuation")
    #: Published by the node each tick, tauten_msgs/Tick: its decision and how fast it was.
    tick = _Key("tick")
    #: Published by the node once a second, diagnostic_msgs/DiagnosticArray.
    health = _Key("health")
    #: Published by the node while somebody listens, sensor_msgs/PointCloud2: skin and cables [m].
    surface = _Key("surface")
    #: Published by the node each tick, sensor_msgs/PointCloud2: the contacts that push [m, N].
    contacts = _Key("contacts")
    #: Published by the node while somebody listens, as contacts: those in range that do not push.
    open_contacts = _Key("open_contacts")
    #: Liveliness token of a plant.
    plant_token = _Key("plant")
    #: Everything a plant publishes.
    plant = _Key("plant", "**")
    #: Published by a plant, sensor_msgs/JointState: pull [m] and tension [N].
    plant_state = _Key("plant", "state")
    #: Published by a plant, std_msgs/Float64: smallest gap of its contacts [m].
    plant_gap = _Key("plant", "gap")
    #: Published by a plant once a second, diagnostic_msgs/DiagnosticArray.
    plant_health = _Key("plant", "health")

    def _key(self, *parts: str) -> str:
        return "/".join((ROOT, self.robot, *parts))

    def claim(self, session: str) -> str:
        """Liveliness token of a node that claims the robot, with the id of its session."""
        return self._key("claim", session)

    def obstacle(self, name: str) -> str:
        """Where an obstacle is, geometry_msgs/PoseStamped to the node."""
        return self._key("obstacle", name)

    def obstacle_state(self, name: str) -> str:
        """Published by the node each tick, nav_msgs/Odometry: where its model has an obstacle."""
        return self._key("obstacle_state", name)

    def wrench(self, name: str) -> str:
        """Published by the node each tick, geometry_msgs/WrenchStamped: on an obstacle or a part."""
        return self._key("wrench", name)

    def targets(self, effectors: tuple[str, ...]) -> tuple[str, ...]:
        """Key of each effector's target, of the message type of its kind."""
        return tuple(self._key("target", *parts) for parts in _suffixes(effectors))

    def measurements(self, effectors: tuple[str, ...]) -> tuple[str, ...]:
        """Key of each effector's measured values, of the message type of its kind."""
        return tuple(self._key("measurement", *parts) for parts in _suffixes(effectors))

    def effectors(self, effectors: tuple[str, ...]) -> tuple[str, ...]:
        """Key of each effector's values in the model, of the message type of its kind."""
        return tuple(self._key("effector", *parts) for parts in _suffixes(effectors))

    def plant_effectors(self, effectors: tuple[str, ...]) -> tuple[str, ...]:
        """Key of each effector's values in a plant, of the message type of its kind."""
        return tuple(self._key("plant", "effector", *parts) for parts in _suffixes(effectors))


def _suffixes(effectors: tuple[str, ...]) -> list[tuple[str, ...]]:
    return [() if index == 0 else (name,) for index, name in enumerate(effectors)]
