"""From a part of CAD to a robot file: surface checks, tetrahedra, guesses of the fields."""

from tauten.service.new.make import Made, NewRobot, Trial, elements_needed, make_new_robot
from tauten.service.new.meshing import LARGE
from tauten.service.new.part import PartError

__all__ = ["LARGE", "Made", "NewRobot", "PartError", "Trial", "elements_needed", "make_new_robot"]
