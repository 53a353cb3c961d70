"""Rigid regions, drives and attachments of a robot file."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from tauten.model.schema.actuators import HELD, Force, Held, Kind, Length, Range
from tauten.model.schema.region import Selection
from tauten.model.schema.section import (
    Direction,
    Name,
    NonNegative,
    Point,
    Positive,
    Section,
    in_range,
)

Angle = Annotated[float, in_range(-1e3, 1e3, "rad")]
Torque = Annotated[float, in_range(-1e6, 1e6, "N m")]


class RigidSettings(Section):
    """A region that moves as a rigid body: a plate, a connector, a screw."""

    name: Name = Field(description="Name of the rigid region, used once.")
    region: Selection = Field(description="Region, or its name, whose nodes move as a rigid body.")


class DriveSettings(Section):
    """A motor that turns a region about an axis, or moves it along the axis, against the robot's frame.

    Of a rotation δ is the angle [rad] and λ the torque [N m], of a translation δ is the travel [m] and λ the
    force [N]; both are positive along `axis`, right-handed.
    """

    name: Name = Field(description="Name in keys, messages and tables.")
    motion: Literal["rotation", "translation"] = Field(
        default="rotation",
        description="Whether the region turns about the axis (default) or moves along it.",
    )
    region: Selection = Field(description="Region, or its name, whose nodes the motor moves.")
    axis: Direction = Field(description="Direction of the axis; its length does not matter.")
    through: Point | None = Field(
        default=None, description="A point of the axis at rest [m], of rotations only."
    )
    min_angle: Angle | None = Field(
        default=None, description="Least angle of a rotation [rad]; by default −max_angle."
    )
    max_angle: Annotated[NonNegative, Field(le=1e3)] | None = Field(
        default=None, description="Largest angle of a rotation [rad]."
    )
    min_torque: Torque | None = Field(
        default=None, description="Least torque of a rotation [N m]; by default −max_torque."
    )
    max_torque: Annotated[NonNegative, Field(le=1e6)] | None = Field(
        default=None, description="Largest torque of a rotation [N m]."
    )
    min_travel: Length | None = Field(
        default=None, description="Least travel of a translation [m]; by default −max_travel."
    )
    max_travel: Annotated[NonNegative, Field(le=1e3)] | None = Field(
        default=None, description="Largest travel of a translation [m]."
    )
    min_force: Force | None = Field(
        default=None, description="Least force of a translation [N]; by default −max_force."
    )
    max_force: Annotated[NonNegative, Field(le=1e6)] | None = Field(
        default=None, description="Largest force of a translation [N]."
    )
    max_rate: Annotated[Positive, Field(le=1e4)] = Field(
        description="Largest speed of the motor [rad/s, m/s]."
    )
    held: Held = Field(default="position", description=HELD)

    @property
    def turns(self) -> bool:
        """Whether it turns its region."""
        return self.motion == "rotation"

    @property
    def kind(self) -> Kind:
        """Kind of actuator, which has its units."""
        return "drive" if self.turns else "slide"

    @property
    def limits(self) -> Range:
        """Limits of torque or force, angle or travel, and its rate."""
        if self.turns:
            least, most, low, high = (
                self.min_angle, self.max_angle, self.min_torque, self.max_torque
            )  # fmt: skip
        else:
            least, most, low, high = (
                self.min_travel, self.max_travel, self.min_force, self.max_force
            )  # fmt: skip
        assert most is not None
        assert high is not None
        return Range.about_rest((low, high), (least, most), self.max_rate)

    @model_validator(mode="after")
    def _consistent(self) -> DriveSettings:
        names = {True: ("angle", "torque"), False: ("travel", "force")}
        for name in names[self.turns]:
            if getattr(self, f"max_{name}") is None:
                raise ValueError(f"a {self.motion} needs max_{name}")
        for name in names[not self.turns]:
            for end in ("min", "max"):
                if getattr(self, f"{end}_{name}") is not None:
                    raise ValueError(f"{end}_{name} is given, but the motion is a {self.motion}")
        if (self.through is not None) != self.turns:
            what = "needs a point `through`" if self.turns else "has no point `through`"
            raise ValueError(f"a {self.motion} {what}")
        self.limits.check(*names[self.turns])
        return self


class AttachmentSettings(Section):
    """What joins a region to something else.

    `glue` ties the nodes of `region` to the tetrahedra of `to`, or nodes of a beam firmly to what is rigid.
    `pin` ties points: the nodes of a beam follow `to` and turn freely, a rigid body turns freely about the
    point `through`. `hinge` lets a region turn about an axis: a rigid body against another one, a soft one by
    tying only its nodes near the axis; without `to` the region as a whole turns against the robot's frame.
    """

    kind: Literal["glue", "pin", "hinge"] = Field(
        description="Whether it holds firmly, holds a point, or turns about an axis."
    )
    region: Selection = Field(
        description="Region, or its name, whose nodes follow; of two soft bodies that with the finer mesh."
    )
    to: Selection | None = Field(
        default=None,
        description="Region, or its name, whose tetrahedra or beam they follow; a hinge without it is held "
        "by the robot's frame.",
    )
    max_distance: Annotated[NonNegative, Field(le=10.0)] = Field(
        default=1e-6,
        description="How far from `to` a node or a point may lie at rest [m], by default 1e-6; the nearest "
        "tetrahedron moves it as if it were larger, the nearest node of a beam as if it were part of it.",
    )
    axis: Direction | None = Field(default=None, description="Direction of a hinge's axis.")
    through: Point | None = Field(
        default=None,
        description="A point of a hinge's axis at rest, or the point of a rigid body that a pin holds [m].",
    )
    radius: Positive | None = Field(
        default=None,
        description="Largest distance from the axis of the nodes that a hinge of a soft body with `to` ties "
        "[m].",
    )
    tilt_stiffness: Annotated[float, in_range(1e-6, 1e9, "N m/rad")] = Field(
        default=1e3,
        description="Stiffness against tilting of the bearing of a hinge between two rigid bodies [N m/rad], "
        "by default 1e3.",
    )

    @model_validator(mode="after")
    def _consistent(self) -> AttachmentSettings:
        given = {name for name in ("axis", "through", "radius") if getattr(self, name) is not None}
        allowed = {
            "glue": set(),
            "pin": {"through"},
            "hinge": {"axis", "through"} | ({"radius"} if self.to is not None else set()),
        }[self.kind]
        needed = {"axis", "through"} if self.kind == "hinge" else set()
        for name in ("axis", "through", "radius"):
            if name in needed - given:
                raise ValueError(f"{name} is needed by this {self.kind}")
            if name in given - allowed:
                raise ValueError(f"{name} is not used by this {self.kind}")
        if self.to is None and self.kind != "hinge":
            raise ValueError(f"to is needed by {self.kind}")
        return self
