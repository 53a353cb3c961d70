"""Boxes and spheres, some with cavities, and robots made of them, for tests that need a body of their own."""

from __future__ import annotations

import numpy as np

from benchmarks.robots.make_finger import split_cells
from tauten.controller import Controller, Status
from tauten.model import Robot
from tauten.model.load import build_robot
from tauten.model.mesh import TetMesh, oriented
from tauten.model.numerics import Array, Ints
from tauten.model.schema import RobotConfig
from tauten.model.tetra import NodalBody

PRESSED = (0.1, 0.01, 0.01)  # m, of a finger that presses on a table
HOLLOW_SIZE = (0.1, 0.02, 0.02)
HOLLOW_CELLS = (10, 4, 4)
CHAMBER: dict[str, object] = {
    "name": "bellows",
    "inside": [0.05, 0.01, 0.0125],
    "min_pressure": -5e3,
    "max_pressure": 4e4,
    "max_volume_change": 8e-6,
    "max_rate": 2e-5,
}
CABLE: dict[str, object] = {
    "name": "tendon",
    "points": [[0.01, 0.01, 0.002], [0.1, 0.01, 0.002]],
    "max_tension": 20.0,
    "max_pull": 0.02,
    "max_rate": 0.1,
}


def box_mesh(size: tuple[float, float, float], cells: tuple[int, int, int]) -> TetMesh:
    """A box from the origin, six tetrahedra a cell."""
    axes = [np.linspace(0.0, length, m + 1) for length, m in zip(size, cells, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    nodes: Array = grid.reshape(-1, 3)
    numbers: Ints = np.arange(len(nodes)).reshape(grid.shape[:3])
    return TetMesh(nodes, oriented(nodes, split_cells(numbers, mirror_from=cells[1])))


def body_inertia(mesh: TetMesh, density: float) -> tuple[float, Array, Array]:
    """Mass [kg], centre (3,) [m] and second moments ∫ ρ r rᵀ about it (3, 3) [kg m²] of a uniform body."""
    corners = mesh.nodes[mesh.tets]
    mass, middle = density * mesh.volumes, corners.mean(axis=1)
    centre = mass @ middle / mass.sum()
    r, far = corners - centre, middle - centre
    moments = np.einsum("e,eki,ekj->ij", mass, r, r) / 20.0
    moments += np.einsum("e,ei,ej->ij", mass, far, far) * (16.0 / 20.0)
    return float(mass.sum()), centre, moments


def beam_config(size: tuple[float, float, float], **changes: object) -> dict[str, object]:
    """Settings of a beam along x, held at x = 0, one cable along its lower side."""
    length, width, height = size
    middle = 0.5 * width
    settings: dict[str, object] = {
        "name": "beam",
        "mesh": {"file": "beam.vtu"},
        "material": {"young_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0},
        "fixed": [{"lower": [0.0, 0.0, 0.0], "upper": [0.0, width, height]}],
        "gravity": [0.0, 0.0, 0.0],
        "cables": [
            {
                "name": "tendon",
                "points": [[0.1 * length, middle, 0.1 * height], [length, middle, 0.1 * height]],
                "max_tension": 100.0,
                "max_pull": 0.5 * length,
                "max_rate": length,
            }
        ],
        "effectors": [{"name": "tip", "point": [length, middle, 0.5 * height]}],
        "integration": {"scheme": "implicit-euler"},
        "controller": {"rate": 100.0},
    }
    settings.update(changes)
    return settings


def beam_robot(
    mesh: TetMesh, size: tuple[float, float, float], **changes: object
) -> Robot[NodalBody]:
    """A robot made of a beam."""
    config = RobotConfig.model_validate(beam_config(size, **changes))
    return build_robot(config, mesh, "beam")


def without(mesh: TetMesh, cavities: list[tuple[Array, Array]]) -> TetMesh:
    """A mesh without the tetrahedra whose centre lies in one of the boxes (lower, upper)."""
    centres = mesh.nodes[mesh.tets].mean(axis=1)
    inside = np.zeros(len(centres), dtype=bool)
    for lower, upper in cavities:
        inside |= ((centres > lower) & (centres < upper)).all(axis=1)
    tets = mesh.tets[~inside]
    used, tets = np.unique(tets, return_inverse=True)
    return TetMesh(mesh.nodes[used], tets.reshape(-1, 4))


def hollow_beam(cells: tuple[int, int, int] = HOLLOW_CELLS) -> TetMesh:
    """A beam along x with a cavity in its upper part, one cell thick at the top and two at the bottom."""
    lower, upper = np.array([0.01, 0.005, 0.01]), np.array([0.09, 0.015, 0.015])
    return without(box_mesh(HOLLOW_SIZE, cells), [(lower, upper)])


def pneumatic_config(**changes: object) -> dict[str, object]:
    """Settings of a hollow beam held at x = 0, driven by its chamber."""
    settings: dict[str, object] = {
        "name": "balloon",
        "mesh": {"file": "balloon.vtu"},
        "material": {"young_modulus": 5e5, "poisson_ratio": 0.3, "density": 1000.0},
        "fixed": [{"lower": [0.0, 0.0, 0.0], "upper": [0.0, 0.02, 0.02]}],
        "gravity": [0.0, 0.0, 0.0],
        "chambers": [CHAMBER],
        "effectors": [{"name": "tip", "point": [0.1, 0.01, 0.01]}],
        "controller": {"rate": 50.0},
    }
    settings.update(changes)
    return settings


def pneumatic_robot(body: TetMesh | None = None, **changes: object) -> Robot[NodalBody]:
    """A robot made of a hollow beam."""
    config = RobotConfig.model_validate(pneumatic_config(**changes))
    return build_robot(config, hollow_beam() if body is None else body, "balloon")


def sphere_surface(subdivisions: int) -> tuple[Array, Ints]:
    """Points (p, 3) on the unit sphere and triangles (t, 3) of a subdivided icosahedron."""
    g = 0.5 * (1.0 + np.sqrt(5.0))
    points = [[-1, g, 0], [1, g, 0], [-1, -g, 0], [1, -g, 0], [0, -1, g], [0, 1, g],
              [0, -1, -g], [0, 1, -g], [g, 0, -1], [g, 0, 1], [-g, 0, -1], [-g, 0, 1]]  # fmt: skip
    faces = [[0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4],
             [11, 10, 2], [10, 7, 6], [7, 1, 8], [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8],
             [3, 8, 9], [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1]]  # fmt: skip
    x, triangles = np.array(points, dtype=float), np.array(faces)
    for _ in range(subdivisions):
        edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        unique, inverse = np.unique(edges, axis=0, return_inverse=True)
        middle = len(x) + inverse.reshape(-1, 3)
        x = np.vstack([x, x[unique].mean(axis=1)])
        a, b, c = triangles.T
        ab, bc, ca = middle.T
        triangles = np.concatenate(
            [
                np.stack(part, axis=1)
                for part in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
            ]
        )
    return x / np.linalg.norm(x, axis=1, keepdims=True), triangles


def hollow_sphere(inner: float, outer: float, subdivisions: int, layers: int) -> TetMesh:
    """A thick-walled sphere around the origin, prisms between scaled copies of a surface cut into three.

    Args:
        inner: radius [m].
        outer: radius [m].
        subdivisions: of the icosahedron.
        layers: of prisms.
    """
    points, triangles = sphere_surface(subdivisions)
    radii, p = np.linspace(inner, outer, layers + 1), len(points)
    nodes = np.concatenate([radius * points for radius in radii])
    corners = np.sort(triangles, axis=1)  # the diagonals of neighbours agree
    tets = []
    for layer in range(layers):
        a, b, c = (corners + layer * p).T
        d, e, f = (corners + (layer + 1) * p).T
        tets += [np.stack(tet, axis=1) for tet in ((a, b, c, f), (a, b, e, f), (a, d, e, f))]
    return TetMesh(nodes, oriented(nodes, np.concatenate(tets)))


def pressing_finger(
    friction: float, total: float | None = None, table: float | None = None, **limits: float
) -> Robot:
    """A beam 1 mm above a table, which a cable on its lower side bends down.

    Args:
        friction: coefficient.
        total: largest force of all contacts [N].
        table: largest force on the table [N].
        limits: of its contact.
    """
    settings = beam_config(
        PRESSED, fixed=[{"lower": [-1.0, -1.0, -1.0], "upper": [1e-4, 1.0, 1.0]}], gravity=[0.0, 0.0, 0.0],
        integration={"scheme": "quasi-static"},
        regions=[{"name": "below", "kind": "normal", "direction": [0, 0, -1]}],
        obstacles=[
            {"name": "table", "shape": "plane",
             "parameters": {"point": [0.0, 0.0, -0.001], "normal": [0.0, 0.0, 1.0]},
             **({} if table is None else {"max_force": table})}
        ],
        contacts=[
            {"candidates": "below", "against": "table", "points": 8, "friction": friction, **limits}
        ],
        contact={} if total is None else {"max_force": total},
    )  # fmt: skip
    return build_robot(
        RobotConfig.model_validate(settings), box_mesh(PRESSED, (10, 1, 1)), "finger"
    )


def pressed(
    controller: Controller, down: float, steps: int = 25
) -> tuple[float, list[Status], tuple[str, ...]]:
    """Force on the table [N] after steps towards a target below it, their statuses, and the last conflict."""
    goal, statuses = controller.effector_values - [0.0, 0.0, down], []
    for _ in range(steps):
        actuation = controller.step(goal)
        statuses.append(actuation.status)
        assert actuation.status.usable
    return float(controller.contacts.normal_force.sum()), statuses, actuation.conflict
