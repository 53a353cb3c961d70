"""Makes the manipulator: manipulator.toml, manipulator_1290.toml and manipulator.json.

    python -m benchmarks.robots.make_manipulator [FOLDER]

Its geometry is described in `benchmarks.robots.arm`.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np

from benchmarks.robots.arm import ArmShape, direction, make_network, tendon_angle
from tauten.model.load import shipped_folder

HEAD = """\
# An arm that hangs from its base: a spine of {length:g} m with {count} vertebrae, ribs that land on the next
# vertebra when it bends, {tendons} tendons in {sections} sections. {candidates:,} contact candidates.
# Made by python -m benchmarks.robots.make_manipulator, as is manipulator.json.
name = "{name}"
frame = "manipulator_base"   # origin where the spine leaves the base, z up
gravity = [0.0, 0.0, -9.81]

[[bodies]]
name = "arm"
beam = {{ file = "manipulator.json" }}

[material]                   # polyamide 12, laser sintered
young_modulus = 1.65e9
poisson_ratio = 0.4
density = 950.0

[[profiles]]
kind = "tube"
name = "spine"
outer = 9.0e-3
inner = 6.0e-3

[[profiles]]
kind = "bar"
name = "rib"
width = 12.0e-3
height = 6.0e-3

[[fixed]]                    # the base plate
lower = [-1e-6, -1e-6, -1e-6]
upper = [1e-6, 1e-6, 1e-6]

[[effectors]]
name = "tip"
point = [0.0, 0.0, {tip:.4f}]
max_outside = {tool:g}

[contact]
alarm_distance = 4.0e-3
tolerance = 1.0e-6

[integration]
scheme = "implicit-euler"
rayleigh_mass = 10.0             # friction of tendons in their holes
rayleigh_stiffness = 0.02

[controller]
rate = 50.0
qp_solver = "daqp"
regularisation = 3.0e-3
following_horizon = 0.04         # s; ribs are near vertebrae, where plans stop the arm at their end
basis = "{name}"

[model]
max_tip_error = 8.0e-3           # 1 % of the arm

[service]
target_timeout = 0.5
release_time = 2.0
"""

TENDON = """
[[cables]]                   # section {section}, at {degrees:g} degrees
name = "{name}"
points = [{points}]
max_tension = 80.0
min_pull = {min_pull:.3f}
max_pull = {max_pull:.3f}
max_rate = 0.150
"""

CONTACT = """
[[regions]]
name = "feet{i}"
kind = "group"
group = "feet{i}"

[[regions]]
name = "disc{i}"
kind = "group"
group = "disc{i}"

[[contacts]]
candidates = "feet{i}"
against = "disc{i}"
points = {points}
"""


def make_file(shape: ArmShape, name: str, candidates: int) -> str:
    """The robot file.

    Args:
        shape: dimensions.
        name: of the robot.
        candidates: contact candidates of all joints.
    """
    tendons = 3 * shape.sections
    parts = [
        HEAD.format(
            name=name, length=shape.length, count=shape.count, tendons=tendons,
            sections=shape.sections, candidates=candidates, tool=shape.tool,
            tip=-shape.length - shape.tool,
        )
    ]  # fmt: skip
    for section in range(1, shape.sections + 1):
        for k in range(3):
            # tendons of different sections share out the circle
            angle = tendon_angle(shape, section - 1, k)
            at = shape.tendon_radius * direction(angle)
            stations = -shape.pitch * np.arange(section * shape.joints + 1)
            holes = [f"\n  [{at[0]:.6f}, {at[1]:.6f}, {z:.6f}]," for z in stations]
            parts.append(
                TENDON.format(
                    section=section, degrees=np.degrees(angle), name=f"tendon{section}{'abc'[k]}",
                    points="".join(holes) + "\n", min_pull=-0.05 * section, max_pull=0.05 * section,
                )
            )  # fmt: skip
    points = candidates // shape.count
    parts += [CONTACT.format(i=i + 1, points=points) for i in range(shape.count)]
    return "".join(parts)


def main() -> None:
    """Write the files into the folder given, by default beside this script."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else shipped_folder()
    shape = ArmShape()
    network = make_network(shape)
    (folder / "manipulator.json").write_text(json.dumps(network) + "\n", encoding="utf-8")
    for name, candidates in (("manipulator", 4500), ("manipulator_1290", 1290)):
        text = make_file(shape, name, candidates)
        (folder / f"{name}.toml").write_text(text, encoding="utf-8")
        print(f"{folder / name}.toml: {len(network['nodes'])} nodes, {candidates} candidates")


if __name__ == "__main__":
    main()
