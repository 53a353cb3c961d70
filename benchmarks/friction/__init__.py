"""Contact problems with friction that others wrote, inverse problems, and how they are solved."""

from benchmarks.friction.inverse import (
    CUTS,
    InverseFrictionBench,
    InverseRun,
    bench_friction_inverse,
    frictionless_difference,
    inverse_run,
    read_inverse,
)
from benchmarks.friction.published import FrictionBench, bench_friction, read_problem

__all__ = [
    "CUTS",
    "FrictionBench",
    "InverseFrictionBench",
    "InverseRun",
    "bench_friction",
    "bench_friction_inverse",
    "frictionless_difference",
    "inverse_run",
    "read_inverse",
    "read_problem",
]
