"""The file of a robot of several parts, each of which has a robot file of its own."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Self

from pydantic import Field, model_validator

from tauten.model.schema.body import RotationSettings
from tauten.model.schema.cable import CouplingSettings
from tauten.model.schema.contact import (
    ContactRange,
    ObstacleSettings,
    Points,
    Spacing,
    TouchSettings,
    check_forces,
    check_pairs,
    one_way_to_place_points,
)
from tauten.model.schema.digest import by_content, joined_digest
from tauten.model.schema.robot_file import ControlPeriod, NamedRobot
from tauten.model.schema.section import Name, Point, Section, check_unique


class PartSettings(Section):
    """A part of a robot: a robot file, and where its frame stands."""

    name: Name = Field(
        description="Name of the part, used once. Its actuators and effectors are called by it and their own "
        "names: part_actuator."
    )
    robot: str = Field(
        description="Robot file of the part, beside this one, or name of a shipped robot. It has its own "
        "bases, scheme and damping; gravity and control rate are those of this file."
    )
    rotation: RotationSettings | None = Field(
        default=None, description="Rotation about the origin of the part's frame; by default none."
    )
    position: Point = Field(
        default=(0.0, 0.0, 0.0),
        description="Where the origin of the part's frame stands [m], by default in this robot's origin.",
    )


class PartSurfaceSettings(Section):
    """A surface of a part."""

    part: Name = Field(description="Name of the part.")
    surface: Name | None = Field(
        default=None,
        description="Name of a surface or region of the part's file; by default the whole surface.",
    )

    @property
    def name(self) -> str:
        """What it is called in messages."""
        return f"{self.part}.{self.surface or 'skin'}"


class PartContactSettings(TouchSettings):
    """Candidate points spread over a surface of one part against another part or an obstacle."""

    candidates: PartSurfaceSettings = Field(
        description="Surface that the candidates are spread over."
    )
    against: PartSurfaceSettings | Name = Field(
        description="Surface of another part, or name of an obstacle, that they may touch."
    )
    points: Points = None
    spacing: Spacing = None

    @model_validator(mode="after")
    def _points_once(self) -> PartContactSettings:
        one_way_to_place_points(self.points, self.spacing)
        return self

    @property
    def name(self) -> str:
        """What the pair is called in messages."""
        against = self.against
        return f"{self.candidates.name} on {against if isinstance(against, str) else against.name}"


class PartsConfig(NamedRobot):
    """The file of a robot of several parts; they act on each other by contact."""

    parts: Annotated[list[PartSettings], Field(min_length=1)] = Field(
        description="The parts, one table each."
    )
    couplings: tuple[CouplingSettings, ...] = Field(
        default=(),
        description="Motors that drive actuators of several parts, which are called part_actuator, one table "
        "each; by default none.",
    )
    contacts: tuple[PartContactSettings, ...] = Field(
        default=(),
        description="What may touch beside the contacts that each part has within itself, one table each; "
        "by default nothing.",
    )
    obstacles: tuple[ObstacleSettings, ...] = Field(
        default=(), description="Shapes that the robot may touch, one table each; by default none."
    )
    contact: ContactRange = Field(
        default=ContactRange(),
        description="Distances of contact handling, by default those of the parts.",
    )
    controller: ControlPeriod = Field(
        default=ControlPeriod(), description="Control rate and inverse control."
    )

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        touching = [(one, one.against) for one in self.contacts]
        check_forces(touching, self.obstacles, self.contact)
        check_pairs([one.name for one in self.contacts])
        check_unique("parts", [part.name for part in self.parts])
        check_unique("obstacles", [one.name for one in self.obstacles])
        both = [*(part.name for part in self.parts), *(one.name for one in self.obstacles)]
        check_unique("parts and obstacles", both)
        for index, motor in enumerate(self.couplings):
            if motor.kind == "drum" or motor.pretensions is not None:
                raise ValueError(
                    f"couplings.{index}: drums and pretensions stand in the file of a part; a motor of "
                    "several parts is a differential without them"
                )
        parts = {part.name for part in self.parts}
        obstacles = {one.name for one in self.obstacles}
        for index, contact in enumerate(self.contacts):
            for field in ("candidates", "against"):
                side = getattr(contact, field)
                if isinstance(side, str):
                    known, name = obstacles, side
                else:
                    known, name = parts, side.part
                if name not in known:
                    what = "obstacle" if isinstance(side, str) else "part"
                    raise ValueError(
                        f"contacts.{index}.{field}: there is no {what} {name!r}, known are "
                        f"{', '.join(sorted(known)) or 'none'}"
                    )
            if (
                not isinstance(contact.against, str)
                and contact.against.part == contact.candidates.part
            ):
                raise ValueError(
                    f"contacts.{index}: both surfaces belong to part {contact.against.part!r}; contact "
                    "within a part stands in the file of the part"
                )
        return self


def parts_digest(
    config: PartsConfig,
    parts: Sequence[str],
    surfaces: Sequence[Sequence[int]],
    members: Sequence[Sequence[int]],
    folder: Path,
) -> str:
    """The digest of a robot of several parts: what its contact forces depend on; names do not count.

    It takes the digests of the parts, numbers of the vertices that touch of each part and of the triangles of
    each contact, and the members of each coupling by their numbers among the actuators of all parts. The
    content of files in the folder that obstacles name counts.
    """
    places = [part.model_dump(exclude={"robot", "name"}) for part in config.parts]
    used = [item.against for item in config.contacts if isinstance(item.against, str)]
    obstacles = {
        one.name: one.model_dump(exclude={"name"})
        | {"stream": None, "parameters": by_content(one.parameters, folder)}
        for one in config.obstacles
        if one.name in used
    }
    touching = [
        [
            item.spacing or item.points,
            obstacles.get(item.against) if isinstance(item.against, str) else None,
        ]
        for item in config.contacts
    ]
    motors = [[item.gains, list(ids)] for item, ids in zip(config.couplings, members, strict=True)]
    apart = [
        places,
        touching,
        surfaces,
        config.contact.model_dump(exclude={"tolerance", "max_force"}),
    ]
    return joined_digest(parts, json.dumps(motors) if motors else "", json.dumps(apart))
