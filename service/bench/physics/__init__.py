"""Benchmarks of the mechanics: energy of time steps, and equilibria from any start."""

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

__all__ = [
    "EnergyBench",
    "EnergyCourse",
    "EnergySettings",
    "EquilibriaBench",
    "EquilibriaSettings",
    "EquilibriumGroup",
    "PathDistance",
    "StepCost",
    "TRUNK_CABLES",
    "bench_energy",
    "bench_equilibria",
    "diamond",
    "finger",
    "trunk",
]
