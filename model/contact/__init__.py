"""Contact: from surfaces to gap rows."""

from tauten.model.contact.broad_phase import BLOCK
from tauten.model.contact.detection import (
    ContactPair,
    ContactSet,
    blocks_of,
    contact_rows,
)
from tauten.model.contact.self_contact import (
    ALARM_EDGES,
    EDGES_AWAY,
    WALL_ALARMS,
    mean_edge,
    neighbours_at_rest,
)
from tauten.model.contact.shapes import SHAPES, DrawnShape, Shape

__all__ = [
    "ALARM_EDGES",
    "BLOCK",
    "ContactPair",
    "ContactSet",
    "DrawnShape",
    "EDGES_AWAY",
    "SHAPES",
    "Shape",
    "WALL_ALARMS",
    "blocks_of",
    "contact_rows",
    "mean_edge",
    "neighbours_at_rest",
]
