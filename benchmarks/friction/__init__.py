"""Contact problems with friction that others wrote, and how they are solved."""

from benchmarks.friction.published import FrictionBench, bench_friction, read_problem

__all__ = ["FrictionBench", "bench_friction", "read_problem"]
