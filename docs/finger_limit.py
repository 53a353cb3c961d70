"""Writes the errors of the shipped finger's mesh against its limit, extrapolated in each direction.

    python docs/finger_limit.py [--results FILE] [--page FILE]

Refining the whole mesh twice is beyond a small computer: 150,000 nodes. The finger is a mapped grid, so the
cells of one direction at a time can be halved. With an error of order two in each of them, and small errors
that add up, the limit of a quantity is its value on the shipped mesh plus 4/3 of the sum of its changes. The
loads, elements and contact candidates are those of `tauten check finger`.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from tauten.model.load import build_robot, robot_path
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array
from tauten.model.robots.make_finger import FingerShape, make_finger
from tauten.model.schema import RobotConfig, model_tables, read_toml, validated
from tauten.service.check.mesh_variants import Load, LoadedState, equilibria, make_loads
from tauten.service.process import one_blas_thread
from tauten.service.tables import Numbers

DOCS = Path(__file__).resolve().parent
SHARES = (0.25, 0.5, 0.75, 1.0)
BEGIN, END = "<!-- finger limit -->", "<!-- end -->"


def halved(places: tuple[float, ...]) -> tuple[float, ...]:
    """With a place in the middle of each two."""
    between = [0.5 * (a + b) for a, b in pairwise(places)]
    return tuple(sorted([*places, *between]))


def meshes(shape: FingerShape) -> dict[str, FingerShape]:
    """The shipped finger, and with cells of half the size in one direction."""
    shoulder = shape.ligament + shape.bevel * shape.root
    return {
        "shipped": shape,
        "height of the hinges": replace(shape, below=halved(shape.below)),
        "length of the hinges": replace(shape, root_cells=2 * shape.root_cells),
        "height of the flanks": replace(shape, above=halved((shoulder, *shape.above))[1:]),
        "length of the inner blocks": replace(shape, along=halved(shape.along)),
        "length of the end blocks": replace(
            shape, first=halved(shape.first), last=halved(shape.last), end=2 * shape.end
        ),
        "width": replace(shape, across=2 * shape.across),
    }


def states(shape: FingerShape) -> tuple[int, tuple[Load, ...], list[LoadedState]]:
    """Nodes, loads and equilibria of the shipped robot file on another mesh."""
    path = robot_path("finger")
    config = validated(RobotConfig, model_tables(read_toml(path)), path)
    robot = build_robot(config, TetMesh(*make_finger(shape)), str(path))
    loads = make_loads(robot, SHARES)
    return len(robot.mesh.nodes), loads, list(equilibria(robot, loads, lambda: False))


def quantities(found: list[LoadedState]) -> Array:
    """Tension [N], contact force [N] and tip [m] of each state: (loads, 5)."""
    rows = [[state.tension[0], state.contact_force, *state.tip] for state in found]
    return np.array(
        [row if s.converged else [np.nan] * 5 for row, s in zip(rows, found, strict=True)]
    )


def table(
    loads: list[str], results: dict[str, list[LoadedState]], nodes: dict[str, int]
) -> Numbers:
    """Changes with each mesh and the errors of the shipped one."""
    values = {name: quantities(found) for name, found in results.items()}
    own = values["shipped"]
    changes = {name: value - own for name, value in values.items() if name != "shipped"}
    limit = own + 4.0 / 3.0 * np.sum(list(changes.values()), axis=0)

    def row(name: str, count: str, change: Array) -> tuple[str, ...]:
        cells = []
        for index in range(len(loads)):
            tension, force, *tip = change[index]
            touching = limit[index, 1] > 0.0
            cells += [
                f"{100.0 * tension / limit[index, 0]:+.2f} %",
                f"{100.0 * force / limit[index, 1]:+.2f} %" if touching else "-",
                f"{1e3 * np.linalg.norm(tip):.3f}",
            ]
        return (name, count, *cells)

    head = ["cells halved", "nodes"]
    head += [f"{load}: {what}" for load in loads for what in ("tension", "contact", "tip [mm]")]
    rows = [row(name, f"{nodes[name]:,}", change) for name, change in changes.items()]
    rows.append(row("**error of the shipped mesh**", f"{nodes['shipped']:,}", own - limit))
    return Numbers("", tuple(head), tuple(rows))


def main() -> None:
    """Settle the finger on each mesh, save the states, write the table into the page."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--results", type=Path, default=DOCS / "results" / "finger_limit.json")
    parser.add_argument("--page", type=Path, default=DOCS / "elements.md")
    options = parser.parse_args()
    results: dict[str, list[LoadedState]] = {}
    nodes: dict[str, int] = {}
    labels: list[str] = []
    with one_blas_thread():
        for name, shape in meshes(FingerShape()).items():
            nodes[name], loads, results[name] = states(shape)
            labels = [load.label for load in loads]
            print(name, nodes[name], quantities(results[name]).round(5).tolist(), flush=True)
    saved = {name: [asdict(state) for state in found] for name, found in results.items()}
    numbers = {"loads": labels, "nodes": nodes, "states": saved}
    options.results.write_text(json.dumps(numbers, indent=2) + "\n", encoding="utf-8")
    head, _, rest = options.page.read_text(encoding="utf-8").partition(BEGIN)
    _, _, tail = rest.partition(END)
    body = table(labels, results, nodes).markdown()
    options.page.write_text(f"{head}{BEGIN}\n{body}{END}{tail}", encoding="utf-8")


if __name__ == "__main__":
    main()
