"""Benchmark of rest at constant targets, and of random orders."""

from benchmarks.rest.orders import OrderRun, order_run
from benchmarks.rest.still import StillBench, StillRun, StillSettings, bench_still

__all__ = ["OrderRun", "StillBench", "StillRun", "StillSettings", "bench_still", "order_run"]
