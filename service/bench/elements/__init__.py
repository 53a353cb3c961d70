"""Times and errors of elements and materials."""

from tauten.service.bench.elements.study import (
    ElementBench,
    ElementBenchSettings,
    ElementCase,
    ElementEquilibrium,
    bench_elements,
    parse_law,
)

__all__ = [
    "ElementBench",
    "ElementBenchSettings",
    "ElementCase",
    "ElementEquilibrium",
    "bench_elements",
    "parse_law",
]
