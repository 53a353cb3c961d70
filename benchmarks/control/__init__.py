"""Controllers under test: models of contact in open and closed loop."""

from benchmarks.control.bench import CaseRunner, CaseRuns, ContactLoops, bench_cases, planned
from benchmarks.control.outcome import Outcome
from benchmarks.control.targets import CASES, Case, make_cases

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
