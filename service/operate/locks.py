"""Locking actuators of a robot that is served: an order is checked against the robot's description first."""

from __future__ import annotations

from tauten.service.link import (
    Keys,
    LockOrder,
    Network,
    NodeAnswer,
    OrderError,
    node_of,
    send_command,
)
from tauten.service.wire import RobotDescription, ask_description


def send_lock(robot: str, network: Network, order: LockOrder) -> NodeAnswer:
    """Lock or unlock an actuator; returns what the node answers.

    Args:
        robot: name.
        network: of the robot.
        order: what is locked, and where.

    Raises:
        NetworkError: no node, or one that does not answer.
        OrderError: no such actuator, a value beyond its limits, or a refusal of the node.
    """
    with node_of(robot, network) as session:
        description = ask_description(session, Keys(robot))
    check_order(description, order)
    return send_command(robot, network, order)


def check_order(description: RobotDescription, order: LockOrder) -> None:
    """Raise an `OrderError` where a robot, by its description, cannot be locked so."""
    actuators = {one.name: one for one in description.actuators}
    if order.actuator not in actuators:
        raise OrderError(
            f"{description.name} has no actuator {order.actuator!r}, its actuators are "
            f"{', '.join(actuators)}"
        )
    found = actuators[order.actuator]
    for option, value, (least, most), unit in (
        ("--position", order.position, found.position, found.kind.position.unit),
        ("--force", order.force, found.effort, found.kind.effort.unit),
    ):
        if value is not None and not least <= value <= most:
            raise OrderError(
                f"{option} {value:g}: {found.kind.value} {order.actuator} allows {least:g} to {most:g} {unit}"
            )
