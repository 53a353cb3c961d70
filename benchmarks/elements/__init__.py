"""Times and errors of elements and materials."""

from benchmarks.elements.study import (
    ElementBench,
    ElementBenchSettings,
    ElementCase,
    ElementEquilibrium,
    ElementVariant,
    bench_elements,
    load_variant,
    parse_material,
)

__all__ = [
    "ElementBench",
    "ElementBenchSettings",
    "ElementCase",
    "ElementEquilibrium",
    "ElementVariant",
    "bench_elements",
    "load_variant",
    "parse_material",
]
