"""`tauten bench elements`: times and errors of elements and materials."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress

from tauten.service.cli.bench import Json
from tauten.service.process import write_text


def elements(
    json_file: Json = None,
    markdown: Annotated[Path | None, typer.Option(help="Page to put the tables into.")] = None,
    robot: Annotated[str, typer.Option(help="A shipped robot's name, or a robot file.")] = "finger",
    law: Annotated[list[str] | None, typer.Option(help="Law of the material, or several.")] = None,
    pull: Annotated[
        list[float] | None,
        typer.Option(min=0.0, max=1.0, help="Share of the largest pull, or several in order."),
    ] = None,
    refinements: Annotated[
        int, typer.Option(min=0, max=2, help="Refinements of the linear mesh to compare.")
    ] = 1,
    reference: Annotated[
        int, typer.Option(min=0, max=2, help="Refinements of the quadratic mesh compared with.")
    ] = 1,
    contact: Annotated[bool, typer.Option(help="Let surfaces touch.")] = False,
) -> None:
    """Tension, tip and contact force of linear, smoothed and quadratic elements against a fine mesh.

    The default compares the finger at 15 mm of pull.
    """
    from tauten.service.bench.elements import ElementBenchSettings, bench_elements, parse_law
    from tauten.service.tables import element_tables, write_element_tables

    try:
        laws = tuple(parse_law(name) for name in law or ("corotational",))
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    settings = ElementBenchSettings(
        robot=robot,
        laws=laws,
        pulls=tuple(pull or (0.375,)),
        refinements=refinements,
        reference=reference,
        contact=contact,
    )
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("elements", total=1.0)
        result = bench_elements(
            settings, lambda share, what: bar.update(task, advance=share, description=what)
        )
    for table in element_tables(result):
        Console(width=160).print(table.rich())
    if json_file is not None:
        write_text(json_file, json.dumps(asdict(result), indent=2) + "\n")
    if markdown is not None:
        write_element_tables(result, markdown)
