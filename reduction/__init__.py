"""Positive bases of contact forces: smaller problems, same equations."""

from tauten.reduction.contact_basis import BasisError, ContactBasis
from tauten.reduction.positive_basis import METHODS, Factorisation, Method, factorise
from tauten.reduction.provenance import Provenance

__all__ = [
    "METHODS",
    "BasisError",
    "ContactBasis",
    "Factorisation",
    "Method",
    "Provenance",
    "factorise",
]
