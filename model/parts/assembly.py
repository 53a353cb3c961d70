"""What makes one robot of parts, beside the parts."""

from __future__ import annotations

from dataclasses import dataclass

from tauten.model.contact import ContactPair
from tauten.model.numerics import Array, Ints
from tauten.model.schema import CouplingSettings


@dataclass(frozen=True, slots=True, eq=False)
class Between:
    """Contact between parts.

    Attributes:
        vertices: (v,) vertices of the surfaces of each part that touch another, by their numbers in the part.
        pairs: over these vertices, those of one part after those of the other.
    """

    vertices: tuple[Ints, ...]
    pairs: tuple[ContactPair, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Assembly:
    """What makes one robot of parts.

    Attributes:
        name: of the robot.
        frame: frame id of its positions.
        digest: what its contact forces depend on.
        gravity: (3,) in its frame [m/s²].
        tolerance: depth of penetration from which a unit column is added [m].
        alarm_distance: largest distance of contact that is reported [m].
        distance: at which surfaces are held from each other [m].
        between: contact between parts.
        couplings: motors that drive actuators of several parts, which have the names of these.
        max_force: sum of the normal forces of all contacts that decisions keep at most [N]; None: any.
    """

    name: str
    frame: str
    digest: str
    gravity: Array
    tolerance: float
    alarm_distance: float
    distance: float
    between: Between
    couplings: tuple[CouplingSettings, ...] = ()
    max_force: float | None = None
