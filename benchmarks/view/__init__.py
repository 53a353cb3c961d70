"""What the viewer costs."""

from benchmarks.view.cost import ViewCost, simulation_cost

__all__ = ["ViewCost", "simulation_cost"]
