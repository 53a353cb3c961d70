"""`tauten reduce` and `tauten inspect`: contact bases made and looked at."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer
from rich.console import Console
from rich.table import Table

if TYPE_CHECKING:
    from tauten.model import Robot
    from tauten.reduction.designs import Design


def reduce(
    robot: Annotated[str, typer.Argument(help="A shipped robot's name, or a robot file.")],
    out: Annotated[Path | None, typer.Option(help="Default: ROBOT.basis here.")] = None,
    design: Annotated[
        str,
        typer.Option(help="ramp, plackett-burman, latin-hypercube, or a CSV of loads."),
    ] = "ramp",
    step: Annotated[float, typer.Option(min=0.0, help="Of the ramp [m].")] = 5e-5,
    runs: Annotated[int, typer.Option(min=1, help="Of the Latin hypercube.")] = 20,
    tilt: Annotated[float, typer.Option(min=0.0, help="Of gravity, in the designs [rad].")] = 0.0,
    force: Annotated[float, typer.Option(min=0.0, help="On the effectors [N].")] = 0.0,
    k: Annotated[str, typer.Option(help='Number of modes, or "auto".')] = "5",
    method: Annotated[str, typer.Option(help="Of factorisation.")] = "hals",
    seed: Annotated[int, typer.Option(help="Of what is random.")] = 0,
    snapshots: Annotated[
        Path | None, typer.Option(help="Folder that keeps the campaign; default: ROBOT-snapshots.")
    ] = None,
    workers: Annotated[int, typer.Option(min=1, help="Processes.")] = 1,
    cluster: Annotated[str | None, typer.Option(help="Dask scheduler, tcp://host:port.")] = None,
) -> None:
    """Show a robot its loads and make a contact basis of the contact forces."""
    from tauten.model import load_robot
    from tauten.reduction.choose import ChoiceError
    from tauten.reduction.executors import dask_cluster, processes
    from tauten.reduction.positive_basis import METHODS
    from tauten.reduction.reduce import reduce_robot

    if method not in METHODS:
        raise typer.BadParameter(f"found {method}, allowed are {', '.join(METHODS)}")
    if k != "auto" and not k.isdecimal():
        raise typer.BadParameter(f"k is {k}, allowed are numbers and auto")
    loaded = load_robot(robot)
    folder = snapshots or Path(f"{loaded.name}-snapshots")
    plan = _design(design, loaded, step, runs, tilt, force, seed)
    modes: int | Literal["auto"] = "auto" if k == "auto" else int(k)
    with dask_cluster(cluster) if cluster else processes(workers) as executor:
        try:
            made = reduce_robot(loaded, plan, folder, modes, method, seed, executor=executor)
        except ValueError as error:
            raise ChoiceError(f"{loaded.name}: {error}") from error
    saved = made.basis.save(out or Path(f"{loaded.name}.basis"))
    off = made.basis.provenance.error
    typer.echo(f"{saved}: {made.basis.k} modes, relative force error {off:.3g}")


def _design(
    name: str, robot: Robot, step: float, runs: int, tilt: float, force: float, seed: int
) -> Design:
    from tauten.reduction import designs
    from tauten.reduction.design_csv import from_csv

    ranges = designs.Ranges(tilt=tilt, force=force)
    if name == "ramp":
        return designs.ramp(robot, step)
    if name == "plackett-burman":
        return designs.plackett_burman(robot, ranges)
    if name == "latin-hypercube":
        return designs.latin_hypercube(robot, ranges, runs, seed)
    return from_csv(robot, name)


def inspect(
    basis: Annotated[str, typer.Argument(help="A .basis file, or a shipped robot's name.")],
) -> None:
    """Say what a contact basis is and where it comes from."""
    from tauten.reduction import ContactBasis

    found = ContactBasis.load(basis)
    table = Table("", str(basis), title="contact basis")
    for name, value in basis_rows(found.provenance.to_dict()):
        table.add_row(name, value)
    table.add_row("candidates", str(found.n_c))
    table.add_row("candidates no mode touches", str(len(found.untouched())))
    Console().print(table)


def basis_rows(provenance: dict[str, object]) -> list[tuple[str, str]]:
    """A provenance as lines of a table."""
    rows = []
    for name, value in provenance.items():
        if isinstance(value, list | tuple):
            value = ", ".join(f"{first} {second}" for first, second in value)
        rows.append((name.replace("_", " "), str(value)))
    return rows
