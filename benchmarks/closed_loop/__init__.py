"""Closed loops: controllers with models of contact against robots as modelled, softer and stiffer."""

from benchmarks.closed_loop.bench import CaseRunner, CaseRuns, ContactLoops, bench_cases, planned
from benchmarks.closed_loop.outcome import Outcome
from benchmarks.closed_loop.targets import CASES, Case, make_cases

__all__ = [
    "CASES",
    "Case",
    "CaseRunner",
    "CaseRuns",
    "ContactLoops",
    "Outcome",
    "bench_cases",
    "make_cases",
    "planned",
]
