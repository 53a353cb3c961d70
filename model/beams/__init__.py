"""Robots made of beams."""

from tauten.model.beams.body import BeamBody, BeamError, make_body
from tauten.model.beams.elements import (
    BeamArrays,
    assemble_beams,
    element,
    stretch_change,
    stretch_functions,
    stretched,
    turn_functions,
)
from tauten.model.beams.gaps import gap_arrays
from tauten.model.beams.profile import Profile, bar, natural_stiffness, section, tube
from tauten.model.beams.robot import BeamRobot
from tauten.model.beams.surfaces import BeamSurfaces, build_beam_surfaces, outline

__all__ = [
    "BeamArrays",
    "BeamBody",
    "BeamError",
    "BeamRobot",
    "BeamSurfaces",
    "Profile",
    "assemble_beams",
    "bar",
    "build_beam_surfaces",
    "element",
    "gap_arrays",
    "make_body",
    "natural_stiffness",
    "outline",
    "section",
    "stretch_change",
    "stretch_functions",
    "stretched",
    "tube",
    "turn_functions",
]
