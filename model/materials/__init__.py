"""Hyperelastic materials: laws, named silicones, and the kernels that evaluate them."""

from tauten.model.materials.densities import COROTATIONAL, N_CONSTANTS
from tauten.model.materials.evaluation import (
    EXACT,
    MATERIAL,
    NO_TANGENT,
    PROJECTED,
    WORK,
    response,
    stress,
    tangent_at,
)
from tauten.model.materials.law import (
    Law,
    MaterialError,
    corotational,
    lame_parameters,
    law_arrays,
    mooney_rivlin,
    neo_hookean,
    stable_neo_hookean,
    yeoh,
)
from tauten.model.materials.projection import symmetric_eigen
from tauten.model.materials.silicones import SILICONES, find_silicone
from tauten.model.materials.viscosity import ELASTIC, Viscosity

__all__ = [
    "COROTATIONAL",
    "ELASTIC",
    "EXACT",
    "MATERIAL",
    "N_CONSTANTS",
    "Law",
    "MaterialError",
    "NO_TANGENT",
    "PROJECTED",
    "SILICONES",
    "Viscosity",
    "WORK",
    "corotational",
    "find_silicone",
    "lame_parameters",
    "law_arrays",
    "mooney_rivlin",
    "neo_hookean",
    "response",
    "stable_neo_hookean",
    "stress",
    "symmetric_eigen",
    "tangent_at",
    "yeoh",
]
