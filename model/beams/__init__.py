"""Bodies made of beams."""

from tauten.model.beams.beams import BeamError, Beams, make_beams
from tauten.model.beams.body import BeamBody
from tauten.model.beams.elements import (
    BeamArrays,
    assemble_beams,
    bent_shares,
    element,
    offset_slopes,
    stretch_functions,
    turn_functions,
)
from tauten.model.beams.helix import (
    along_helix,
    chord_change,
    first_derivatives,
    helix_functions,
    second_derivatives,
)
from tauten.model.beams.motion import follow, strained_length, unit_vector
from tauten.model.beams.profile import Material, Profile, bar, natural_stiffness, section, tube
from tauten.model.beams.surfaces import BeamSurfaces, chain_surface, outline
from tauten.model.beams.tree import BeamLoopError, BeamTree, make_tree

__all__ = [
    "BeamArrays",
    "BeamBody",
    "BeamError",
    "BeamLoopError",
    "BeamSurfaces",
    "BeamTree",
    "Beams",
    "Material",
    "Profile",
    "along_helix",
    "assemble_beams",
    "bar",
    "bent_shares",
    "chain_surface",
    "chord_change",
    "element",
    "first_derivatives",
    "follow",
    "helix_functions",
    "make_beams",
    "make_tree",
    "natural_stiffness",
    "offset_slopes",
    "outline",
    "second_derivatives",
    "section",
    "strained_length",
    "stretch_functions",
    "tube",
    "turn_functions",
    "unit_vector",
]
