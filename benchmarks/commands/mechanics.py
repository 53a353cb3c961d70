"""`python -m benchmarks elements`, `energy` and `equilibria`: the mechanics of robots."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tauten.service.cli.terminal import Json, Markdown, Robots, progress_bar, show_result

if TYPE_CHECKING:
    from benchmarks.physics import EnergyBench


def elements(
    json_file: Json = None,
    markdown: Markdown = None,
    robot: Annotated[str, typer.Option(help="A shipped robot's name, or a robot file.")] = "finger",
    figure: Annotated[
        Path | None,
        typer.Option(help="Figure of the errors over nodes and over the time of a step."),
    ] = None,
    material: Annotated[
        list[str] | None,
        typer.Option(help="Law of the material, or name of a silicone; may be repeated."),
    ] = None,
    pull: Annotated[
        list[float] | None,
        typer.Option(min=0.0, max=1.0, help="Share of the largest pull, or several in order."),
    ] = None,
    refinements: Annotated[
        int, typer.Option(min=0, max=2, help="Refinements of the linear mesh to compare.")
    ] = 0,
    reference: Annotated[
        int, typer.Option(min=0, max=2, help="Refinements of the quadratic mesh compared with.")
    ] = 0,
    contact: Annotated[bool, typer.Option(help="Let surfaces touch.")] = False,
) -> None:
    """Tension, tip and contact force of linear, smoothed and quadratic elements against a fine mesh.

    The default compares the finger at 15 mm of pull. Its mesh is fine: refined once it has 20,000 nodes, and
    its quadratic mesh 150,000.
    """
    from benchmarks.elements import ElementBenchSettings, bench_elements, parse_material
    from benchmarks.plots import draw_elements
    from benchmarks.tables import element_page

    try:
        materials = tuple(parse_material(name) for name in material or ("corotational",))
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    settings = ElementBenchSettings(
        robot=robot,
        materials=materials,
        positions=tuple(pull or (0.6,)),
        refinements=refinements,
        reference=reference,
        contact=contact,
    )
    with progress_bar("elements") as report:
        result = bench_elements(settings, report)
    show_result(result, element_page(result), json_file, markdown)
    if figure is not None:
        draw_elements(result, figure)


def energy(
    json_file: Json = None,
    markdown: Markdown = None,
    figure: Annotated[Path | None, typer.Option(help="Figure of the energies.")] = None,
    distance_figure: Annotated[
        Path | None, typer.Option(help="Figure of the first robot's distance of model and plant.")
    ] = None,
    robot: Robots = None,
    seconds: Annotated[float, typer.Option(min=0.1, help="Duration of each motion.")] = 10.0,
    path_seconds: Annotated[
        float, typer.Option(min=0.0, help="Duration of the demo's path; 0 leaves it out.")
    ] = 10.0,
) -> None:
    """Energy of a free swing and of a held robot, times of steps, distance of model and plant.

    Each with one linearisation a step and with steps iterated to convergence.
    """
    from benchmarks.physics import EnergySettings, bench_energy
    from benchmarks.plots import draw_energy
    from benchmarks.tables import energy_page
    from tauten.service.plots import draw_distances

    chosen = EnergySettings(tuple(robot or EnergySettings().robots), seconds, path_seconds)
    with progress_bar("energy") as report:
        result = bench_energy(chosen, report)
    show_result(_energy_numbers(result), energy_page(result), json_file, markdown)
    if figure is not None:
        draw_energy(result, figure)
    if distance_figure is not None and result.paths:
        draw_distances(result.paths[0].distances, distance_figure)


def _energy_numbers(result: EnergyBench) -> dict[str, Any]:
    """The numbers, without the courses of distances."""
    return {
        "machine": asdict(result.machine),
        "courses": [asdict(course) for course in result.courses],
        "costs": [asdict(cost) for cost in result.costs],
        "paths": {
            item.distances.robot: {
                name: asdict(share) for name, share in item.distances.shares().items()
            }
            for item in result.paths
        },
        "step_lengths": {
            item.distances.robot: [asdict(one) for one in item.step_lengths]
            for item in result.paths
        },
    }


def equilibria(
    json_file: Json = None,
    markdown: Markdown = None,
    robot: Robots = None,
    starts: Annotated[int, typer.Option(min=1, help="Random starts of each robot.")] = 200,
    data: Annotated[
        Path | None,
        typer.Option(
            envvar="TAUTEN_REFERENCE_DATA",
            help="Folder of the reference data, for trunk and diamond; without it they are left out.",
        ),
    ] = None,
    contact: Annotated[
        bool, typer.Option("--contact", help="Let robots from random starts touch themselves.")
    ] = False,
) -> None:
    """How many factorisations robots need to settle, from random starts and to large loads."""
    from benchmarks.physics import EquilibriaSettings, bench_equilibria
    from benchmarks.tables import equilibria_page

    models = None if data is None else data / "sofa_robots"
    if models is not None and not models.is_dir():
        raise typer.BadParameter(f"{data} has no folder sofa_robots")
    chosen = EquilibriaSettings(
        tuple(robot or EquilibriaSettings().robots), starts, models, contact=contact
    )
    with progress_bar("equilibria") as report:
        result = bench_equilibria(chosen, report)
    show_result(result, equilibria_page(result), json_file, markdown)
