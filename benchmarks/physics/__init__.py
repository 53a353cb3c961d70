"""Benchmarks of the mechanics: energy of time steps, equilibria from any start."""

from benchmarks.physics.energy import EnergyBench, EnergySettings, bench_energy
from benchmarks.physics.equilibria import EquilibriaBench, EquilibriaSettings, bench_equilibria
from benchmarks.physics.sofa_robots import TRUNK_CABLES, diamond, finger, trunk

__all__ = [
    "EnergyBench",
    "EnergySettings",
    "EquilibriaBench",
    "EquilibriaSettings",
    "TRUNK_CABLES",
    "bench_energy",
    "bench_equilibria",
    "diamond",
    "finger",
    "trunk",
]
