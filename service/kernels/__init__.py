"""Compiled kernels that are shipped: what they serve on this machine, and how they are packed."""

from tauten.service.kernels.first_hour import COLD, SEEDED, WARM, FirstHour, first_demos
from tauten.service.kernels.inventory import Inventory, PackError, take_inventory
from tauten.service.kernels.pack import LARGEST, Packed, pack_kernels

__all__ = [
    "COLD",
    "FirstHour",
    "Inventory",
    "LARGEST",
    "PackError",
    "Packed",
    "SEEDED",
    "WARM",
    "first_demos",
    "pack_kernels",
    "take_inventory",
]
