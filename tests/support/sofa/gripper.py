"""The gripper of SoftRobots, its cube and its floor, as robot files.

SOFA moves the gripper down and up. Here the floor moves up and down instead, and the cube with it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import meshio
import numpy as np

from support.robots.bodies import box_mesh

MM = 1e-3
FRICTION, APART = 0.08, 3e-3  # of `ContactHeader` in SoftRobots' tutorial CableGripper; m
EDGE, MASS, GRAVITY = 0.04, 0.03, 0.981  # m, kg, m/s²
FLOOR, WAY = -0.160, 0.048  # m, before and how far it is moved

FINGER = """
name = "finger{number}"
gravity = [0.0, -{gravity}, 0.0]
mesh = {{ file = "finger{number}.vtu" }}
material = {{ young_modulus = 18e6, poisson_ratio = 0.3, total_mass = 0.5, mass = "nodes" }}
fixed = [{{ kind = "nodes", numbers = {fixed} }}]
integration = {{ rayleigh_stiffness = 0.01 }}
[[cables]]
name = "tendon"
pull_point = {pull}
points = {points}
max_tension = 200.0
max_pull = 0.04
max_rate = 0.1
"""
CUBE = """
name = "cube"
gravity = [0.0, -{gravity}, 0.0]
[[bodies]]
name = "block"
mesh = {{ file = "cube.vtu" }}
rigid = true
free = true
material = {{ young_modulus = 1e8, poisson_ratio = 0.3, density = {density} }}
[[effectors]]
name = "place"
kind = "centre"
region = {{ lower = [-1.0, -1.0, -1.0], upper = [1.0, 1.0, 1.0] }}
"""
GRIPPER = """
name = "gripper"
gravity = [0.0, -{gravity}, 0.0]
[[obstacles]]
name = "floor"
shape = "plane"
parameters = {{ point = [0.0, {floor}, 0.0], normal = [0.0, 1.0, 0.0] }}
[obstacles.path]
waypoints = [{waypoints}]
[[parts]]
name = "cube"
robot = "cube.toml"
position = [0.0, {height}, 0.010]
[[contacts]]
candidates = {{ part = "cube" }}
against = "floor"
points = "vertices"
friction = {friction}
[contact]
distance = {apart}
alarm_distance = {alarm}
[controller]
rate = 100.0
"""
PART = """
[[parts]]
name = "finger{number}"
robot = "finger{number}.toml"
[[contacts]]
candidates = {{ part = "finger{number}" }}
against = {{ part = "cube" }}
points = "vertices"
friction = {friction}
"""


@dataclass(frozen=True, slots=True)
class Course:
    """When the floor moves: up, down, each for a time [s]."""

    up: float
    down: float
    time: float

    def height(self, now: float) -> float:
        """Of the floor above its place at the start [m]."""
        up, down = (np.clip((now - start) / self.time, 0.0, 1.0) for start in (self.up, self.down))
        return float(WAY * (up**2 * (3.0 - 2.0 * up) - down**2 * (3.0 - 2.0 * down)))


def gripper_file(data: Path, folder: Path, course: Course, friction: float = FRICTION) -> Path:
    """The file of gripper and cube; the cube is at rest on the floor where this is at the start.

    Args:
        data: of SOFA's robots.
        folder: into which files go.
        course: of the floor.
        friction: coefficient of the fingers and of the floor.
    """
    model = np.load(data / "grasp_model.npz")
    parts = ""
    for number in range(3):
        nodes = MM * model[f"f{number}_nodes"]
        meshio.Mesh(nodes, [("tetra", model["tets"])]).write(folder / f"finger{number}.vtu")
        (folder / f"finger{number}.toml").write_text(
            FINGER.format(
                number=number, gravity=GRAVITY, fixed=model[f"f{number}_fixed"].tolist(),
                pull=(MM * model[f"f{number}_pull"]).tolist(),
                points=(MM * model[f"f{number}_cable"]).tolist(),
            )
        )  # fmt: skip
        parts += PART.format(number=number, friction=friction)
    box = box_mesh((EDGE, EDGE, EDGE), (1, 1, 1))
    meshio.Mesh(box.nodes - 0.5 * EDGE, [("tetra", box.tets)]).write(folder / "cube.vtu")
    (folder / "cube.toml").write_text(CUBE.format(gravity=GRAVITY, density=MASS / EDGE**3))
    way = course.time * np.linspace(0.0, 1.0, 13)
    times = np.unique(np.maximum([0.0, *course.up + way, *course.down + way], 0.0))
    waypoints = ", ".join(
        f"{{ time = {now}, position = [0.0, {course.height(now)}, 0.0] }}" for now in times
    )
    (folder / "gripper.toml").write_text(
        GRIPPER.format(
            gravity=GRAVITY, floor=FLOOR, friction=friction, apart=APART, alarm=APART + 2e-3,
            height=FLOOR + course.height(0.0) + APART + 0.5 * EDGE, waypoints=waypoints,
        ) + parts
    )  # fmt: skip
    return folder / "gripper.toml"
