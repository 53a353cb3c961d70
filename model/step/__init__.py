"""One step: its linear system condensed to the rows, and solved forward."""

from tauten.model.step.compliance import Compliance, row_compliance, static_compliance
from tauten.model.step.condensed_step import (
    CondensedStep,
    condense_step,
    condensed,
    recondensed,
)
from tauten.model.step.contact_space import ContactSpace, EmptySpace, ReducedContacts
from tauten.model.step.enrichment import (
    NO_ENRICHMENT,
    Enrichment,
    PredictedStep,
    contact_model,
    default_enrichment,
    predict,
    worst_rows,
)
from tauten.model.step.force_limits import ForceLimits, Grasp, force_limits
from tauten.model.step.forces import Forces, TangentialForces, no_forces
from tauten.model.step.forward_step import eliminate_rows, forward_step, known_forces
from tauten.model.step.friction_law import (
    step_certificate,
    under_friction,
    unit_start,
)
from tauten.model.step.sorted_rows import sorted_rows

__all__ = [
    "Compliance",
    "CondensedStep",
    "ContactSpace",
    "EmptySpace",
    "Enrichment",
    "ForceLimits",
    "Grasp",
    "Forces",
    "NO_ENRICHMENT",
    "PredictedStep",
    "ReducedContacts",
    "TangentialForces",
    "condense_step",
    "condensed",
    "contact_model",
    "default_enrichment",
    "eliminate_rows",
    "force_limits",
    "forward_step",
    "known_forces",
    "no_forces",
    "predict",
    "recondensed",
    "row_compliance",
    "sorted_rows",
    "static_compliance",
    "step_certificate",
    "under_friction",
    "unit_start",
    "worst_rows",
]
