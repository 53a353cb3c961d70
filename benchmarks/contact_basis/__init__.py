"""Errors of contact bases on and off their training path."""

from benchmarks.contact_basis.results import ContactBasisBench, HeldOutError, TrainingError
from benchmarks.contact_basis.study import ContactBasisInputs, bench_contact_basis

__all__ = [
    "ContactBasisBench",
    "ContactBasisInputs",
    "HeldOutError",
    "TrainingError",
    "bench_contact_basis",
]
