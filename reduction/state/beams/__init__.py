"""Reduced robots made of beams: modes of natural strains."""

from tauten.reduction.state.beams.reduction import ReducibleBeams
from tauten.reduction.state.beams.strain_body import StrainBody

__all__ = ["ReducibleBeams", "StrainBody"]
