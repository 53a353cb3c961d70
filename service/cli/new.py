"""`tauten new`: a robot file from a part of CAD."""

from __future__ import annotations

import sys
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Literal

import typer
from rich.console import Console

from tauten.service.cli.terminal import progress_bar, show_result, writable


def new(
    name: Annotated[str, typer.Argument(help="Name of the robot, its folder and its files.")],
    mesh: Annotated[
        Path,
        typer.Option(help="The part: STL, OBJ, PLY, STEP, BREP, or a file with tetrahedra."),
    ],
    unit: Annotated[
        Literal["m", "cm", "mm"], typer.Option(help="Unit of the part's coordinates.")
    ] = "mm",
    size: Annotated[
        float | None,
        typer.Option(
            min=1e-3,
            max=1e4,
            help="Size of the elements in mm; default: chosen by the error of the mesh.",
        ),
    ] = None,
    accuracy: Annotated[
        float,
        typer.Option(
            min=0.01, max=1.0, help="Difference of effort and tip to the finest mesh, relative."
        ),
    ] = 0.1,
    young: Annotated[
        float, typer.Option(min=1e2, max=1e9, help="Young's modulus of the material [Pa].")
    ] = 0.3e6,
    repair: Annotated[
        bool,
        typer.Option(
            "--repair",
            help="Close holes and crossings of the surface, or mesh what tetrahedra enclose anew (fTetWild).",
        ),
    ] = False,
    chambers: Annotated[
        bool,
        typer.Option(
            help="Make closed cavities chambers under pressure; without, a cable moves the part."
        ),
    ] = True,
    yes: Annotated[
        bool, typer.Option("--yes", help="Make large meshes without a question.")
    ] = False,
    folder: Annotated[
        Path | None,
        typer.Option(callback=writable, help="Folder to make; default: NAME in this folder."),
    ] = None,
) -> None:
    """Make a robot file from a part of CAD, to edit, and check it.

    The exit code is 1 where its first decisions cannot be used. Ctrl-C chooses among the meshes so far.
    """
    from tauten.model import one_blas_thread
    from tauten.service.new import LARGE, Made, NewRobot, make_new_robot, read_part
    from tauten.service.process import Interrupted, stop_on_signals
    from tauten.service.tables import new_page

    writable(folder or Path())  # before minutes of meshing
    made: Made | None = None
    with stop_on_signals() as stop, suppress(Interrupted):
        with stop.interruptible():
            with progress_bar("surface") as report:
                part = read_part(mesh, unit, repair, report)
            length = None if size is None else 1e-3 * size
            wanted = NewRobot(name, part, length, accuracy, young, chambers)
            if wanted.elements > LARGE and not yes:
                text = f"--size {size:g}: makes about {wanted.elements} tetrahedra"
                if not sys.stdin.isatty():
                    raise typer.BadParameter(f"{text}; choose a larger size, or add --yes")
                typer.confirm(f"{text}, go on?", abort=True, err=True)
        with progress_bar("mesh") as report, one_blas_thread():
            made = make_new_robot(wanted, folder or Path(name), stop, report)
    console = Console(stderr=True, markup=False)
    if made is None:
        console.print("stopped: nothing is written", highlight=False)
        raise typer.Exit(130)
    show_result({}, new_page(made), None)
    for note in made.notes:
        console.print(note, highlight=False)
    in_time = made.trials[made.chosen].in_time
    follow = f", then: tauten demo {made.file}" if in_time else " first"
    console.print(
        f"Written: {made.file}. Look at the lines with GUESS{follow}",
        highlight=False,
        soft_wrap=True,
    )
    if not made.usable:
        raise typer.Exit(1)
