"""Motions of rigid links in MuJoCo, the referee of hinges, tendons and rotating bodies.

    python tests/reference/make_mujoco.py [FILE]     (by default tests/reference/data/mujoco.json)

Needs the package `mujoco`. Links are boxes along x at rest, each on a hinge at its near end; a tendon passes
two points of each. Steps are of RK4 and of 20 µs.
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from pathlib import Path

LENGTHS, SIDE, DENSITY = (0.05, 0.04, 0.03), 0.01, 1000.0  # m, m, kg/m³
ROOT, MIDDLE = 0.02, 0.5 * SIDE  # of the base along x, and of the hinges across [m]
HEIGHT = 0.009  # of the tendon along z [m]
ON_BASE, ON_LINKS = 0.015, (0.2, 0.8)  # points of the tendon along x [m], and along each link
PERIOD, PERIODS, STEP = 0.02, 25, 2e-5  # s
Vector = tuple[float, float, float]
ACROSS: Vector = (0.0, 1.0, 0.0)


@dataclass(frozen=True, slots=True)
class Case:
    """One motion, from rest.

    Attributes:
        axes: of the three hinges.
        gravity: in m/s².
        aside: where the tendon is along y, from the middle of the links [m].
        tension: of the tendon, which grows from 0 in the first period [N].
        winch: velocity with which the tendon is pulled in place of a given tension [m/s].
        stiffness: of the tendon then [N/m].
        free: whether nothing holds the base.
    """

    axes: tuple[Vector, Vector, Vector] = (ACROSS, (0.0, 0.0, 1.0), ACROSS)
    gravity: Vector = (1.0, -2.0, -9.5)
    aside: float = 0.001
    tension: float = 0.0
    winch: float = 0.0
    stiffness: float = 0.0
    free: bool = False


PLANE = (ACROSS, ACROSS, ACROSS)
CASES = {
    "falls": Case(),
    "oblique": Case(axes=((0.6, 0.8, 0.0), (0.0, 0.6, 0.8), (0.48, 0.6, 0.64))),
    "winch": Case(winch=0.02, stiffness=20.0),
    "free": Case(gravity=(0.0, 0.0, -1.0), tension=0.02, free=True),
    "plane_falls": Case(axes=PLANE, aside=0.0, gravity=(1.0, 0.0, -9.5)),
    "plane_tension": Case(axes=PLANE, aside=0.0, gravity=(1.0, 0.0, -9.5), tension=0.05),
    "plane_free": Case(axes=PLANE, aside=0.0, gravity=(0.0, 0.0, -1.0), tension=0.05, free=True),
}


def model(case: Case) -> str:
    """The scene, in MuJoCo's format."""
    links = ends = ""
    path = '<site site="root"/>'
    for number, (length, axis) in enumerate(zip(LENGTHS, case.axes, strict=True)):
        place = f"{ROOT if number == 0 else LENGTHS[number - 1]} 0 0"
        links += f'<body pos="{place}"><joint type="hinge" axis="{_text(axis)}"/>{_box(length)}'
        for point, share in enumerate(ON_LINKS):
            name = f"link{number}{point}"
            links += _site(name, share * length, case.aside)
            path += f'<site site="{name}"/>'
        ends += "</body>"
    links += f'<site name="tip" pos="{LENGTHS[-1]} 0 0"/>'
    held = "" if not case.free else f"<freejoint/>{_box(ROOT)}"
    base = f'<body pos="0 {MIDDLE} {MIDDLE}">{held}{_site("root", ON_BASE, case.aside)}{links}{ends}</body>'
    actuator = '<motor tendon="tendon" gear="-1"/>'
    if case.stiffness:
        k = case.stiffness
        actuator = (
            f'<general tendon="tendon" gear="-1" gaintype="fixed" gainprm="{k}" biastype="affine" '
            f'biasprm="0 {-k} 0" ctrllimited="false" forcelimited="true" forcerange="0 1e6"/>'
        )
    return (
        f'<mujoco><option timestep="{STEP}" integrator="RK4" gravity="{_text(case.gravity)}">'
        f'<flag contact="disable"/></option><worldbody>{base}</worldbody>'
        f'<tendon><spatial name="tendon">{path}</spatial></tendon><actuator>{actuator}</actuator></mujoco>'
    )


def run(case: Case) -> list[list[float]]:
    """The tip at the end of each period: (PERIODS, 3) [m]."""
    import mujoco

    scene = mujoco.MjModel.from_xml_string(model(case))
    data = mujoco.MjData(scene)
    mujoco.mj_forward(scene, data)
    rest, rows, steps = data.ten_length[0], [], round(PERIOD / STEP)
    for number in range(PERIODS * steps):
        if case.stiffness:  # the actuator's length is -1 times the tendon's
            pulled = case.winch * (number + 0.5) * STEP
            data.ctrl[0] = pulled - rest
        else:
            data.ctrl[0] = case.tension * min(1.0, (number + 0.5) / steps)
        mujoco.mj_step(scene, data)
        if (number + 1) % steps == 0:
            mujoco.mj_forward(scene, data)
            rows.append([round(float(x), 9) for x in data.site("tip").xpos])
    return rows


def _text(vector: Vector) -> str:
    return " ".join(str(x) for x in vector)


def _site(name: str, along: float, aside: float) -> str:
    return f'<site name="{name}" pos="{along} {aside} {HEIGHT - MIDDLE}"/>'


def _box(length: float) -> str:
    mass = DENSITY * SIDE * SIDE * length
    across, along = mass * (length**2 + SIDE**2) / 12.0, mass * SIDE**2 / 6.0
    return f'<inertial pos="{0.5 * length} 0 0" mass="{mass}" diaginertia="{along} {across} {across}"/>'


def main() -> None:
    """Write the motions."""
    import mujoco

    file = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "data/mujoco.json"
    motions = {name: run(case) for name, case in CASES.items()}
    text = json.dumps({"mujoco": mujoco.__version__, "motions": motions}) + "\n"
    file.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
