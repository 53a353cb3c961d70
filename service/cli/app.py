"""The `tauten` command.

Packages are imported inside the commands, so that `tauten --help` does not wait for them.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from tauten.service.cli.bench import bench
from tauten.service.cli.check import check, schema
from tauten.service.cli.compare import compare
from tauten.service.cli.drive import drive, plant
from tauten.service.cli.new import new
from tauten.service.cli.operate import (
    alive,
    command,
    contacts,
    doctor,
    kernels,
    lock,
    metrics,
    record,
    unlock,
)
from tauten.service.cli.reduction import inspect, reduce
from tauten.service.cli.runs import demo, replay, solve
from tauten.service.cli.terminal import (
    AcceptError,
    Basis,
    ClosedLoop,
    ExtraError,
    Model,
    Period,
    Port,
    Rate,
    RobotName,
    ZenohConfig,
    general_options,
    writable,
)
from tauten.service.cli.view import view

app = typer.Typer(
    help="Real-time inverse control of soft robots that touch themselves.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)


app.callback()(general_options)


def serve(
    robot: RobotName,
    rate: Rate = None,
    basis: Basis = None,
    model: Model = None,
    accept_error: AcceptError = False,
    record: Annotated[
        Path | None,
        typer.Option(callback=writable, dir_okay=False, help="MCAP file to record the run to."),
    ] = None,
    closed_loop: ClosedLoop = False,
    wait: Annotated[
        bool, typer.Option("--wait", help="Remain idle until an operator sends enable.")
    ] = False,
    event: Annotated[
        bool,
        typer.Option(
            "--event", help="Start a tick when its target arrives, at most half a period late."
        ),
    ] = False,
    interpolate: Annotated[
        float | None,
        typer.Option(
            metavar="SECONDS",
            help="Follow targets on straight lines between them, so much later; 0: follow the latest. "
            "Default: the robot file's.",
        ),
    ] = None,
    priority: Annotated[
        int | None, typer.Option(min=1, max=99, help="Priority of the loop under SCHED_FIFO.")
    ] = None,
    cpus: Annotated[
        list[int] | None, typer.Option(min=0, help="Processor of the loop; may be repeated.")
    ] = None,
    port: Port = None,
    zenoh_config: ZenohConfig = None,
) -> None:
    """Serve a robot: targets in, actuation out. Ctrl-C releases the cables in a ramp, twice: faster."""
    from tauten.service.link import Network
    from tauten.service.node import ServeSettings
    from tauten.service.node import serve as run
    from tauten.service.process import RealtimeSettings, stop_on_signals
    from tauten.service.setup import interpolated, load_setup

    settings = ServeSettings(
        record, closed_loop, wait, rate is not None,
        RealtimeSettings(priority, tuple(cpus or ())), event,
    )  # fmt: skip
    network = Network(port, zenoh_config)
    with stop_on_signals() as stop:
        with stop.interruptible():
            setup = load_setup(robot, rate, basis, model, accept_error)
            if interpolate is not None:
                setup = interpolated(setup, interpolate)
        if event and setup.service.interpolation_delay > 0.0:
            raise typer.BadParameter(
                "--event answers a target when it arrives, interpolation later: choose one"
            )
        run(setup, network, settings, stop)


def stream(
    path: Annotated[
        str,
        typer.Argument(
            help="circle, line, figure-eight, step, reach (where the cables can take the effector), "
            "or a CSV file with columns x, y, z in m and optionally t in s."
        ),
    ],
    robot: Annotated[
        str,
        typer.Option(
            help="The robot that is served: a shipped one, a file, or else the name a node serves it by."
        ),
    ] = "finger",
    effector: Annotated[str | None, typer.Option(help="Default: the first.")] = None,
    rate: Annotated[float, typer.Option(min=0.01, help="Targets a second.")] = 50.0,
    duration: Annotated[
        float | None, typer.Option(min=0.0, help="Duration in s; default: until Ctrl-C.")
    ] = None,
    size: Annotated[
        float | None, typer.Option(help="Size of a shape in m; default: a tenth of the robot.")
    ] = None,
    period: Period = None,
    plane: Annotated[Literal["xy", "xz", "yz"], typer.Option(help="Plane of a shape.")] = "xz",
    fraction: Annotated[
        float, typer.Option(min=0.0, max=1.0, help="Share of the largest pull, for reach.")
    ] = 0.8,
    repeat: Annotated[bool, typer.Option(help="Start a CSV again at its end.")] = False,
    await_plant: Annotated[bool, typer.Option(help="Wait also for a plant.")] = False,
    json: Annotated[bool, typer.Option(help="Send JSON rather than CDR.")] = False,
    port: Port = None,
    zenoh_config: ZenohConfig = None,
) -> None:
    """Stream targets to a robot's node, as soon as the node is alive."""
    from tauten.service.link import Network
    from tauten.service.plant import PathSettings, StreamSettings, find_receiver, receiver_path
    from tauten.service.plant import stream as run
    from tauten.service.process import stop_on_signals

    network = Network(port, zenoh_config)
    with stop_on_signals() as stop:
        with stop.interruptible():
            receiver = find_receiver(robot, network, stop)
            if receiver is None:
                return
            number = 0 if effector is None else receiver.number(effector)
            settings = PathSettings(number, rate, size, period, plane, fraction, repeat)
            targets = receiver_path(path, receiver, settings)
        sending = StreamSettings(rate, duration, json, number, await_plant)
        run(receiver.description, targets, sending, network, stop)


_COMMANDS = (
    *(serve, plant, drive, stream, demo, replay, solve, view),
    *(command, lock, unlock, record, metrics, contacts, alive, doctor),
    *(reduce, inspect, compare, check, new, schema, kernels),
)
for _command in _COMMANDS:
    app.command()(_command)
app.add_typer(bench, name="bench")


def setup_errors() -> tuple[type[Exception], ...]:
    """The errors of the set-up and of other packages, whose texts name what to change."""
    from tauten.model import ExtensionError, MeshError, RobotFileError
    from tauten.reduction import BasisError
    from tauten.reduction.campaign import ClusterError, DesignError, SnapshotError
    from tauten.reduction.contact import ChoiceError
    from tauten.reduction.state import StateBasisError
    from tauten.service.bench import CompareError
    from tauten.service.check import RateError
    from tauten.service.drive import DriverError
    from tauten.service.log import LogError
    from tauten.service.new import PartError
    from tauten.service.plant import DemoError, PathError
    from tauten.service.process import RealtimeError
    from tauten.service.tables import PageError

    robot_errors = (RobotFileError, MeshError, BasisError, StateBasisError, ExtensionError)
    reduction_errors = (ChoiceError, DesignError, ClusterError, SnapshotError)
    return (
        *robot_errors,
        *reduction_errors,
        CompareError,
        DemoError,
        DriverError,
        ExtraError,
        LogError,
        PageError,
        PartError,
        PathError,
        RateError,
        RealtimeError,
    )
