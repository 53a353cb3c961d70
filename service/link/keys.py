"""Zenoh keys of a robot.

The first effector has the plain keys `target` and `effector`; the others of a robot that has
several add their name, `target/<name>`. Behind zenoh-bridge-ros2dds these are ROS 2 topics.
"""

from __future__ import annotations

from dataclasses import dataclass

ROOT = "tauten"


@dataclass(frozen=True, slots=True)
class Keys:
    """Keys of one robot.

    Attributes:
        robot: its name.
    """

    robot: str

    def _key(self, *parts: str) -> str:
        return "/".join((ROOT, self.robot, *parts))

    @property
    def token(self) -> str:
        """Liveliness token of the node."""
        return self._key()

    @property
    def starting(self) -> str:
        """Liveliness token of a node from the moment in which it begins to get ready."""
        return self._key("starting")

    def claim(self, session: str) -> str:
        """Liveliness token of a node that claims the robot, with the id of its session."""
        return self._key("claim", session)

    @property
    def description(self) -> str:
        """Queryable: the robot's description as JSON."""
        return self._key("description")

    @property
    def command(self) -> str:
        """Published by an operator, std_msgs/String, see `tauten.service.wire.commands`."""
        return self._key("command")

    @property
    def metrics(self) -> str:
        """Queryable: counters and histograms of the node as Prometheus text."""
        return self._key("metrics")

    @property
    def actuation(self) -> str:
        """Published by the node each tick, sensor_msgs/JointState: pull [m] and tension [N]."""
        return self._key("actuation")

    @property
    def tick(self) -> str:
        """Published by the node each tick, tauten_msgs/Tick: its decision and how fast it was."""
        return self._key("tick")

    @property
    def health(self) -> str:
        """Published by the node once a second, diagnostic_msgs/DiagnosticArray."""
        return self._key("health")

    @property
    def surface(self) -> str:
        """Published by the node while somebody listens, sensor_msgs/PointCloud2: skin and cables [m]."""
        return self._key("surface")

    @property
    def contacts(self) -> str:
        """Published by the node each tick, sensor_msgs/PointCloud2: the contacts that push [m, N]."""
        return self._key("contacts")

    @property
    def open_contacts(self) -> str:
        """Published by the node while somebody listens, as contacts: those in range that do not push."""
        return self._key("open_contacts")

    @property
    def plant_token(self) -> str:
        """Liveliness token of a plant."""
        return self._key("plant")

    @property
    def plant(self) -> str:
        """Everything a plant publishes."""
        return self._key("plant", "**")

    @property
    def plant_state(self) -> str:
        """Published by a plant, sensor_msgs/JointState: pull [m] and tension [N]."""
        return self._key("plant", "state")

    @property
    def plant_gap(self) -> str:
        """Published by a plant, std_msgs/Float64: smallest gap of its contacts [m]."""
        return self._key("plant", "gap")

    @property
    def plant_health(self) -> str:
        """Published by a plant once a second, diagnostic_msgs/DiagnosticArray."""
        return self._key("plant", "health")

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
