"""Simulation of a robot: time steps, equilibria and their stability."""

from tauten.model.simulation.converged_step import Stepped
from tauten.model.simulation.equilibrium import Ending, Report
from tauten.model.simulation.simulator import Simulator

__all__ = ["Ending", "Report", "Simulator", "Stepped"]
