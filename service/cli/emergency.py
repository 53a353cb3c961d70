"""`tauten command` as it is typed in an emergency: no library for command lines is imported, and no model."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tauten.service.link import (
    HIGHEST_PORT,
    LOWEST_PORT,
    ZENOH_CONFIG_VARIABLE,
    Network,
    OperatorCommand,
    send_command,
    served_name,
)

_OPTIONS = ("--port", "--zenoh-config")


@dataclass(frozen=True, slots=True)
class Order:
    """A command to a robot's node.

    Attributes:
        robot: name.
        command: what the node is to do.
        network: of the robot.
    """

    robot: str
    command: OperatorCommand
    network: Network


def order_in(words: Sequence[str]) -> Order | None:
    """The order that a command line gives; None for what the whole program is to explain.

    Raises:
        NetworkError: as of `served_name`.
    """
    options: dict[str, str] = {}
    plain: list[str] = []
    rest = iter(words)
    for word in rest:
        name, sign, value = word.partition("=")
        if name in _OPTIONS:
            options[name] = value if sign else next(rest, "")
        elif word.startswith("-"):
            return None
        else:
            plain.append(word)
    port, config = (options.get(name) for name in _OPTIONS)
    if len(plain) != 2 or plain[1] not in [str(one) for one in OperatorCommand] or config == "":
        return None
    if port is not None and not (
        port.isascii() and port.isdecimal() and LOWEST_PORT <= int(port) <= HIGHEST_PORT
    ):
        return None
    config = config or os.environ.get(ZENOH_CONFIG_VARIABLE) or None
    if port is not None and config is not None:
        return None
    network = Network(None if port is None else int(port), None if config is None else Path(config))
    return Order(served_name(plain[0]), OperatorCommand(plain[1]), network)


def carry_out(order: Order) -> str:
    """Send an order, and what the node says to it.

    Raises:
        NetworkError: no node, or one that does not answer.
        OrderError: the node refuses it.
    """
    answer = send_command(order.robot, order.network, order.command)
    why = f" ({answer.cause})" if answer.cause else ""
    said = f"{order.robot}: {answer.mode}{why}"
    if order.command is OperatorCommand.LET_GO:
        said += f", let go: {answer.let_go or 'nothing was grasped'}"
    return said
