"""Errors of contact bases on and off their training path."""

from benchmarks.contact_basis.gauss_seidel import solve_pgs
from benchmarks.contact_basis.held_out import FORCES, held_out_design, sensitivity
from benchmarks.contact_basis.results import ContactBasisBench, HeldOutError, TrainingError
from benchmarks.contact_basis.study import ContactBasisInputs, bench_contact_basis

__all__ = [
    "FORCES",
    "held_out_design",
    "sensitivity",
    "solve_pgs",
    "ContactBasisBench",
    "ContactBasisInputs",
    "HeldOutError",
    "TrainingError",
    "bench_contact_basis",
]
