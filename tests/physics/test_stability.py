"""Columns pushed straight beyond Euler's load, as constrained and as reduced robots: the elastica."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipk
from support.robots.beam_robots import build, path_of_beams, rectangle
from support.robots.bodies import CABLE, beam_config, box_mesh
from support.robots.joined import PLASTIC, joined, push, rod
from support.robots.small_bodies import RUBBER, constrained
from support.state_bases import basis_of

from tauten.model import Ending, Robot, Simulator, State
from tauten.model.load import build_robot
from tauten.model.numerics import Array
from tauten.model.schema import RobotConfig
from tauten.reduction.state import ReducedBody, reduced_robot, reducible

L, DIAMETER = 0.1, 2e-3
SIZE = (0.2, 0.01, 0.02)
COLUMN = {
    "gravity": [0.0, 0.0, 0.0],
    "mesh": {"file": "column.vtu", "element": "quadratic"},
    "material": {**RUBBER, "poisson_ratio": 0.0},
    "integration": {"scheme": "quasi-static"},
    "fixed": [{"lower": [0.0, 0.0, 0.0], "upper": [0.0, 0.01, 0.02]}],
    "effectors": [{"name": "tip", "point": [0.2, 0.005, 0.01]}],
    "cables": [{**CABLE, "points": [[0.0, 0.005, 0.01], [0.2, 0.005, 0.01]]}],
}


def euler(stiffness: float, length: float) -> float:
    """Euler's load of a cantilever [N]."""
    return np.pi**2 * stiffness / (4.0 * length**2)


def of_solids() -> tuple[Robot, float, float]:
    """A bar of tetrahedra whose end is rigid, Euler's load and its length."""
    end = {"kind": "half_space", "point": [0.1999, 0.0, 0.0], "normal": [1.0, 0.0, 0.0]}
    robot = constrained(
        box_mesh(SIZE, (16, 1, 2)), SIZE, rigid=[{"name": "cap", "region": end}], **COLUMN
    )
    return robot, euler(1e6 * 0.02 * 0.01**3 / 12.0, SIZE[0]), SIZE[0]


def of_a_rod() -> tuple[Robot, float, float]:
    """A beam beside a rigid disc that is glued to its end."""
    root, tip = (
        {"body": "rod", "kind": "sphere", "centre": [x, 0.0, 0.0], "radius": 1e-6} for x in (0.0, L)
    )
    robot = joined(
        [
            rod("rod", [[0.0, 0.0, 0.0], [L, 0.0, 0.0]], fixed=[root], elements=12),
            {"name": "disc", "rigid": True, "position": [L, -0.005, -0.005]},
        ],
        {"disc": ((0.002, 0.01, 0.01), (1, 1, 1))},
        attachments=[{"kind": "glue", "region": tip, "to": {"kind": "all", "body": "disc"}}],
        effectors=[{"name": "tip", "point": [L, 0.0, 0.0]}],
        forces=[push("push", [L, 0.0, 0.0], [0.0, 0.0, 1.0])],
    )  # fmt: skip
    bending = PLASTIC["young_modulus"] * np.pi / 64.0 * DIAMETER**4
    return robot, euler(bending, L), L


def of_strain_modes(folder: Path) -> tuple[Robot, float, float]:
    """A robot of beams in all of its strains."""
    nodes = np.outer(np.linspace(0.0, L, 13), [1.0, 0.0, 0.0])
    beams = path_of_beams(nodes, (0.0, 0.0, 1.0), "column")
    profile = rectangle("column", 2e-3, 1e-3)
    robot = build(folder, nodes, beams, [profile], (2e9, 0.3, 1100.0), [0], 12)
    body = reducible(robot)
    Phi = np.eye(len(body.weight)) / np.sqrt(body.weight)[:, None]
    every = np.arange(body.n_elements)
    reduced = reduced_robot(robot, basis_of(robot, Phi, every, np.ones(len(every))))
    return reduced, euler(2e9 * 2e-3 * 1e-3**3 / 12.0, L), L


def of_displacement_modes() -> tuple[Robot[ReducedBody], float, float]:
    """A bar of tetrahedra in modes of its bent equilibria to one side, and all elements."""
    config = RobotConfig.model_validate(beam_config(SIZE, **COLUMN))
    full = build_robot(config, box_mesh(SIZE, (16, 1, 2)), "column")
    load, found = euler(1e6 * 0.02 * 0.01**3 / 12.0, SIZE[0]), list[Array]()
    simulator = Simulator(full, contact="none")
    for along, aside in (
        (0.0, 0.02),
        (0.5, 0.05),
        (0.9, 0.05),
        (1.1, 0.05),
        (1.1, 0.0),
        (1.2, 0.0),
    ):
        simulator.load(np.zeros(3), load * np.array([-along, aside, 0.0]))
        assert simulator.settle(effort=[0.0], tolerance=1e-8).converged
        found.append(simulator.state.q - full.rest().q)
    simulator.reset()
    simulator.load(np.zeros(3), load * np.array([-0.5, 0.0, 0.0]))
    assert simulator.settle(effort=[0.0], tolerance=1e-8).converged
    found.append(simulator.state.q - full.rest().q)
    root = np.sqrt(reducible(full).weight)[:, None]
    Phi = np.linalg.qr(root * np.stack(found, axis=1))[0] / root
    every = np.arange(reducible(full).n_elements)
    reduced = reduced_robot(full, basis_of(full, Phi, every, np.ones(len(every))))
    return reduced, load, SIZE[0]


COLUMNS = ["solids", "rod", "strain modes", "displacement modes"]


@pytest.fixture(scope="module", params=COLUMNS)
def column(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Robot, float, float]:
    if request.param == "strain modes":
        return of_strain_modes(tmp_path_factory.mktemp("column"))
    made = {"solids": of_solids, "rod": of_a_rod, "displacement modes": of_displacement_modes}
    return made[request.param]()


def pushed(robot: Robot, force: float, **options: int | bool) -> tuple[Simulator, object]:
    """Settled from the straight rest under a dead force along the column [N]."""
    loaded = robot.loaded(np.zeros(3), np.array([-force, 0.0, 0.0]))
    simulator = Simulator(loaded, contact="none")
    report = simulator.settle(effort=np.zeros(robot.n_a), **options)  # type: ignore[arg-type]
    return simulator, report.ending


def aside(robot: Robot, state: State) -> float:
    """How far the tip has gone across the column [m]."""
    moved = robot.effector(state)[0] - robot.effector(robot.rest())[0]
    return float(np.hypot(moved[1], moved[2]))


def test_below_eulers_load_the_straight_column_is_settled(
    column: tuple[Robot, float, float],
) -> None:
    robot, load, length = column
    simulator, ending = pushed(robot, 0.95 * load)
    assert ending is Ending.SETTLED
    assert aside(robot, simulator.state) < 1e-3 * length


def test_beyond_it_the_unstable_branch_is_left_for_the_elastica(
    column: tuple[Robot, float, float],
) -> None:
    """Timoshenko and Gere, Theory of Elastic Stability, 2.7; 2 % for the shortening that it leaves out."""
    robot, load, length = column
    simulator, ending = pushed(robot, 1.15 * load)
    assert ending is Ending.SETTLED
    m = brentq(lambda m: (2.0 * ellipk(m) / np.pi) ** 2 - 1.15, 1e-9, 1.0 - 1e-9)
    across = 2.0 * np.sqrt(m) / ellipk(m) * length
    assert aside(robot, simulator.state) == pytest.approx(across, rel=0.04)


def test_without_iterations_to_leave_it_no_column_is_settled(
    column: tuple[Robot, float, float],
) -> None:
    robot, load, _ = column
    _, ending = pushed(robot, 1.15 * load, max_iterations=4, load_steps=False)
    assert ending in (Ending.BUCKLED, Ending.LIMIT_POINT)
