"""Simulation of a robot: time steps, equilibria and their stability, ranges of its actuators."""

from tauten.model.simulation.command_range import CommandRange, command_range
from tauten.model.simulation.converged_step import Stepped
from tauten.model.simulation.equilibrium import Ending, Report
from tauten.model.simulation.simulator import Simulator

__all__ = ["CommandRange", "Ending", "Report", "Simulator", "Stepped", "command_range"]
