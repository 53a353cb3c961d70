"""How much a decision holds back, adapted from step to step."""

from tauten.controller.damping.damping import TICK, Damping, Dampings, adapted, undamped
from tauten.controller.damping.objective import Energy, Objective

__all__ = ["TICK", "Damping", "Dampings", "Energy", "Objective", "adapted", "undamped"]
