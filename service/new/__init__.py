"""From a part of CAD to a robot file: surface checks, tetrahedra, guesses of the fields."""

from tauten.service.new.choice import Trial
from tauten.service.new.edits import TENSION, NewCable, add_cable, fields_text, set_fields
from tauten.service.new.make import Made, NewRobot, make_new_robot
from tauten.service.new.meshing import LARGE, CadPart, read_part
from tauten.service.new.part import PartError

__all__ = [
    "LARGE",
    "Made",
    "NewCable",
    "NewRobot",
    "CadPart",
    "PartError",
    "TENSION",
    "Trial",
    "add_cable",
    "fields_text",
    "make_new_robot",
    "read_part",
    "set_fields",
]
