"""What elements and materials cost and how far they err."""

from tauten.service.bench.elements.study import (
    ElementBench,
    ElementBenchSettings,
    Equilibrium,
    MeshCase,
    bench_elements,
    parse_law,
)

__all__ = [
    "ElementBench",
    "ElementBenchSettings",
    "Equilibrium",
    "MeshCase",
    "bench_elements",
    "parse_law",
]
