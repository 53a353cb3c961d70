"""Kernels that are shipped compiled: how they are packed, and what README's first command still compiles."""

from benchmarks.kernels.first_hour import SEEDED, FirstHour, first_demos
from benchmarks.kernels.pack import LARGEST, PackError, pack_kernels

__all__ = [
    "FirstHour",
    "LARGEST",
    "PackError",
    "SEEDED",
    "first_demos",
    "pack_kernels",
]
