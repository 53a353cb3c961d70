"""`tauten command`, with what it needs and nothing else: a stop does not wait for a model to be imported."""

from __future__ import annotations

from typing import Annotated, Literal

import typer

from tauten.service.cli.terminal import Port, ZenohConfig, log_options
from tauten.service.link import Network, OperatorCommand, send_command

ServedName = Annotated[str, typer.Argument(help="Name of the robot that is served.")]

emergency = typer.Typer(pretty_exceptions_enable=False)  # parses as the whole of `tauten` does


emergency.callback()(log_options)


@emergency.command()
def command(
    robot: ServedName,
    word: Annotated[
        Literal["enable", "hold", "stop", "reset"], typer.Argument(help="The command.")
    ],
    port: Port = None,
    zenoh_config: ZenohConfig = None,
) -> None:
    """Command a robot's node to hold, to follow again, to release the cables, or to reset after that."""
    answer = send_command(robot, Network(port, zenoh_config), OperatorCommand(word))
    why = f" ({answer.cause})" if answer.cause else ""
    typer.echo(f"{robot}: {answer.mode}{why}")
