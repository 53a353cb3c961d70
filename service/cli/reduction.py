"""`tauten reduce` and `tauten inspect`: compute a contact basis, and show one."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer
from rich.console import Console

from tauten.service.cli.campaigns import Campaigns, Workers
from tauten.service.cli.states import (
    KeepInaccurate,
    Responses,
    SampleResidual,
    StateModes,
    States,
    Touched,
    TouchedPoints,
    number_or_auto,
    save_states,
    show_states,
    state_settings,
)
from tauten.service.cli.terminal import RobotName, drawable, progress_bar, writable

if TYPE_CHECKING:
    from tauten.reduction.contact import BasisMethod, Reduction, Weighting


def reduce(
    robot: RobotName,
    out: Annotated[
        Path | None,
        typer.Option(
            callback=writable,
            dir_okay=False,
            help="Default: ROBOT.basis beside the robot file, where that is a link, beside what it leads to; "
            "of a shipped robot here.",
        ),
    ] = None,
    design: Annotated[
        str,
        typer.Option(
            help="exploring (what the robot's actuators need, under its own weight, tilted, and with "
            "payload), ramp, plackett-burman, latin-hypercube, or a CSV of loads."
        ),
    ] = "exploring",
    step: Annotated[float, typer.Option(help="Step of the ramp in m, rad or m³.")] = 5e-5,
    steps: Annotated[int, typer.Option(min=1, help="Steps of a run, in the other designs.")] = 100,
    runs: Annotated[int, typer.Option(help="Runs of the Latin hypercube.")] = 20,
    pull: Annotated[
        tuple[float, float],
        typer.Option(
            help="Least and largest final pull of a run, as a share of a cable's largest."
        ),
    ] = (0.5, 1.0),
    tension: Annotated[
        tuple[float, float] | None,
        typer.Option(
            help="Hold tensions instead: least and largest final one, as a share of a cable's largest."
        ),
    ] = None,
    tilt: Annotated[
        float, typer.Option(help="Largest tilt of gravity in the designs in degrees.")
    ] = 0.0,
    force: Annotated[
        float, typer.Option(help="Largest component of forces on the effectors [N].")
    ] = 0.0,
    k: Annotated[str, typer.Option(help='Number of modes, or "auto".')] = "auto",
    tolerance: Annotated[
        float | None,
        typer.Option(
            help='Effector error that "auto" accepts in m; default: 1/1000 of the robot, or the least.'
        ),
    ] = None,
    method: Annotated[str, typer.Option(help="energy, hals, hals-nndsvd, als, greedy.")] = "energy",
    weighting: Annotated[str, typer.Option(help="Weights of snapshots: equal or force.")] = "equal",
    seed: Annotated[int, typer.Option(help="Seed of random numbers.")] = 0,
    curve: Annotated[
        Path | None,
        typer.Option(callback=drawable, help="Draw the error against k into this picture."),
    ] = None,
    snapshots: Annotated[
        Path | None,
        typer.Option(callback=writable, help="Folder of the campaign; default: ROBOT-snapshots."),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(min=1, help="Number of processes; default: one for each processor."),
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option(help="Dask scheduler, tcp://host:port, instead of processes.")
    ] = None,
    states: States = False,
    state_modes: StateModes = "auto",
    responses: Responses = None,
    sample: SampleResidual = 1e-2,
    touched: Touched = None,
    touched_points: TouchedPoints = None,
    accept_error: KeepInaccurate = False,
    write: Annotated[
        bool,
        typer.Option(
            "--write",
            help="Write the lines that use the bases into the robot file; comments remain.",
        ),
    ] = False,
) -> None:
    """Apply loads to a robot and compute a contact basis from the contact forces.

    With --states also a state basis from the configurations, and a sample of elements. A robot without
    contacts, or with friction in all of them, which no contact basis has, gets a state basis only.

    Finished parts are kept in the folder of snapshots: the same command continues after Ctrl-C.
    """
    from tauten.controller import load_model_settings
    from tauten.model import EmptySpace, load_robot
    from tauten.model.load import robot_path
    from tauten.reduction.campaign import PLACES, DesignError, Ranges, touched_robot
    from tauten.reduction.contact import (
        ChoiceError,
        ContactBasis,
        ReduceSettings,
        reduce_snapshots,
    )
    from tauten.reduction.state import reducible
    from tauten.service.plots import draw_curve

    settings = ReduceSettings(
        k=number_or_auto("k is", k, ChoiceError),
        method=cast("BasisMethod", method),  # ReduceSettings checks it
        weighting=cast("Weighting", weighting),
        tolerance=tolerance,
        seed=seed,
        curve=curve is not None,
    )
    if (touched or touched_points) and not (states and design == "exploring"):
        raise DesignError("--touched and --touched-points need --states and the design exploring")
    spheres = None
    if states and design == "exploring":
        spheres = touched_robot(robot_path(robot), touched, touched_points or PLACES)
    if touched_points and spheres is None:
        raise DesignError(
            "--touched-points: nothing touches the robot, name a surface with --touched"
        )
    loaded = load_robot(robot) if spheres is None else spheres.plain
    moved = loaded if spheres is None else spheres.robot
    based = bool(loaded.contacts.without_friction.any())
    if states or not based:
        reducible(loaded)  # before hours of a campaign
    places = len(spheres.places) if touched_points and spheres is not None else 0
    chosen = state_settings(loaded, state_modes, responses, places, sample, seed)
    allowed = None if accept_error else load_model_settings(robot).max_tip_error
    beside = _folder_of(robot) if robot.endswith(".toml") else Path()
    if write and not robot.endswith(".toml"):
        raise typer.BadParameter(
            "--write: a shipped robot's file is not changed; give a robot file"
        )
    target = ContactBasis.new_file(out or beside / f"{loaded.name}.basis")
    ranges = Ranges(position=pull, tilt=math.radians(tilt), force=force, effort=tension)
    folder = snapshots or Path(f"{loaded.name}-snapshots")
    campaigns = Campaigns(
        loaded, spheres, design, step, ranges, runs, steps, seed, folder, Workers(scheduler, workers)
    )  # fmt: skip
    for written in (target, folder):
        writable(written)
    with _resumable(folder):
        found = campaigns.whole()
        good = found.select(found.converged)
        if not based:
            path, nothing = target.with_suffix(".states"), EmptySpace(moved.n_c)
            save_states(moved, good, nothing, chosen, path, allowed, campaigns.narrower(found))
            _use(robot, None, path, write)
            return
        with progress_bar("contact modes") as report:
            made = reduce_snapshots(loaded, found, folder, settings, spheres, report)
    saved = made.basis.save(target)
    if curve is not None and made.curve is not None:
        draw_curve(made.curve, curve, made.basis.k)
    typer.echo(f"{saved}: {_summary(made)}")
    path = saved.with_suffix(".states")
    if states:
        with _resumable(folder):
            space, narrower = made.basis.fitted(moved), campaigns.narrower(found)
            save_states(moved, good, space, chosen, path, allowed, narrower)
    _use(robot, saved, path if states else None, write)


def _folder_of(robot: str) -> Path:
    """The folder beside whose files the bases of a robot file stand; of a link, that of what it leads to."""
    file = Path(robot)
    return (Path(os.path.realpath(file)) if file.is_symlink() else file).parent


def _summary(made: Reduction) -> str:
    """Number of modes and their errors; where k was chosen, also those on equilibria that were held out."""
    origin, parts = made.basis.provenance, list[str]()
    parts.append(f"{origin.k} modes of {origin.snapshots} snapshots by {origin.method}, ")
    parts.append(f"effector error to first order {1e3 * origin.tip_error:.3g} mm at most")
    if made.curve is not None and origin.k in made.curve.k:
        unseen = float(made.curve.tip[made.curve.k == origin.k][0])
        parts.append(f", {1e3 * unseen:.3g} mm on those that were held out")
    if (held := origin.tip_error_as_held) is not None:
        parts.append(f", {1e3 * held:.3g} mm at equal efforts where efforts are held")
    if made.skipped:
        parts.append(f"; {made.skipped} equilibria did not converge")
    return "".join(parts)


def _use(robot: str, basis: Path | None, states: Path | None, write: bool) -> None:
    """Write the lines that use the bases into the robot file, or show them."""
    if not robot.endswith(".toml"):
        return
    from tauten.service.new import fields_text, set_fields

    folder, fields = _folder_of(robot), dict[str, dict[str, str]]()
    if basis is not None:
        fields["controller"] = {"basis": Path(os.path.relpath(basis, folder)).as_posix()}
    if states is not None:
        relative = Path(os.path.relpath(states, folder)).as_posix()
        fields["model"] = {"order": "reduced", "states": relative}
    if write:
        set_fields(Path(robot), fields)
        typer.echo(f"{robot} uses them.")
    else:
        typer.echo(f"To use them, --write writes into {robot}:\n{fields_text(fields)}")


def inspect(
    basis: Annotated[
        str, typer.Argument(help="A .basis or .states file, or a shipped robot's name.")
    ],
    robot: Annotated[
        str | None,
        typer.Option(
            help="Robot name or file; default: the one it was made for, beside it or shipped."
        ),
    ] = None,
    figure: Annotated[
        Path | None,
        typer.Option(callback=drawable, help="Draw the modes on the robot into this picture."),
    ] = None,
    modes: Annotated[int, typer.Option(min=1, help="Modes to draw, at most.")] = 20,
    curve: Annotated[
        Path | None,
        typer.Option(callback=drawable, help="Draw the error against k into this picture."),
    ] = None,
) -> None:
    """Show the provenance of a contact basis and the candidates that it does not cover.

    Of a .states file: provenance and errors of the state basis.
    """
    if basis.endswith(".states"):
        show_states(basis)
        return
    from tauten.reduction import ContactBasis
    from tauten.service.plots import draw_curve, draw_modes
    from tauten.service.tables import basis_tables, found_robot, kept_curve

    found = ContactBasis.load(basis)
    errors = kept_curve(found, basis) if curve is not None else None
    loaded = found_robot(found, basis, robot, needed=robot is not None or figure is not None)
    if errors is not None and curve is not None:
        draw_curve(errors, curve, found.k)
    if figure is not None and loaded is not None:
        draw_modes(loaded, found, figure, modes)
    for table in basis_tables(found, basis, loaded):
        Console(markup=False).print(table)


@contextmanager
def _resumable(folder: Path) -> Iterator[None]:
    """After Ctrl-C a message names the folder, and the exit code is that of a shell."""
    try:
        yield
    except KeyboardInterrupt:
        kept = f"{folder} keeps the finished part, the same command continues from there"
        typer.echo(f"stopped: {kept if folder.exists() else 'nothing is finished yet'}", err=True)
        raise typer.Exit(130) from None
