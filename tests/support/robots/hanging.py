"""A beam that hangs at its cable."""

from __future__ import annotations

from pathlib import Path

import meshio

from support.robots.bodies import box_mesh

HANGING = """
name = "beam"
gravity = [0.0, 0.0, -9.81]
[mesh]
file = "beam.vtu"
[material]
young_modulus = {young}
poisson_ratio = 0.3
density = 1000.0
[[fixed]]
lower = [0.0, 0.0, 0.0]
upper = [0.0, 0.02, 0.02]
[[cables]]
name = "tendon"
pull_point = [0.18, 0.01, 0.1]
points = [[0.18, 0.01, 0.01]]
max_tension = {tension}
max_pull = 0.05
max_rate = 0.1
[[effectors]]
name = "tip"
point = [0.2, 0.01, 0.01]
[controller]
rate = {rate}
"""


def hanging_beam(
    folder: Path, tension: float = 100.0, young: float = 1e6, rate: float = 20.0, more: str = ""
) -> Path:
    """Write its robot file and mesh.

    Args:
        folder: where they go.
        tension: largest one of the cable [N].
        young: modulus [Pa].
        rate: of the controller [Hz].
        more: end of the file.
    """
    mesh = box_mesh((0.2, 0.02, 0.02), (10, 1, 1))
    meshio.write(folder / "beam.vtu", meshio.Mesh(mesh.nodes, [("tetra", mesh.tets)]))
    path = folder / "beam.toml"
    text = HANGING.format(tension=tension, young=young, rate=rate) + more
    path.write_text(text, encoding="utf-8")
    return path
