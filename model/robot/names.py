"""The names in a robot file."""

from __future__ import annotations

from dataclasses import dataclass

from tauten.model.schema import RobotSettings


@dataclass(frozen=True, slots=True)
class RobotNames:
    """Names in keys, messages and tables.

    Attributes:
        robot: of the robot.
        frame: frame id of its positions.
        effectors: in row order.
    """

    robot: str
    frame: str
    effectors: tuple[str, ...]


def names_of(config: RobotSettings) -> RobotNames:
    """The names in a robot file."""
    return RobotNames(
        robot=config.name,
        frame=config.frame,
        effectors=tuple(effector.name for effector in config.effectors),
    )
