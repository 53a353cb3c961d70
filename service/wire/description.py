"""The description of a robot: one record for the wire, for logs and their replay, for streams and the viewer.

`tauten.service.describing.describe` makes it from a robot. As JSON it is the answer to a question on the
robot's key `description`, and, without the surface, an entry of a log's metadata. What is read is checked
before it is used: by `read_description` from the wire, by `tauten.service.log.logged_description` from logs.
"""

from __future__ import annotations

import itertools
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    SerializerFunctionWrapHandler,
    ValidationError,
    computed_field,
    field_validator,
    model_serializer,
    model_validator,
)

from tauten.model import ROWS, VALUES, ActuatorKind
from tauten.model.contact import RodOutline
from tauten.model.numerics import Array, Bools, Ints
from tauten.model.schema import EffectorKind, Name
from tauten.service.codec import (
    CLOUD,
    FARTHEST,
    HEALTH,
    JOINTS,
    TEXT,
    TICK,
    CodedNumbers,
    CodedPoints,
)
from tauten.service.link import Keys, NetworkError
from tauten.service.wire.effector_messages import MESSAGE_TYPES

_Limits = tuple[float, float]
_Number = Annotated[float, Field(allow_inf_nan=False)]
_Weight = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
_Acceleration = Annotated[float, Field(ge=-1e3, le=1e3, allow_inf_nan=False)]
_Name = Annotated[Name, Field(max_length=100)]  # as robot files may have it
_Text = Annotated[str, Field(max_length=1000)]
_MAX_RATE = 1e4  # Hz, as robot files allow it


class _Described(BaseModel):
    """A part of the description; further entries are for others."""

    model_config = ConfigDict(frozen=True, extra="ignore")


class DescribedActuator(_Described):
    """An actuator: limits of its position, of its effort and of its rate [SI]."""

    name: _Name
    kind: ActuatorKind
    effort: _Limits
    position: _Limits
    rate: float
    flexibility: Annotated[float, Field(ge=0.0, allow_inf_nan=False)]

    @computed_field  # type: ignore[prop-decorator]
    @property
    def units(self) -> dict[str, str]:
        """Of effort and position."""
        return {"effort": self.kind.effort.unit, "position": self.kind.position.unit}


class DescribedEffector(_Described):
    """An effector, its goal values where the model starts, and whether a row is to be met exactly."""

    name: _Name
    kind: EffectorKind
    weight: Annotated[tuple[_Weight, ...], Field(max_length=6)]
    rest: Annotated[tuple[_Number, ...], Field(max_length=7)]
    exact: bool

    @field_validator("weight")
    @classmethod
    def _has_its_weights(cls, weight: tuple[float, ...], info: Any) -> tuple[float, ...]:
        kind = info.data.get("kind")
        if kind is not None and len(weight) != ROWS[kind]:
            raise ValueError(f"a {kind} has {ROWS[kind]} weights, found {len(weight)}")
        return weight

    @model_validator(mode="after")
    def _has_its_values(self) -> Self:
        if len(self.rest) != VALUES[self.kind]:
            raise ValueError(
                f"a {self.kind} has {VALUES[self.kind]} values, found {len(self.rest)}"
            )
        return self

    @property
    def has_position(self) -> bool:
        """Whether its values begin with a position; distances, lengths and volumes are one number."""
        return VALUES[self.kind] >= 3

    @property
    def turns(self) -> bool:
        """Whether its values end with a quaternion."""
        return self.kind == "frame"

    @property
    def wanted(self) -> Bools:
        """(3,) which coordinates of its position have a goal, (1,) for one number."""
        wanted: Bools = np.array(self.weight[:3]) > 0.0
        return wanted


class DescribedModel(_Described):
    """The model that decides: digests of its robot and of its state basis, "" without one."""

    order: Literal["full", "reduced"]
    digest: _Text
    states: _Text = ""
    factorisation: _Text
    mesh_error: _Text
    nodes: int | None = None
    elements: int | None = None
    unknowns: int | None = None
    candidates: int | None = None


class DescribedBasis(_Described):
    """The contact basis: "none", "full", its name or its file; digest of its modes, "" without any."""

    name: _Text
    digest: _Text
    modes: int = 0


class RunDescription(_Described):
    """What a log says of the robot of its run: its description without the surface.

    Attributes:
        name: of the robot.
        frame: frame id of its positions.
        rate: control rate [Hz].
        start: whether the model starts from the equilibrium under its loads with the actuators at rest, or
            undeformed, from rest.
        size: largest distance between two of its nodes at rest [m].
        gravity: (3,) acceleration of gravity [m/s²].
        target_timeout: time without target after which its node holds [s].
        actuators: in the order of λ_a.
        effectors: in the order of their goal values.
        model: that decides.
        basis: of contacts.
        versions: of system, Python and the packages that compute.
    """

    name: _Name = Field(alias="robot")
    frame: _Name
    rate: Annotated[float, Field(gt=0.0, le=_MAX_RATE)]
    start: Literal["settled", "rest"]
    size: Annotated[float, Field(gt=0.0, le=1e3)]
    gravity: tuple[_Acceleration, _Acceleration, _Acceleration]
    target_timeout: Annotated[float, Field(gt=0.0)]
    actuators: Annotated[tuple[DescribedActuator, ...], Field(max_length=1000)]
    effectors: Annotated[tuple[DescribedEffector, ...], Field(min_length=1, max_length=1000)]
    model: DescribedModel
    basis: DescribedBasis
    versions: dict[_Text, _Text]


class DescribedRod(_Described):
    """A round obstacle in its frame, see `RodOutline`: many would be too large with their triangles."""

    start: tuple[_Number, _Number, _Number]
    along: tuple[_Number, _Number, _Number]
    radius: Annotated[float, Field(gt=0.0, le=FARTHEST)]
    flat: bool = False


class DescribedObstacle(_Described):
    """What the robot may touch, with its surface.

    Attributes:
        name: of the obstacle.
        position: of the origin of its frame at the start [m].
        quaternion: w, x, y, z of the rotation of its frame at the start.
        rod: a round one; it has no vertices then.
        vertices: (v, 3) of its surface in its frame [m].
        triangles: (t, 3) of them.
    """

    name: _Name
    position: tuple[_Number, _Number, _Number] = (0.0, 0.0, 0.0)
    quaternion: tuple[_Number, _Number, _Number, _Number] = (1.0, 0.0, 0.0, 0.0)
    rod: DescribedRod | None = None
    vertices: Annotated[Array, CodedPoints()] = Field(default_factory=lambda: np.zeros((0, 3)))
    triangles: Annotated[Ints, CodedNumbers(columns=3)] = Field(
        default_factory=lambda: np.zeros((0, 3), np.int64)
    )

    @property
    def outline(self) -> tuple[Array, Ints]:
        """Vertices (v, 3) [m] and triangles (t, 3) of its surface."""
        one = self.rod
        if one is None:
            return self.vertices, self.triangles
        ends = np.array(one.start), np.array(one.along)
        return RodOutline(*ends, one.radius, one.flat and bool(ends[1].any())).triangles()

    @field_validator("triangles")
    @classmethod
    def _joins_its_vertices(cls, triangles: Ints, info: Any) -> Ints:
        count = len(info.data.get("vertices", ()))
        if triangles.max(initial=-1) >= count:
            raise ValueError(f"names number {triangles.max()} of {count}")
        return triangles


class DescribedSurface(_Described):
    """The skin, and what stands still around it.

    Attributes:
        vertices: their number, P.
        triangles: (t, 3) of the vertices.
        segments: (s,) the actuator of every segment, see `Robot.actuator_segments`.
        chambers: (t,) the actuator whose chamber a triangle encloses; −1: none.
        held: (m,) the vertices that never move: the base.
        obstacles: that the robot may touch.
        pairs: names of the contact pairs, in the order of their numbers.
        friction: their coefficients; none where a node does not say them.
        objects: (o,) the triangles of objects: of parts without an actuator.
    """

    vertices: Annotated[int, Field(ge=3)]
    triangles: Annotated[Ints, CodedNumbers(columns=3)]
    segments: Annotated[Ints, CodedNumbers()]
    chambers: Annotated[Ints, CodedNumbers(first=-1)]
    held: Annotated[Ints, CodedNumbers()]
    obstacles: Annotated[tuple[DescribedObstacle, ...], Field(max_length=1000)]
    pairs: Annotated[tuple[_Text, ...], Field(max_length=10_000)] = ()
    friction: Annotated[tuple[_Number, ...], Field(max_length=10_000)] = ()
    objects: Annotated[Ints, CodedNumbers()] = Field(default_factory=lambda: np.zeros(0, np.intp))


class RobotDescription(RunDescription):
    """The description of a robot, with its surface."""

    surface: DescribedSurface

    @field_validator("surface")
    @classmethod
    def _is_whole(cls, surface: DescribedSurface, info: Any) -> DescribedSurface:
        """A surface whose numbers are those of vertices and actuators."""
        if "actuators" not in info.data:
            return surface
        count = len(info.data["actuators"])
        for numbers, below in (
            (surface.triangles, surface.vertices),
            (surface.segments, count),
            (surface.chambers, count),
            (surface.held, surface.vertices),
            (surface.objects, len(surface.triangles)),
        ):
            if numbers.max(initial=-1) >= below:
                raise ValueError(f"names number {numbers.max()} of {below}")
        if len(surface.triangles) != len(surface.chambers):
            raise ValueError(
                f"{len(surface.triangles)} triangles, chambers of {len(surface.chambers)}"
            )
        return surface

    @property
    def effector_names(self) -> tuple[str, ...]:
        """Names of the effectors."""
        return tuple(one.name for one in self.effectors)

    @property
    def rest(self) -> Array:
        """Goal values (n_v,) of the effectors where the model starts."""
        return np.concatenate([np.array(one.rest) for one in self.effectors])

    def as_json(self, surface: bool = True) -> str:
        """The description as JSON, with or without the surface, which is most of it."""
        return self.model_dump_json(
            by_alias=True, indent=1, exclude=None if surface else {"surface"}
        )

    @model_serializer(mode="wrap")
    def _with_keys(self, entries: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Keys and message types, for readers that do not know how they are made from names."""
        found: dict[str, Any] = entries(self)
        keys, names = Keys(self.name), self.effector_names
        for place, of_effectors in (
            ("target", keys.targets(names)),
            ("measurement", keys.measurements(names)),
            ("position", keys.effectors(names)),
        ):
            for one, key in zip(found["effectors"], of_effectors, strict=True):
                one[place] = key
        for one in found["effectors"]:
            one["type"] = MESSAGE_TYPES[one["kind"]]
        if "surface" in found:
            found["surface"] |= {"key": keys.surface, "contacts": keys.contacts, "type": CLOUD}
        found["keys"] = {
            "command": {"key": keys.command, "type": TEXT},
            "actuation": {"key": keys.actuation, "type": JOINTS},
            "tick": {"key": keys.tick, "type": TICK},
            "health": {"key": keys.health, "type": HEALTH},
        }
        return found


def places_of(effectors: tuple[DescribedEffector, ...]) -> list[slice]:
    """Where the goal values of each effector are among those of all."""
    ends = np.cumsum([0, *(VALUES[one.kind] for one in effectors)]).tolist()
    return [slice(first, end) for first, end in itertools.pairwise(ends)]


def read_description(robot: str, payload: bytes) -> RobotDescription:
    """The description in a node's answer.

    Raises:
        NetworkError: no description, that of another robot, or that of a node of another version.
    """
    try:
        found = RobotDescription.model_validate_json(payload)
    except ValidationError as error:
        raise NetworkError(
            f"the node of {robot!r} describes itself otherwise than this version does "
            f"({first_fault(error)}): start node and this command from the same version"
        ) from error
    if found.name != robot:
        raise NetworkError(f"the node of {robot!r} describes another robot, {found.name!r}")
    return found


def first_fault(error: ValidationError) -> str:
    """Place and reason of the first fault of a description, without what was found there."""
    first = error.errors(include_url=False, include_context=False, include_input=False)[0]
    place = ".".join(str(part) for part in first["loc"] if isinstance(part, int) or part in _PARTS)
    return f"{place}: {first['msg']}" if place else str(first["msg"])


_PARTS = frozenset(
    field.alias or name
    for record in (
        RobotDescription, DescribedActuator, DescribedEffector, DescribedSurface, DescribedObstacle,
        DescribedRod,
        DescribedModel, DescribedBasis,
    )
    for name, field in record.model_fields.items()
)  # fmt: skip
