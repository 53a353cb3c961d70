"""What the first hour with a shipped robot computes: its node's loop, and its plant, full and reduced."""

from __future__ import annotations

from tauten.controller import warm_controller
from tauten.model import one_blas_thread
from tauten.service.node import ControlLoop
from tauten.service.plant import PlantSettings, plant_robot, plant_setup, quick_enough, warm_plant
from tauten.service.setup import load_setup

# robots whose plant in full order is only tried, as the plant does
FULL_TAKES_MINUTES = ("manipulator",)


def run_robot(name: str) -> None:
    """Take the first steps with a shipped robot: its kernels are compiled or loaded."""
    with one_blas_thread():
        ControlLoop(warm_controller(load_setup(name)))
        for model in ("reduced", "full"):
            setup, _ = plant_setup(plant_robot(name, None, model), model)
            if model == "full" and name in FULL_TAKES_MINUTES:
                quick_enough(setup.robot)
                continue
            simulator = warm_plant(setup.robot, PlantSettings()).driven.simulator
            simulator.settle(position=0.25 * setup.robot.limits.farthest_position, tolerance=1e-4)
