"""Writes CalculiX decks, runs them and keeps their results: the referee of quadratic elements.

    python tests/reference/make_calculix.py [FOLDER]     (by default tests/reference/data)

Needs `ccx` (Debian package calculix-ccx). Quadratic tetrahedra C3D10, Neo-Hookean with C10 = μ/2 and
D1 = 2/κ, large displacements. The decks and one JSON file with displacements are written; decks above
200 kB are not kept.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[2]))  # before the benchmarks of the tests

from support.robots.bodies import box_mesh
from support.robots.solids import face_load
from support.robots.thumb import coarse_finger_mesh

from tauten.model.materials import lame_parameters
from tauten.model.mesh import QuadraticMesh, quadratic_mesh
from tauten.model.numerics import Array, Bools

STEPS = 20  # equal load increments


@dataclass(frozen=True, slots=True)
class Case:
    """A body held at some nodes under nodal forces.

    Attributes:
        mesh: quadratic tetrahedra.
        fixed: (n_nodes,) nodes that do not move.
        load: (n_nodes, 3) nodal forces [N].
        young_modulus: E [Pa].
        poisson_ratio: ν.
    """

    mesh: QuadraticMesh
    fixed: Bools
    load: Array
    young_modulus: float
    poisson_ratio: float


def box_case(
    size: tuple[float, float, float], cells: tuple[int, int, int], force: Array, nu: float
) -> Case:
    """A box held at x = 0, a force (3,) spread over its other end."""
    mesh = quadratic_mesh(box_mesh(size, cells))
    load = face_load(mesh.split(), 0, size[0], force)
    return Case(mesh, mesh.nodes[:, 0] < 1e-9, load, 1e6, nu)


def finger_case() -> Case:
    """A finger with a coarse mesh, held at z = 0, 0.05 N along x spread over the corner nodes of its tip."""
    linear = coarse_finger_mesh()
    mesh = quadratic_mesh(linear)
    tip = np.flatnonzero(linear.nodes[:, 2] < -0.095)
    load = np.zeros_like(mesh.nodes)
    load[tip, 0] = 0.05 / len(tip)
    return Case(mesh, mesh.nodes[:, 2] > -1e-9, load, 0.6e6, 0.45)


def cases() -> dict[str, Case]:
    """All cases by name."""
    return {
        "block_tension": box_case((0.02, 0.02, 0.02), (2, 2, 2), np.array([120.0, 0.0, 0.0]), 0.45),
        "block_shear": box_case((0.02, 0.02, 0.02), (2, 2, 2), np.array([0.0, 0.0, 60.0]), 0.49),
        "cantilever": box_case((0.1, 0.01, 0.01), (10, 2, 2), np.array([0.0, 0.0, 0.1]), 0.45),
        "cantilever_rubber": box_case(
            (0.1, 0.01, 0.01), (10, 2, 2), np.array([0.0, 0.0, 0.02]), 0.499
        ),
        "finger": finger_case(),
    }


def deck(case: Case) -> str:
    """The input deck of a case."""
    lam, mu = lame_parameters(case.young_modulus, case.poisson_ratio)
    kappa = lam + 2.0 / 3.0 * mu
    # CalculiX numbers the mid-edge nodes as VTK does
    lines = ["*NODE, NSET=ALL"]
    lines += [
        f"{i}, {x:.12e}, {y:.12e}, {z:.12e}" for i, (x, y, z) in enumerate(case.mesh.nodes, 1)
    ]
    lines += ["*ELEMENT, TYPE=C3D10, ELSET=BODY"]
    lines += [", ".join(map(str, [e, *(row + 1)])) for e, row in enumerate(case.mesh.tets, 1)]
    lines += ["*BOUNDARY"]
    lines += [f"{node + 1}, 1, 3" for node in np.flatnonzero(case.fixed)]
    lines += ["*MATERIAL, NAME=RUBBER", "*HYPERELASTIC, NEO HOOKE"]
    lines += [f"{0.5 * mu:.12e}, {2.0 / kappa:.12e}"]
    lines += ["*SOLID SECTION, ELSET=BODY, MATERIAL=RUBBER"]
    lines += ["*STEP, NLGEOM, INC=1000", "*STATIC, DIRECT", f"{1.0 / STEPS}, 1.0"]
    lines += ["*CONTROLS, PARAMETERS=FIELD", "1e-8, 1e-8"]
    lines += ["*CLOAD"]
    for node, axis in np.argwhere(case.load != 0.0):
        lines.append(f"{node + 1}, {axis + 1}, {case.load[node, axis]:.12e}")
    lines += [f"*NODE PRINT, NSET=ALL, FREQUENCY={STEPS}", "U", "*END STEP", ""]
    return "\n".join(lines)


def run(text: str) -> Array:
    """Displacements of all nodes (n_nodes, 3) [m] that CalculiX finds for a deck."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "case.inp"
        path.write_text(text, encoding="ascii")
        done = subprocess.run(["ccx", "case"], cwd=folder, capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(done.stdout[-2000:])
        rows = []
        for line in path.with_suffix(".dat").read_text(encoding="ascii").splitlines():
            fields = line.split()
            if len(fields) == 4:
                rows.append([float(field) for field in fields[1:]])
        return np.array(rows)


def main() -> None:
    """Write decks and results."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "data"
    results = {}
    for name, case in cases().items():
        text = deck(case)
        u = run(text)
        assert len(u) == len(case.mesh.nodes), name
        if len(text) < 200_000:
            (folder / f"calculix_{name}.inp").write_text(text, encoding="ascii")
        loaded = np.any(case.load != 0.0, axis=1)
        results[name] = {
            "nodes": len(u),
            "mean_displacement_of_loaded_nodes": u[loaded].mean(axis=0).tolist(),
            "largest_displacement": float(np.linalg.norm(u, axis=1).max()),
        }
        print(name, results[name], flush=True)
    text = json.dumps(results, indent=1) + "\n"
    (folder / "calculix.json").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
