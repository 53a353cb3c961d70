"""Robots of several parts, each with unknowns, forces and bases of its own."""

from tauten.model.parts.body import PartsBody
from tauten.model.parts.join import join_parts
from tauten.model.parts.motion import PartsPoints
from tauten.model.parts.part import Assembly, Between, Part, Placement
from tauten.model.parts.spans import joined_state

__all__ = [
    "Assembly",
    "Between",
    "Part",
    "PartsBody",
    "PartsPoints",
    "Placement",
    "join_parts",
    "joined_state",
]
