"""Controllers under test: models of contact in open and closed loop, rest at constant targets."""

from benchmarks.control.bench import CaseRunner, CaseRuns, ContactLoops, bench_cases, planned
from benchmarks.control.contact import ContactBench, bench_contact
from benchmarks.control.lift import WRONG, LiftBench, LiftRun, ReserveRun
from benchmarks.control.outcome import Outcome
from benchmarks.control.still import StillBench, StillRun, StillSettings, bench_still
from benchmarks.control.targets import CASES, Case, make_cases
from benchmarks.control.wall import WallBench

__all__ = [
    "CASES",
    "Case",
    "CaseRunner",
    "CaseRuns",
    "ContactBench",
    "ContactLoops",
    "LiftBench",
    "LiftRun",
    "Outcome",
    "ReserveRun",
    "WRONG",
    "StillBench",
    "StillRun",
    "StillSettings",
    "WallBench",
    "bench_cases",
    "bench_contact",
    "bench_still",
    "make_cases",
    "planned",
]
