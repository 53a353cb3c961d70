"""`tauten solve`: a decision's problem from a file, solved again."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console


def solve(
    file: Annotated[Path, typer.Argument(help="A problem, written by `write_qpcc`.")],
    solver: Annotated[str, typer.Option(help="QP library.")] = "daqp",
    max_pivots: Annotated[int, typer.Option(min=0, help="QPs at most.")] = 300,
    cold: Annotated[bool, typer.Option("--cold", help="Leave out the start in the file.")] = False,
) -> None:
    """Solve a QPCC from a file; print solution, certificate and status. Exit code 1: no usable point."""
    from tauten.controller.qpcc import QpccSettings, read_qpcc, solve_qpcc

    try:
        problem, start = read_qpcc(file)
        settings = QpccSettings(solver, max_pivots)
        solution = solve_qpcc(problem, None if cold else start, settings)
    except (OSError, ValueError) as error:
        raise typer.BadParameter(str(error)) from error
    found, console = solution.certificate, Console(highlight=False, soft_wrap=True, markup=False)
    console.print(f"status           {solution.status.name}: {solution.status.value}")
    if solution.conflict:
        console.print(f"conflict         {', '.join(solution.conflict)}")
    console.print(f"objective        {solution.objective:.12g}")
    console.print(f"primal           {found.primal:.1e}")
    console.print(f"complementarity  {found.complementarity:.1e}")
    console.print(f"stationarity     {found.stationarity:.1e}")
    console.print(f"QPs              {solution.pivots}")
    for name, values in (("lam_a", solution.lam_a), ("beta", solution.beta)):
        console.print(f"{name:16} {' '.join(f'{value:.6g}' for value in values)}")
    if not solution.status.usable:
        raise typer.Exit(1)
