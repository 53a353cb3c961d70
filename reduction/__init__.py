"""Positive bases of contact forces: smaller problems, same equations."""

from tauten.reduction.contact.basis import BasisError, ContactBasis
from tauten.reduction.contact.positive_basis import (
    METHODS,
    Method,
    PositiveFactorisation,
    factorise,
)
from tauten.reduction.provenance import CurvePoint, Provenance, versions
from tauten.reduction.storage import DamagedFile

__all__ = [
    "BasisError",
    "ContactBasis",
    "CurvePoint",
    "DamagedFile",
    "METHODS",
    "Method",
    "PositiveFactorisation",
    "Provenance",
    "factorise",
    "versions",
]
