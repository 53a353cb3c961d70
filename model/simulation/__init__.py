"""Simulation of a robot: time steps, equilibria and their stability."""

from tauten.model.simulation.balance import moves_far
from tauten.model.simulation.converged_step import gains_energy
from tauten.model.simulation.equilibrium import Ending, Report
from tauten.model.simulation.robot_model import RobotModel
from tauten.model.simulation.simulator import Simulator
from tauten.model.simulation.travel import Travel, travel

__all__ = [
    "Ending",
    "Report",
    "RobotModel",
    "Simulator",
    "Travel",
    "gains_energy",
    "moves_far",
    "travel",
]
