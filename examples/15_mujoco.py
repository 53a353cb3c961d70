"""MuJoCo as the robot: tauten decides for an arm with three tendons, and MuJoCo simulates it.

python examples/15_mujoco.py            both in turn, without a network; needs the package mujoco
python examples/15_mujoco.py --drive    in real time, beside `tauten serve examples/arm.toml --closed-loop`

MuJoCo's arm is a chain of links on ball joints. It is not compressed as the rod of the model is, its tendons
stretch, and it carries a payload of which the model knows nothing.
"""

from __future__ import annotations

import sys
import time
import tomllib
from collections.abc import Mapping
from itertools import product
from pathlib import Path

import mujoco
import numpy as np

from tauten.controller import Controller
from tauten.model.numerics import Array
from tauten.service.drive import Measured, drive
from tauten.service.node import own_estimator
from tauten.service.process import stop_on_signals
from tauten.service.settings import ServiceSettings
from tauten.service.wire import Network, RobotDescription

FILE = Path(__file__).with_name("arm.toml")
LINKS = 24  # half of the first one is in the wall, the last one is half as long
TIMESTEP = 1e-3  # s
WINCH = 2e4  # N/m, stiffness of winch and tendon
PAYLOAD = 0.02  # kg
RADIUS, TURN = 0.05, 2.0  # m and s, of a circle


def scene(payload: float) -> str:
    """The arm of the robot file in MuJoCo's format, with a payload on its tip [kg]."""
    robot = tomllib.loads(FILE.read_text(encoding="utf-8"))
    material, diameter = robot["material"], robot["profiles"][0]["outer"]
    link = robot["bodies"][0]["beam"]["points"][1][0] / LINKS  # m
    bending = material["young_modulus"] * np.pi * diameter**4 / 64.0 / link  # N m, of a joint
    damping = robot["integration"]["rayleigh_stiffness"] * bending
    eyes: dict[int, str] = {}  # by the number of the link in whose middle they are; 0: the wall
    tendons = winches = ""
    for cable in robot["cables"]:
        name, path = cable["name"], ""
        for x, y, z in cable["points"]:
            number = round(x / link)
            place = f"{0.5 * link if number else 0.0} {y} {z}"
            eyes[number] = eyes.get(number, "") + f'<site name="{name}{number}" pos="{place}"/>'
            path += f'<site site="{name}{number}"/>'
        tendons += f'<spatial name="{name}">{path}</spatial>'
        winches += f'<position tendon="{name}" gear="-1" kp="{WINCH}" forcerange="0 1e3"/>'
    ball = f'<geom type="sphere" size="0.005" pos="{0.5 * link} 0 0" mass="{payload}"/>'
    links = f'<site name="tip" pos="{0.5 * link} 0 0"/>{ball}'
    for number in range(LINKS, 0, -1):
        links = (
            f'<body pos="{0.5 * link if number == 1 else link} 0 0">'
            f'<joint type="ball" stiffness="{bending}" damping="{damping}"/>'
            f'<geom type="cylinder" size="{0.5 * diameter}" density="{material["density"]}"'
            f' fromto="0 0 0 {0.5 * link if number == LINKS else link} 0 0"/>'
            f"{eyes.get(number, '')}{links}</body>"
        )
    return (
        f'<mujoco><option timestep="{TIMESTEP}" integrator="implicitfast"/>'
        f'<option><flag contact="disable"/></option><worldbody>{eyes[0]}{links}</worldbody>'
        f"<tendon>{tendons}</tendon><actuator>{winches}</actuator></mujoco>"
    )


class Arm:
    """The arm in MuJoCo, also as a driver, see docs/extend.md."""

    def __init__(self, payload: float = 0.0) -> None:
        self.model = mujoco.MjModel.from_xml_string(scene(payload))
        self.data = mujoco.MjData(self.model)
        mujoco.mj_forward(self.model, self.data)
        self.rest = self.data.ten_length.copy()  # (3,) m
        self.pulled = self.wanted = np.zeros(3)
        self.move(self.pulled, 3.0)  # until it hangs still

    def move(self, pulled: Array, seconds: float) -> None:
        """Wind the tendons evenly to some pulled lengths (3,) [m]."""
        steps = round(seconds / TIMESTEP)
        for share in np.arange(1, steps + 1) / steps:
            self.data.ctrl[:] = self.pulled + share * (pulled - self.pulled) - self.rest
            mujoco.mj_step(self.model, self.data)
        self.pulled = pulled.copy()

    @property
    def tip(self) -> Array:
        """Where the tip is (3,) [m]."""
        found: Array = self.data.site("tip").xpos.copy()
        return found

    def configure(self, robot: RobotDescription, options: Mapping[str, str]) -> None:
        """The clock of MuJoCo is that of the computer from now on."""
        self.begin = time.monotonic() - self.data.time

    def activate(self) -> None:
        """Nothing is to be done."""

    def deactivate(self) -> None:
        """The tendons stay where they are."""

    def write(self, position: Array, effort: Array) -> None:
        """Wind the tendons there until the next `read`."""
        self.wanted = position

    def read(self) -> Measured:
        """Simulate what has passed on the clock, 0.1 s at most."""
        behind = time.monotonic() - self.begin - self.data.time
        if behind >= TIMESTEP:
            self.move(self.wanted, min(behind, 0.1))
        return Measured(self.rest - self.data.ten_length, self.data.actuator_force, self.tip)


def follow(payload: float, closed: bool) -> tuple[Array, float]:
    """Distances of the tip from a circle in the second turn, one a tick, and then at rest [m]."""
    controller, arm = Controller.of(FILE), Arm(payload)
    feedback = own_estimator(controller.robot, ServiceSettings())
    h, centre = controller.period, controller.tip
    correction, distances = np.zeros(3), list[float]()
    for tick in range(round((2.0 * TURN + 3.0) / h)):
        angle = 2.0 * np.pi * min(tick * h / TURN, 2.0)
        target = centre + RADIUS * np.array([0.0, np.sin(angle), 1.0 - np.cos(angle)])
        arm.move(controller.step(target + correction).position, h)
        if closed:
            correction = feedback.update(controller.tip, arm.tip, h)
        distances.append(float(np.linalg.norm((arm.tip - target)[1:])))
    turn = round(TURN / h)
    return np.array(distances[turn : 2 * turn]), distances[-1]


def main() -> None:
    """Go round a circle and rest, without and with a payload, in open and in closed loop."""
    if "--drive" in sys.argv:
        with stop_on_signals() as stop:
            drive("arm", Arm(PAYLOAD), {}, Network(), stop)
        return
    for payload, closed in product((0.0, PAYLOAD), (False, True)):
        distances, rest = follow(payload, closed)
        rms = np.sqrt(np.mean(distances**2))
        print(
            f"{1e3 * payload:2.0f} g, {'closed' if closed else 'open'} loop: {1e3 * rms:.1f} mm (RMS) from "
            f"the circle, {1e3 * distances.max():.1f} mm at most; {1e3 * rest:.2f} mm from the target at rest"
        )
        if closed:
            assert rms < 4e-3
            assert rest < 1e-4


if __name__ == "__main__":
    main()
