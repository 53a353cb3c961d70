"""Motions of soft bodies in MuJoCo, the referee of tetrahedra in motion.

    python tests/reference/make_mujoco_soft.py [FILE]     (by default tests/reference/data/mujoco_soft.json)

Needs the package `mujoco`. Bodies are boxes of linear tetrahedra (`flex`) whose law is that of Saint
Venant and Kirchhoff, with masses at their nodes, without damping and weight. Steps are of RK4 and of 20 µs.
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[2]))  # before the benchmarks of the tests

from support.robots.bodies import box_mesh

from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array, Bools

POISSON_RATIO, DENSITY = 0.3, 1000.0  # 1, kg/m³
PERIOD, PERIODS, STEP = 0.008, 40, 2e-5  # s


@dataclass(frozen=True, slots=True)
class Case:
    """One motion, from rest in place.

    Attributes:
        size: of the box [m].
        cells: along its edges.
        young_modulus: E [Pa].
        held: whether its nodes at x = 0 stay.
        lift: velocity along z at the far end, and as x² before it [m/s].
        spin: velocity with which the box turns [rad/s]; of one that is held as x, and about x.
    """

    size: tuple[float, float, float]
    cells: tuple[int, int, int]
    young_modulus: float
    held: bool = True
    lift: float = 0.0
    spin: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @property
    def mesh(self) -> TetMesh:
        """Its tetrahedra."""
        return box_mesh(self.size, self.cells)

    @property
    def free(self) -> Bools:
        """The nodes that move: (n_nodes,)."""
        nodes = self.mesh.nodes
        free: Bools = (nodes[:, 0] > 1e-9) | (not self.held)
        return free

    @property
    def velocity(self) -> Array:
        """Of all nodes at the start: (n_nodes, 3) [m/s]."""
        nodes = self.mesh.nodes
        along = nodes[:, :1] / self.size[0]  # (n_nodes, 1)
        turning = np.cross(self.spin, nodes - 0.5 * np.array(self.size))
        turned = along * turning if self.held else turning
        found: Array = turned + self.lift * along**2 * np.array([0.0, 0.0, 1.0])
        return found


CASES = {
    "bends": Case((0.1, 0.01, 0.005), (8, 1, 1), 1e6, lift=0.2),
    "twists": Case((0.06, 0.02, 0.01), (4, 2, 1), 1e5, spin=(15.0, 0.0, 0.0)),
    "tumbles": Case((0.04, 0.02, 0.01), (3, 2, 1), 1e5, held=False, spin=(10.0, 25.0, 5.0)),
}


def model(case: Case) -> str:
    """The scene, in MuJoCo's format."""
    mesh, bodies = case.mesh, ""
    masses = np.zeros(len(mesh.nodes))
    np.add.at(masses, mesh.tets, 0.25 * DENSITY * mesh.volumes[:, None])
    slides = "".join(f'<joint type="slide" axis="{axis}"/>' for axis in ("1 0 0", "0 1 0", "0 0 1"))
    for node, (place, mass, moves) in enumerate(zip(mesh.nodes, masses, case.free, strict=True)):
        heavy = f'<inertial pos="0 0 0" mass="{mass}" diaginertia="1e-9 1e-9 1e-9"/>'
        inside = slides + heavy if moves else ""
        bodies += f'<body name="n{node}" pos="{_text(place)}">{inside}</body>'
    names = " ".join(f"n{node}" for node in range(len(masses)))
    return (
        f'<mujoco><option timestep="{STEP}" integrator="RK4" gravity="0 0 0">'
        f'<flag contact="disable"/></option><worldbody>{bodies}</worldbody><deformable>'
        f'<flex name="box" dim="3" radius="1e-4" body="{names}" vertex="{_text(np.zeros(3 * len(masses)))}" '
        f'element="{_text(mesh.tets.ravel())}"><contact selfcollide="none"/>'
        f'<elasticity young="{case.young_modulus}" poisson="{POISSON_RATIO}"/></flex>'
        f"</deformable></mujoco>"
    )


def run(case: Case) -> list[list[float]]:
    """The last node at the end of each period: (PERIODS, 3) [m]."""
    import mujoco

    scene = mujoco.MjModel.from_xml_string(model(case))
    data, rows = mujoco.MjData(scene), []
    data.qvel[:] = case.velocity[case.free].ravel()
    for _ in range(PERIODS):
        for _ in range(round(PERIOD / STEP)):
            mujoco.mj_step(scene, data)
        place = case.mesh.nodes[-1] + data.qpos[-3:]
        rows.append([round(float(x), 9) for x in place])
    return rows


def _text(numbers: Array) -> str:
    return " ".join(map(str, numbers.tolist()))


def main() -> None:
    """Write the motions."""
    import mujoco

    default = Path(__file__).parent / "data/mujoco_soft.json"
    file = Path(sys.argv[1]) if len(sys.argv) > 1 else default
    motions = {name: run(case) for name, case in CASES.items()}
    text = json.dumps({"mujoco": mujoco.__version__, "motions": motions}) + "\n"
    file.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
