"""Bases of contact forces and states from simulated equilibria, and the files that hold them."""

from tauten.reduction.contact.basis import BasisError, ContactBasis
from tauten.reduction.contact.positive_basis import factorise
from tauten.reduction.provenance import (
    CurvePoint,
    Provenance,
    package_version,
    package_versions,
    source_version,
)
from tauten.reduction.storage import DamagedFile
from tauten.reduction.whole_writes import atomic_write, write_text

__all__ = [
    "atomic_write",
    "BasisError",
    "ContactBasis",
    "CurvePoint",
    "DamagedFile",
    "Provenance",
    "factorise",
    "package_version",
    "package_versions",
    "source_version",
    "write_text",
]
