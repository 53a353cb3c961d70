"""Compiled kernels that are shipped: what they serve on this machine, and how they are packed."""

from tauten.service.kernels.first_hour import SEEDED, FirstHour, first_demos
from tauten.service.kernels.inventory import PackError, take_inventory
from tauten.service.kernels.pack import LARGEST, pack_kernels

__all__ = [
    "FirstHour",
    "LARGEST",
    "PackError",
    "SEEDED",
    "first_demos",
    "pack_kernels",
    "take_inventory",
]
