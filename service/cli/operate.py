"""`tauten command`, `lock`, `unlock`, `metrics`, `contacts`, `record`, `alive`, `doctor`, `kernels`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer
from rich.console import Console
from rich.table import Table

from tauten.service.cli.terminal import Port, ServedName, ZenohConfig, writable

if TYPE_CHECKING:
    from tauten.service.link import LockOrder

Actuator = Annotated[str, typer.Argument(help="Name of the actuator.")]


def command(
    robot: ServedName,
    word: Annotated[
        Literal["enable", "hold", "stop", "reset", "let-go"],
        typer.Argument(help="The command."),
    ],
    port: Port = None,
    zenoh_config: ZenohConfig = None,
) -> None:
    """Command a robot's node to hold, to follow again, to release the cables, to reset then, or to let go."""
    from tauten.service.cli.emergency import Order, carry_out
    from tauten.service.link import Network, OperatorCommand

    order = Order(robot, OperatorCommand(word), Network(port, zenoh_config))
    typer.echo(carry_out(order))


def lock(
    robot: ServedName,
    actuator: Actuator,
    position: Annotated[
        float | None,
        typer.Option(
            help="Where it is locked, in its SI unit: a pull in m, a volume change in m³, ..."
        ),
    ] = None,
    force: Annotated[
        float | None,
        typer.Option(help="Effort at which it is locked: a tension in N, a pressure in Pa, ..."),
    ] = None,
    port: Port = None,
    zenoh_config: ZenohConfig = None,
) -> None:
    """Lock an actuator while the node runs; the others are decided. It gets there within its rate."""
    from tauten.service.link import LockOrder

    if (position is None) == (force is None):
        raise typer.BadParameter("give either --position or --force")
    _order(robot, LockOrder(actuator, position, force), port, zenoh_config)


def unlock(
    robot: ServedName, actuator: Actuator, port: Port = None, zenoh_config: ZenohConfig = None
) -> None:
    """Decide an actuator again that is locked."""
    from tauten.service.link import LockOrder

    _order(robot, LockOrder(actuator), port, zenoh_config)


def _order(robot: str, order: LockOrder, port: int | None, zenoh_config: Path | None) -> None:
    from tauten.service.link import Mode, Network, send_command

    tick = send_command(robot, Network(port, zenoh_config), order)
    waits = order.moves and tick.mode is not Mode.RUN
    typer.echo(
        f"{robot}: {order}, {tick.mode}{': it waits until the node follows' if waits else ''}"
    )


def metrics(
    robot: ServedName,
    http: Annotated[
        int | None,
        typer.Option(min=1, max=65535, help="Serve them on this loopback port for Prometheus."),
    ] = None,
    port: Port = None,
    zenoh_config: ZenohConfig = None,
) -> None:
    """Metrics of a robot's node as Prometheus text."""
    from tauten.service.link import Network, NetworkError, ask_metrics, node_of
    from tauten.service.operate import serve_metrics
    from tauten.service.process import stop_on_signals

    with node_of(robot, Network(port, zenoh_config)) as session:
        if http is not None:
            with stop_on_signals() as stop:
                serve_metrics(session, robot, http, stop)
            return
        text = ask_metrics(session, robot)
        if text is None:
            raise NetworkError(f"the node of {robot!r} does not answer")
        typer.echo(text.decode(), nl=False)


def contacts(
    robot: ServedName,
    open_ones: Annotated[
        bool,
        typer.Option("--open", help="The contacts in range that do not push, with their gaps."),
    ] = False,
    port: Port = None,
    zenoh_config: ZenohConfig = None,
) -> None:
    """What a robot touches now: points, forces, gaps and slip of the contacts that push."""
    from tauten.service.link import Network, node_of
    from tauten.service.operate import read_certificate, read_contacts

    with node_of(robot, Network(port, zenoh_config)) as session:
        found = read_contacts(session, robot, not open_ones)
        certificate = "" if open_ones else read_certificate(session, robot)
    if open_ones:
        table = Table("pair", "point [mm]", "gap [mm]", title=f"open contacts of {robot}")
    else:
        heads = ("pair", "point [mm]", "force [N]", "gap [mm]", "slips", "margin [N]")
        table = Table(*heads, title=f"contacts of {robot}")
    for i, row in enumerate(found.values):
        point, force = (
            " ".join(f"{one:.3g}" for one in part) for part in (1e3 * row[:3], row[3:6])
        )
        gap, slips, margin = (float(found.column(name)[i]) for name in ("gap", "sliding", "margin"))
        if open_ones:
            table.add_row(found.pair_of(i), point, f"{1e3 * gap:.3g}")
            continue
        said = "yes" if slips else "no"
        table.add_row(found.pair_of(i), point, force, f"{1e3 * gap:.3g}", said, f"{margin:.3g}")
    nothing = (
        f"{robot} is near nothing that it does not touch"
        if open_ones
        else f"{robot} touches nothing"
    )
    Console(markup=False).print(table if len(found.values) else nothing)
    if certificate:
        typer.echo(certificate)


def record(
    robot: ServedName,
    file: Annotated[
        Path, typer.Argument(callback=writable, dir_okay=False, help="MCAP file to make.")
    ],
    port: Port = None,
    zenoh_config: ZenohConfig = None,
) -> None:
    """Record all messages of a robot's processes until Ctrl-C; replay needs `serve --record` instead."""
    from tauten.service.link import Network, node_of
    from tauten.service.log import record_robot
    from tauten.service.process import stop_on_signals

    # until the node is alive, Ctrl-C interrupts the wait
    network = Network(port, zenoh_config)
    with node_of(robot, network, math.inf) as session, stop_on_signals() as stop:
        count = record_robot(session, robot, file, stop)
    typer.echo(f"{file}: {count} messages")


def alive(
    robot: ServedName,
    plant: Annotated[
        bool, typer.Option("--plant", help="Check the plant instead of the node.")
    ] = False,
    port: Port = None,
    zenoh_config: ZenohConfig = None,
) -> None:
    """Check whether a robot's node is alive: exit code 0 or 1, for health checks."""
    from tauten.service.link import Keys, Network, is_there

    keys = Keys(robot)
    found = is_there(robot, Network(port, zenoh_config), keys.plant_token if plant else keys.token)
    typer.echo(f"{robot}: {'alive' if found else 'not alive'}")
    raise typer.Exit(0 if found else 1)


def doctor(
    robot: Annotated[str, typer.Argument(help="A shipped robot's name, or a file.")] = "finger",
    seconds: Annotated[float, typer.Option(min=0.5, help="Duration of the loop.")] = 3.0,
) -> None:
    """Examine this machine: libraries, clock, network, and the rate at which a node can run."""
    from tauten.service.bench import examine
    from tauten.service.setup import load_setup

    table = Table("", "found", "advice", title="tauten doctor")
    for finding in examine(load_setup(robot), seconds):
        table.add_row(finding.what, finding.found, finding.advice)
    Console(markup=False).print(table)


def kernels() -> None:
    """Say how many kernels need not be compiled on this machine, and why not, where none."""
    from tauten.service.kernels import take_inventory

    found = take_inventory()
    table = Table("", "", title="tauten kernels", show_header=False)
    table.add_row("kernels of tauten", str(found.kernels))
    table.add_row("compiled for", found.machine)
    table.add_row("shipped and used here", f"{found.served}, with {found.entries} sets of types")
    table.add_row("changed since they were packed", str(found.changed))
    table.add_row("compiled here", f"{found.compiled}, {1e-6 * found.size:.0f} MB")
    console = Console(markup=False)
    console.print(table)
    console.print(f"compiled here: {found.folder}", soft_wrap=True)
    if found.not_kept:
        console.print(
            f"every start compiles the others again, they cannot be kept: {found.not_kept}; "
            "set NUMBA_CACHE_DIR to a folder that you alone can write",
            soft_wrap=True,
        )
    if found.why_not:
        console.print(f"none of the shipped kernels is used: {found.why_not}", soft_wrap=True)
