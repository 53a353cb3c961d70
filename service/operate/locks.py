"""Locking actuators of a robot that is served: an order is checked against the robot's description first."""

from __future__ import annotations

from typing import Any

from tauten.service.operate.commands import node_of, send_command
from tauten.service.wire import Keys, LockOrder, Mode, Network, Tick, ask_description


class OrderError(ValueError):
    """An order that the node refuses; the text says what is allowed."""


def send_lock(robot: str, network: Network, order: LockOrder) -> Tick:
    """Lock or unlock an actuator; returns a tick of the node after it.

    Args:
        robot: name.
        network: of the robot.
        order: what is locked, and where.

    Raises:
        NetworkError: no node, or one that does not tick.
        OrderError: no such actuator, a value beyond its limits, or a node that stops.
    """
    with node_of(robot, network) as session:
        description = ask_description(session, Keys(robot))
    check_order(description, order)
    tick = send_command(robot, network, order)
    if tick.mode is Mode.STOP:
        raise OrderError(f"{robot} is in a stop, in which nothing is locked: reset it first")
    return tick


def check_order(description: dict[str, Any], order: LockOrder) -> None:
    """Raise an `OrderError` where a robot, by its description, cannot be locked so."""
    actuators = {item["name"]: item for item in description["actuators"]}
    if order.actuator not in actuators:
        raise OrderError(
            f"{description['robot']} has no actuator {order.actuator!r}, its actuators are "
            f"{', '.join(actuators)}"
        )
    found = actuators[order.actuator]
    for name, option, value in (
        ("pull", "--position", order.position),
        ("tension", "--force", order.force),
    ):
        least, most = found[name]
        if value is not None and not least <= value <= most:
            raise OrderError(
                f"{option} {value:g}: {found['kind']} {order.actuator} allows {least:g} to {most:g} "
                f"{found['units'][name]}"
            )
