"""A soft cube that forces slide over a floor, beside a cone that is a diamond.

The scene is CubeOnFloor of SoftRobots.Inverse (its numbers alone are used, tests/component/solver/scenes): a
cube of 20 mm, 600 kPa, Poisson's ratio 0.49, 5 g, pushed along x by up to 0.5 mN s a step of 10 ms at each of
four nodes; a target for the middle of its front. Its own test of sliding, with a target 14 mm away and
a bound of 0.1 mm, is commented out. Its solver has |r_1| + |r_2| <= μ r_n.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

import meshio
import numpy as np
import pytest
from support.robots.bodies import box_mesh

from tauten.controller import Controller
from tauten.model import Command, CondensedStep, Simulator, load_robot
from tauten.model.numerics import Array
from tauten.model.step import sorted_rows

EDGE, MASS, GRAVITY, FRICTION = 0.02, 0.005, 9.18, 0.8
MOST = 4 * 0.5e-3 / 0.01  # N
WAY = 0.014  # m
BOUND = 1e-4  # m
CUBE = """
name = "cube_on_floor"
gravity = [0.0, -9.18, 0.0]
[[bodies]]
name = "cube"
mesh = {{ file = "cube.vtu" }}
free = true
material = {{ young_modulus = 6e5, poisson_ratio = 0.49, total_mass = 0.005, mass = "nodes" }}
[[effectors]]
name = "front"
point = [0.01, 0.0, 0.0]
weight = [1.0, 0.0, 1.0]
[[obstacles]]
name = "floor"
shape = "plane"
parameters = {{ point = [0.0, -0.011, 0.0], normal = [0.0, 1.0, 0.0] }}
[[contacts]]
against = "floor"
points = "vertices"
friction = {friction}
[contact]
distance = 1e-3
alarm_distance = 3e-3
[integration]
scheme = "implicit-euler"
rayleigh_stiffness = 0.002
[controller]
rate = 100.0
friction_share = 1.0
horizon = 0.02
"""
FORCE = """
[[forces]]
name = "{name}"
region = {{ lower = {lower}, upper = {upper} }}
direction = {direction}
min_force = 0.0
max_force = {most}
max_travel = 0.05
max_rate = 1.0
"""


def cube_file(folder: Path, axes: str, friction: float = FRICTION) -> Path:
    """A robot file; the cube has 2 cells along an edge.

    Args:
        folder: into which files go.
        axes: along which of x and z forces act.
        friction: coefficient.
    """
    box = box_mesh((EDGE, EDGE, EDGE), (2, 2, 2))
    meshio.Mesh(box.nodes - 0.5 * EDGE, [("tetra", box.tets)]).write(folder / "cube.vtu")
    text = CUBE.format(friction=friction)
    for name in axes:
        at = "xyz".index(name)
        lower, upper = np.full((2, 3), [[-0.0034], [0.0034]])
        lower[at], upper[at] = -0.0101, -0.0099
        direction = np.eye(3)[at].tolist()
        text += FORCE.format(
            name=name, lower=lower.tolist(), upper=upper.tolist(), direction=direction, most=MOST
        )
    (folder / "cube.toml").write_text(text)
    return folder / "cube.toml"


def diamond_forces(
    step: CondensedStep, start: Array, command: Command
) -> tuple[Array, float, bool]:
    """As `solve_forces` under given efforts: projected Gauss-Seidel with |r_1| + |r_2| <= μ r_n."""
    rows, every = sorted_rows(step, command), step.compliance.W
    lam = np.zeros(len(start))
    lam[rows.forced] = rows.effort
    contacts = rows.contacts
    W, q, r = every[np.ix_(contacts, contacts)], rows.under_effort(every)[contacts], start[contacts]
    for _ in range(300):
        before = r.copy()
        for first, mu in zip(range(0, len(r), 3), step.friction, strict=True):
            here = slice(first, first + 3)
            scale = np.diag(W)[here].max()
            wanted = r[here] - (W[here] @ r + q[here]) / scale
            normal = max(wanted[0], 0.0)
            r[here] = normal, *in_diamond(wanted[1:], mu * normal)
        if np.abs(r - before).max(initial=0.0) <= 1e-6 * np.abs(r).max(initial=0.0):
            break
    lam[contacts] = r
    return lam, 0.0, True


def in_diamond(r: Array, size: float) -> Array:
    """The nearest of (2,) with |r_1| + |r_2| <= size."""
    excess = np.abs(r).sum() - size
    if excess <= 0.0:
        return r
    shrunk = np.abs(r) - 0.5 * excess
    if shrunk.min() < 0.0:  # a corner
        shrunk = np.where(np.abs(r) == np.abs(r).max(), size, 0.0)
    return np.sign(r) * shrunk


@pytest.mark.parametrize("angle", [pytest.param(0.0, marks=pytest.mark.slow), 45.0])
@pytest.mark.parametrize("cone", ["exact", "diamond"])
def test_a_cone_holds_in_every_direction_and_a_diamond_does_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, cone: str, angle: float
) -> None:
    """Under 85 % of the friction of its weight; at 45° a diamond has 71 %, and slides with what is left."""
    if cone == "diamond":
        forward_step = import_module("tauten.model.step.forward_step")
        monkeypatch.setattr(forward_step, "solve_forces", diamond_forces)
    simulator = Simulator(load_robot(cube_file(tmp_path, "xz")))
    share, friction = 0.85, FRICTION * MASS * GRAVITY
    push = share * friction * np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    start = simulator.tip
    for step in range(15):
        simulator.step(effort=min((step + 1) / 5, 1.0) * push)
    gone = np.linalg.norm(simulator.tip[[0, 2]] - start[[0, 2]])
    force = np.linalg.norm(simulator.contacts.force.sum(axis=0)[[0, 2]])
    if cone == "diamond" and angle == 45.0:
        assert gone > 1e-3
        assert force == pytest.approx(friction / np.sqrt(2.0), rel=0.03)
    else:
        assert gone < 1e-4
        assert force == pytest.approx(share * friction, rel=0.05)


@pytest.mark.slow
def test_the_target_is_reached_by_sliding(tmp_path: Path) -> None:
    """14 mm in half a second, by a force that can only push; friction brakes."""
    controller = Controller.of(cube_file(tmp_path, "x"))
    start, slid = controller.effector_values, False
    for step in range(1, 61):
        share = min(step / 50, 1.0)
        goal = start + np.array([share * share * (3.0 - 2.0 * share) * WAY, 0.0, 0.0])
        assert controller.step(goal).status.usable
        slid |= bool(controller.contacts.sliding.any())
    assert slid
    assert abs(controller.effector_values[0] - start[0] - WAY) < BOUND


@pytest.mark.slow
@pytest.mark.parametrize(("belief", "arrives"), [(1.0, True), (0.5**0.5, False)])
def test_who_decides_with_a_diamond_leaves_the_cube_behind(
    tmp_path: Path, belief: float, arrives: bool
) -> None:
    """A way of 5 mm in a second, at 45° to the axes of a diamond: it takes friction for 71 % of what it is.

    Args:
        tmp_path: for the files.
        belief: friction of the controller's model, relative to the plant's.
        arrives: whether the plant does.
    """
    (tmp_path / "believed").mkdir()
    controller = Controller.of(cube_file(tmp_path / "believed", "x", belief * FRICTION))
    plant = Simulator.of(cube_file(tmp_path, "x"))
    start = controller.effector_values
    for step in range(1, 111):
        goal = start + np.array([min(step / 100, 1.0) * 5e-3, 0.0, 0.0])
        plant.move(effort=controller.step(goal).effort)
    gone = plant.tip[0] - start[0]
    assert (gone > 4e-3) if arrives else (gone < 2e-3)
    assert controller.effector_values[0] - start[0] == pytest.approx(5e-3, abs=2e-4)
