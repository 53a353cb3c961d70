"""`tauten plant` and `tauten drive`: the simulated robot, and the driver of a real one."""

from __future__ import annotations

from typing import Annotated

import typer

from tauten.service.cli.terminal import (
    DriveOption,
    Model,
    Port,
    Rate,
    RobotName,
    ServedName,
    StepsOption,
    YoungScale,
    ZenohConfig,
)


def plant(
    robot: RobotName,
    rate: Rate = None,
    measure: Annotated[
        bool, typer.Option("--measure", help="Publish the effectors also as measurements.")
    ] = False,
    model: Model = None,
    young_scale: YoungScale = 1.0,
    drive: DriveOption = "pull",
    steps: StepsOption = "own",
    port: Port = None,
    zenoh_config: ZenohConfig = None,
) -> None:
    """Simulate a robot that follows the actuation, with pointwise contact.

    In full order where this computer keeps up with it, otherwise with the robot file's reduced model, or as
    --model says; one of another Young's modulus is always full.
    """
    from tauten.service.link import Network
    from tauten.service.plant import PlantSettings, plant_robot, simulate
    from tauten.service.process import stop_on_signals

    network = Network(port, zenoh_config)
    setup = plant_robot(robot, rate, model, young_scale)
    settings = PlantSettings(measure, drive, steps)
    with stop_on_signals() as stop:
        simulate(setup, network, settings, stop, model)


def drive(
    robot: ServedName,
    driver: Annotated[str, typer.Option(help="Its name, as an installed package has it.")],
    option: Annotated[
        list[str] | None,
        typer.Option(help="Of the driver, NAME=VALUE; may be repeated."),
    ] = None,
    port: Port = None,
    zenoh_config: ZenohConfig = None,
) -> None:
    """Run the driver of a robot's hardware beside its node: actuation to it, measurements from it."""
    from tauten.service.drive import drive as run
    from tauten.service.drive import make_driver
    from tauten.service.link import Network
    from tauten.service.process import stop_on_signals

    options = {}
    for text in option or ():
        name, found, value = text.partition("=")
        if not found:
            raise typer.BadParameter(f"--option {text}: expected NAME=VALUE")
        options[name] = value
    with stop_on_signals() as stop:
        run(robot, make_driver(driver), options, Network(port, zenoh_config), stop)
