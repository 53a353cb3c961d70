"""Contact problems with friction that others wrote, inverse problems, and how they are solved."""

from benchmarks.friction.drift import DriftRun, drift
from benchmarks.friction.inverse import (
    CUTS,
    InverseFrictionBench,
    InverseRun,
    bench_friction_inverse,
    frictionless_difference,
    inverse_run,
)
from benchmarks.friction.modes import (
    SharedModesBench,
    bench_shared_modes,
    shared_modes_case,
)
from benchmarks.friction.pressed import PressedRun
from benchmarks.friction.published import FrictionBench, bench_friction, read_problem
from benchmarks.friction.stored import read_inverse, solve_stored, violation

__all__ = [
    "CUTS",
    "DriftRun",
    "FrictionBench",
    "InverseFrictionBench",
    "InverseRun",
    "PressedRun",
    "SharedModesBench",
    "bench_friction",
    "bench_friction_inverse",
    "bench_shared_modes",
    "drift",
    "frictionless_difference",
    "inverse_run",
    "read_inverse",
    "read_problem",
    "shared_modes_case",
    "solve_stored",
    "violation",
]
