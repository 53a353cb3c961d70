"""A gripper that is told only where a cube is to go, which is heavier or more slippery than it believes."""

from __future__ import annotations

import runpy
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal

import numpy as np

from benchmarks.control.plants import EXAMPLES, changed_example, force_of, observed
from tauten.controller import Controller
from tauten.model import Simulator, load_robot
from tauten.model.numerics import Array
from tauten.service.bench import follow, rms
from tauten.service.replay import Spread, spread

EXAMPLE = EXAMPLES / "12_lift.py"
QUICK = EXAMPLES / "quick_lift.toml"  # the file of a controller with a reduced claw
# Mass and friction of the plant, relative to those of the controller's model.
CUBES = ((1.0, 1.0), (1.2, 0.8), (0.8, 1.2))
MODELS: tuple[Literal["full", "reduced"], ...] = ("full", "reduced")
# What decisions at full order leave of the friction: `friction_share`, and `min_slip_margin` [N].
RESERVES = ((0.8, 0.0), (0.66, 0.0), (0.66, 0.05), (0.6, 0.05))
WRONG = (1.2, 0.8)  # of `CUBES`, the one that they are tried with

_GRAVITY = 9.81  # m/s²
_HELD = 0.02  # of the weight, within which the fingers carry it


@dataclass(frozen=True, slots=True)
class LiftRun:
    """A run of the lift.

    Attributes:
        model: of the claw in the controller.
        mass: of the cube, relative to the model's.
        friction: of all contacts, relative to the model's.
        closed: whether measurements correct the targets.
        rms_mm: of the distance between the cube and its target.
        max_mm: largest.
        end_mm: at the end.
        carried: force of the fingers on the cube, upwards, over its weight, at the end.
        held: whether the cube is off the floor at the end and the fingers carry it.
        thread_ms: time of the thread in a control step.
        step_ms: of the whole control step, on the clock.
        unusable: decisions that could not be used.
    """

    model: Literal["full", "reduced"]
    mass: float
    friction: float
    closed: bool
    rms_mm: float
    max_mm: float
    end_mm: float
    carried: float
    held: bool
    thread_ms: Spread
    step_ms: Spread
    unusable: int


@dataclass(frozen=True, slots=True)
class ReserveRun:
    """A run of the lift at full order in open loop, with a heavier cube of less friction.

    Attributes:
        friction_share: of the friction, that decisions count on.
        min_slip_margin: that decisions keep [N].
        run: what came of it.
    """

    friction_share: float
    min_slip_margin: float
    run: LiftRun


class LiftBench:
    """The controllers of two files, and plants that differ from them.

    Attributes:
        plant_steps: of plants in a period; None: they are found for the first one.
    """

    def __init__(self, steps: int | None = None) -> None:
        """Read the example.

        Args:
            steps: of plants in a period; None: as many as they need.
        """
        self.plant_steps = steps
        self._names = runpy.run_path(str(EXAMPLE), run_name=EXAMPLE.stem)
        self._controllers = {
            "full": Controller.of(self._names["FILE"], "full"),
            "reduced": Controller.of(QUICK, "reduced"),
        }

    def with_reserve(
        self, friction_share: float, min_slip_margin: float, seconds: float | None = None
    ) -> ReserveRun:
        """A run of a controller whose file leaves another share of the friction.

        Args:
            friction_share: that decisions count on.
            min_slip_margin: that they keep, 0: none [N].
            seconds: of the run; None: until the target has rested.
        """
        margin = f"min_slip_margin = {min_slip_margin}" if min_slip_margin > 0.0 else ""
        changes = {
            "min_slip_margin = 0.05": margin,
            "rate = 50.0": f"rate = 50.0\nfriction_share = {friction_share}",
        }
        with TemporaryDirectory() as folder:
            controller = Controller.of(changed_example("lift.toml", Path(folder), changes), "full")
        run = self._run(controller, "full", WRONG, False, seconds)
        return ReserveRun(friction_share, min_slip_margin, run)

    def run(
        self,
        model: Literal["full", "reduced"],
        mass: float,
        friction: float,
        closed: bool,
        seconds: float | None = None,
    ) -> LiftRun:
        """One run, from the start.

        Args:
            model: of the claw in the controller.
            mass: of the cube, relative to the model's.
            friction: of all contacts, relative to the model's.
            closed: whether measurements correct the targets.
            seconds: of the run; None: until the target has rested.
        """
        return self._run(self._controllers[model], model, (mass, friction), closed, seconds)

    def _run(
        self,
        controller: Controller,
        model: Literal["full", "reduced"],
        cube: tuple[float, float],
        closed: bool,
        seconds: float | None,
    ) -> LiftRun:
        mass, friction = cube
        with TemporaryDirectory() as folder:
            changes = {
                "density = 1000.0": f"density = {1000.0 * mass}",
                "friction = 0.5": f"friction = {0.5 * friction}",
            }
            robot = load_robot(changed_example("lift.toml", Path(folder), changes))
        plant = observed(Simulator(robot), _seen, self.plant_steps)
        self.plant_steps = plant.steps
        controller.reset()
        start = controller.effector_values
        seconds = seconds or self._names["END"]
        time = controller.period * np.arange(1, round(seconds / controller.period) + 1)
        targets = np.array([self._names["goal"](one, start) for one in time])
        trace = follow(controller, plant, targets, closed=closed)
        seen = np.array(plant.seen)  # (s, 4) place of the cube, and force of the fingers upwards
        error = np.linalg.norm(seen[:, :3] - targets, axis=1)
        weight = robot.body.part_robots[1].body.moving_mass * _GRAVITY
        carried = float(seen[-1, 3]) / weight
        return LiftRun(
            model=model,
            mass=mass,
            friction=friction,
            closed=closed,
            rms_mm=1e3 * rms(error),
            max_mm=1e3 * float(error.max()),
            end_mm=1e3 * float(error[-1]),
            carried=carried,
            held=bool(abs(carried - 1.0) < _HELD and seen[-1, 2] > start[2] + 1e-3),
            thread_ms=spread((1e3 * trace.thread).tolist()),
            step_ms=spread((1e3 * trace.step).tolist()),
            unusable=int(trace.unusable.sum()),
        )


def _seen(simulator: Simulator) -> Array:
    """Place of the cube and force of the fingers on it, upwards: (4,) [m, N]."""
    return np.append(simulator.effector_values, -force_of(simulator, 0)[2])
