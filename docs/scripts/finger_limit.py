"""Writes the errors of the shipped finger's mesh against its limit, extrapolated in each direction.

    python -m docs.scripts.finger_limit [--results FILE] [--page FILE] [--save]

Refining the whole mesh twice is beyond a small computer: 150,000 nodes. The finger is a mapped grid, so the
cells of one direction at a time can be halved. With an error of order two in each of them, and small errors
that add up, the limit of a quantity is its value on the shipped mesh plus 4/3 of the sum of its changes. The
loads, elements and contact candidates are those of `tauten check finger`.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path

import numpy as np

from benchmarks.robots.make_finger import FingerShape, make_finger
from tauten.model import load_robot, one_blas_thread
from tauten.model.load import build_robot, robot_path
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array
from tauten.model.schema import RobotConfig, model_tables, read_toml, validated
from tauten.service.check import Load, LoadedState, MeshCertificate, equilibria, make_loads
from tauten.service.tables import Numbers, Page

DOCS = Path(__file__).resolve().parents[1]
SHARES = (0.4, 0.6, 0.8, 0.85, 0.9, 1.0)


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
    loads = make_loads(robot, SHARES, antagonists=False)
    return robot.n_nodes, loads, list(equilibria(robot, loads, antagonists=False))


def quantities(found: list[LoadedState]) -> Array:
    """Tension [N], contact force [N] and tip [m] of each state: (loads, 5)."""
    rows = [[state.effort[0], state.contact_force, *state.tip] for state in found]
    return np.array(
        [row if s.converged else [np.nan] * 5 for row, s in zip(rows, found, strict=True)]
    )


def limit_and_error(values: dict[str, Array]) -> tuple[Array, Array]:
    """The extrapolated quantities (loads, 5), and those of the shipped mesh less them."""
    own = values["shipped"]
    changes = [value - own for name, value in values.items() if name != "shipped"]
    error: Array = -4.0 / 3.0 * np.sum(changes, axis=0)
    return own - error, error


def relative(change: Array, limit: Array, column: int) -> Array:
    """Change of a force relative to its limit, or to a quarter of its largest: (loads,)."""
    scale = np.maximum(limit[:, column], 0.25 * np.nanmax(limit[:, column]))
    shares: Array = change[:, column] / scale
    return shares


def tables(
    loads: list[str], values: dict[str, Array], nodes: dict[str, int]
) -> tuple[Numbers, ...]:
    """Changes with each mesh and the errors of the shipped one: of tension, contact force and tip.

    Args:
        loads: their labels.
        values: quantities (loads, 5) of each mesh.
        nodes: of each mesh.
    """
    limit, error = limit_and_error(values)
    changes = {n: value - values["shipped"] for n, value in values.items() if n != "shipped"}
    rows = [(name, f"{nodes[name]:,}", change) for name, change in changes.items()]
    rows.append(("**error of the shipped mesh**", f"{nodes['shipped']:,}", error))
    head = ("cells halved", "nodes", *loads)
    cells: dict[str, Callable[[Array], list[str]]] = {
        "tension": lambda change: percent(relative(change, limit, 0)),
        "contact force": lambda change: percent(relative(change, limit, 1), limit[:, 1]),
        "tip [mm]": lambda change: millimetres(change[:, 2:]),
    }
    return tuple(
        Numbers(title, head, tuple((name, count, *of(change)) for name, count, change in rows))
        for title, of in cells.items()
    )


def percent(shares: Array, forces: Array | None = None) -> list[str]:
    """Relative changes (loads,) as text; a dash where no equilibrium was found, or no force acts (loads,)."""
    known = np.isfinite(shares) & (True if forces is None else forces > 0.0)
    return [f"{100.0 * x:+.2f} %" if good else "-" for x, good in zip(shares, known, strict=True)]


def millimetres(change: Array) -> list[str]:
    """Lengths of displacements (loads, 3) [m] as text; a dash where no equilibrium was found."""
    lengths = 1e3 * np.linalg.norm(change, axis=1)
    return [f"{length:.3f}" if np.isfinite(length) else "-" for length in lengths]


def certificate(digest: str, values: dict[str, Array]) -> MeshCertificate:
    """The largest errors, for reports of runs."""
    limit, error = limit_and_error(values)
    known = ~np.isnan(error).any(axis=1)
    effort, force = (relative(error, limit, column)[known] for column in (0, 1))
    return MeshCertificate(
        digest,
        datetime.now(UTC).isoformat(timespec="seconds"),
        float(effort[np.abs(effort).argmax()]),
        float(np.linalg.norm(error[known, 2:], axis=1).max()),
        float(force[np.abs(force).argmax()]),
        "smoothed meshes extrapolated in each direction",
        float(np.array(SHARES)[known].max()),
    )


def settled(file: Path) -> tuple[list[str], dict[str, int], dict[str, Array]]:
    """Loads, nodes and quantities of each mesh; those that the file of this robot lacks are added to it."""
    digest = load_robot("finger").digest
    found = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
    if found.get("digest") != digest:
        found = {"digest": digest, "loads": [], "nodes": {}, "quantities": {}}
    for name, shape in meshes(FingerShape()).items():
        if name in found["quantities"]:
            continue
        count, loads, equilibria_found = states(shape)
        found["loads"] = [load.label for load in loads]
        found["nodes"][name] = count
        rows = quantities(equilibria_found).tolist()
        found["quantities"][name] = [[x if np.isfinite(x) else None for x in row] for row in rows]
        text = json.dumps(found, indent=2, allow_nan=False)
        file.write_text(text + "\n", encoding="utf-8")
        print(name, count, found["quantities"][name], flush=True)
    values = {name: np.array(rows, dtype=float) for name, rows in found["quantities"].items()}
    return found["loads"], found["nodes"], values


def main() -> None:
    """Settle the finger on each mesh, save the results, write table and certificate."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--results", type=Path, default=DOCS / "results" / "finger_limit.json")
    parser.add_argument("--page", type=Path, default=DOCS / "elements.md")
    parser.add_argument("--save", action="store_true", help="save the errors beside the robot file")
    options = parser.parse_args()
    with one_blas_thread():
        loads, nodes, values = settled(options.results)
    if options.save:
        certificate(load_robot("finger").digest, values).save(robot_path("finger"))
    Page("finger limit", "", tables(loads, values, nodes)).put_into(options.page)


if __name__ == "__main__":
    main()
