"""Bases of contact forces, λ_c = Ψ β, and their errors."""

from tauten.reduction.contact.basis import SUFFIX, BasisError, ContactBasis, coverage
from tauten.reduction.contact.energy import energy_error, refine
from tauten.reduction.contact.fit import (
    BasisMethod,
    BasisQuality,
    Fit,
    Weighting,
    fit_each,
    quality,
    snapshot_weights,
)
from tauten.reduction.contact.mode_count import ChoiceError, Curve, choose_k, cross_validate, folds
from tauten.reduction.contact.nnmf import leading_part
from tauten.reduction.contact.parts import joined_basis
from tauten.reduction.contact.positive_basis import METHODS, Method, factorise, factorise_each
from tauten.reduction.contact.problems import ContactProblem, contact_problems
from tauten.reduction.contact.reduce import (
    ReduceSettings,
    Reduction,
    make_basis,
    provenance,
    reduce_robot,
    reduce_snapshots,
)
from tauten.reduction.contact.tip_error import TipErrors, snapshot_values, tip_errors

__all__ = [
    "BasisError",
    "BasisMethod",
    "BasisQuality",
    "ChoiceError",
    "ContactBasis",
    "ContactProblem",
    "Curve",
    "Fit",
    "METHODS",
    "Method",
    "ReduceSettings",
    "Reduction",
    "SUFFIX",
    "TipErrors",
    "Weighting",
    "choose_k",
    "contact_problems",
    "coverage",
    "cross_validate",
    "energy_error",
    "factorise",
    "factorise_each",
    "fit_each",
    "folds",
    "joined_basis",
    "leading_part",
    "make_basis",
    "provenance",
    "quality",
    "reduce_robot",
    "reduce_snapshots",
    "refine",
    "snapshot_values",
    "snapshot_weights",
    "tip_errors",
]
