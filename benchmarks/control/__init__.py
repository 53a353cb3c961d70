"""Controllers under test: models of contact in open and closed loop, random orders."""

from benchmarks.control.bench import CaseRunner, CaseRuns, ContactLoops, bench_cases, planned
from benchmarks.control.orders import OrderBench, bench_orders
from benchmarks.control.outcome import Outcome
from benchmarks.control.targets import CASES, Case, make_cases

__all__ = [
    "CASES",
    "Case",
    "CaseRunner",
    "CaseRuns",
    "ContactLoops",
    "OrderBench",
    "Outcome",
    "bench_cases",
    "bench_orders",
    "make_cases",
    "planned",
]
