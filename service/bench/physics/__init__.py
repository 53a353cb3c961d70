"""Benchmarks of the mechanics: energy of time steps, equilibria from any start, rest at constant targets."""

from tauten.service.bench.physics.energy import (
    EnergyBench,
    EnergyCourse,
    EnergySettings,
    PathDistance,
    StepCost,
    bench_energy,
)
from tauten.service.bench.physics.equilibria import (
    EquilibriaBench,
    EquilibriaSettings,
    EquilibriumGroup,
    bench_equilibria,
)
from tauten.service.bench.physics.sofa_robots import TRUNK_CABLES, diamond, finger, trunk
from tauten.service.bench.physics.still import (
    OrderRun,
    StillBench,
    StillRun,
    StillSettings,
    bench_still,
)

__all__ = [
    "EnergyBench",
    "EnergyCourse",
    "EnergySettings",
    "EquilibriaBench",
    "EquilibriaSettings",
    "EquilibriumGroup",
    "PathDistance",
    "StepCost",
    "OrderRun",
    "StillBench",
    "StillRun",
    "StillSettings",
    "TRUNK_CABLES",
    "bench_energy",
    "bench_equilibria",
    "bench_still",
    "diamond",
    "finger",
    "trunk",
]
