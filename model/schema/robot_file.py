"""The robot file, a TOML file, validated field by field."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from tauten.model.schema.actuators import (
    ChamberSettings,
    ForceSettings,
    TransmissionSettings,
)
from tauten.model.schema.body import BodySettings, ElementName, MeshSettings
from tauten.model.schema.cable import CableSettings, CouplingSettings, check_couplings
from tauten.model.schema.constraints import AttachmentSettings, DriveSettings, RigidSettings
from tauten.model.schema.contact import (
    ContactRange,
    ContactSettings,
    ObstacleSettings,
    SurfaceSettings,
    check_forces,
    check_pairs,
    check_surfaces,
)
from tauten.model.schema.effector import EffectorSettings
from tauten.model.schema.material import (
    RegionMaterialSettings,
    SolidMaterialSettings,
    with_densities,
)
from tauten.model.schema.profile import AnyProfile
from tauten.model.schema.region import (
    AnyRegion,
    Region,
    Selection,
    check_regions,
)
from tauten.model.schema.section import (
    Name,
    NonNegative,
    Rate,
    Section,
    check_unique,
    in_range,
)

Threads = Annotated[int, Field(ge=1, le=256)]
Extrapolation = Literal["face", "centre"]
BackEnd = Literal["auto", "pardiso", "cholmod", "superlu"]
Acceleration = Annotated[float, in_range(-1e3, 1e3, "m/s²")]
Gravity = tuple[Acceleration, Acceleration, Acceleration]


SingleActuator = (
    CableSettings | ChamberSettings | DriveSettings | ForceSettings | TransmissionSettings
)


AS_BODY = (
    "beams: beams are a body now: write [[bodies]] with a name and beam = { file = ... } instead, rename "
    "vertebrae to discs in that file, and select its surfaces by [[regions]] of the kind group"
)

ACTUATOR_TABLES = ("cables", "chambers", "drives", "forces", "transmissions")


class IntegrationSettings(Section):
    """Time integration; the time step is 1 / `controller.rate`."""

    scheme: Literal["implicit-euler", "quasi-static"] = Field(
        default="implicit-euler",
        description="With inertia and damping (implicit-euler, default) or without them and the viscosity of "
        "materials (quasi-static).",
    )
    rayleigh_mass: Annotated[NonNegative, Field(le=1e6)] = Field(
        default=0.0, description="Damping proportional to mass [1/s], by default 0."
    )
    rayleigh_stiffness: Annotated[NonNegative, Field(le=1e3)] = Field(
        default=0.0,
        description="Damping proportional to the stiffness of the material [s], by default 0.",
    )
    factorisation: BackEnd = Field(
        default="auto",
        description="Sparse factorisation; auto (default): the fastest that is installed.",
    )
    threads: Threads = Field(
        default=1,
        description="Threads of the sparse factorisation pardiso, by default 1; more may pay for large "
        "meshes on a machine that does nothing else.",
    )


class ControlPeriod(Section):
    """What the model reads of the table `controller`: a time step is one control period, 1 / `rate` [Hz]."""

    model_config = ConfigDict(extra="ignore")

    rate: Rate = Field(
        default=50.0, description="Control rate [Hz], by default 50; a time step is 1 / rate."
    )


# Tables of a robot file that other layers read. They read `controller` too, the model only its rate.
OTHER_LAYERS = ("model", "service")


def model_tables(raw: dict[str, Any]) -> dict[str, Any]:
    """The contents of a robot file without what other layers read; the control rate is kept."""
    return {key: value for key, value in raw.items() if key not in OTHER_LAYERS}


class NamedRobot(Section):
    """The fields of every robot file."""

    read_elsewhere: ClassVar[tuple[str, ...]] = OTHER_LAYERS

    name: Name = Field(description="Name of the robot, part of every key on the wire.")
    frame: Name = Field(
        default="base",
        description="Name of the robot's frame, in the headers of messages; by default base.",
    )
    gravity: Gravity = Field(
        default=(0.0, 0.0, -9.81),
        description="Acceleration of gravity [m/s²], by default 9.81 along −z.",
    )


NO_EFFECTOR = (
    "a robot needs an effector: a table effectors; the file of a part needs none, and is loaded and checked "
    "by the file of the robot that names it in parts"
)


class RobotConfig(NamedRobot):
    """The file of a robot of one or several bodies."""

    is_driven: ClassVar[bool] = True  # whether it needs an actuator

    material: SolidMaterialSettings | None = Field(
        default=None,
        description="Material of the body, or of all bodies that have none of their own.",
    )
    materials: tuple[RegionMaterialSettings, ...] = Field(
        default=(),
        description="Other materials in parts of the body, one table each; a later one replaces an earlier "
        "one.",
    )
    mesh: MeshSettings | None = Field(
        default=None, description="Mesh of the body, where there is one."
    )
    bodies: tuple[BodySettings, ...] = Field(
        default=(), description="Bodies, one table each, instead of `mesh`."
    )
    profiles: tuple[AnyProfile, ...] = Field(
        default=(), description="Cross-sections of the bodies that are beams, one table each."
    )
    rigid: tuple[RigidSettings, ...] = Field(
        default=(),
        description="Regions that move as rigid bodies, one table each; by default none.",
    )
    attachments: tuple[AttachmentSettings, ...] = Field(
        default=(),
        description="What joins regions to each other or to the robot's frame; by default nothing.",
    )
    extrapolate_from: Extrapolation = Field(
        default="face",
        description="Element that points outside the mesh, as far as `max_outside` of them allows, are moved "
        "by: the one with the nearest face (face, default) or with the nearest centre (centre), as in SOFA.",
    )
    surfaces: tuple[SurfaceSettings, ...] = Field(
        default=(),
        description="Named parts of the body's surface, one table each; by default none.",
    )
    fixed: tuple[Selection, ...] = Field(
        default=(),
        description="Regions, or their names, whose nodes do not move; by default none, where something "
        "else holds every body.",
    )
    regions: tuple[AnyRegion, ...] = Field(
        default=(), description="Regions that other tables use by name; by default none."
    )
    cables: tuple[CableSettings, ...] = Field(
        default=(), description="Cables, one table each; by default none."
    )
    chambers: tuple[ChamberSettings, ...] = Field(
        default=(), description="Closed cavities under pressure, one table each; by default none."
    )
    drives: tuple[DriveSettings, ...] = Field(
        default=(),
        description="Motors that turn or move a region, one table each; by default none.",
    )
    forces: tuple[ForceSettings, ...] = Field(
        default=(),
        description="Forces of fixed direction on the body, one table each; by default none.",
    )
    transmissions: tuple[TransmissionSettings, ...] = Field(
        default=(),
        description="Motors that act on the body through a function of another package, one table each; by "
        "default none.",
    )
    couplings: tuple[CouplingSettings, ...] = Field(
        default=(),
        description="Motors that drive several actuators each, one table each; by default none.",
    )
    effectors: Annotated[list[EffectorSettings], Field(min_length=1)] = Field(
        description="What is to reach targets, one table each; the first one's keys on the wire "
        "are plain. The file of a part needs none, and no actuator."
    )
    obstacles: tuple[ObstacleSettings, ...] = Field(
        default=(),
        description="What the robot may touch beside itself, one table each; by default nothing.",
    )
    contacts: tuple[ContactSettings, ...] = Field(
        default=(),
        description="Pairs of surfaces, or of a surface and an obstacle, that may touch, one table each; by "
        "default none.",
    )
    contact: ContactRange = Field(
        default=ContactRange(), description="Distances of contact handling."
    )
    integration: IntegrationSettings = Field(
        default=IntegrationSettings(), description="Time integration."
    )
    controller: ControlPeriod = Field(
        default=ControlPeriod(), description="Control rate and inverse control."
    )

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        touching = [(one, one.against) for one in self.contacts]
        check_forces(touching, self.obstacles, self.contact)
        check_pairs([one.name for one in self.contacts])
        check_unique("cables", [cable.name for cable in self.cables])
        check_unique("effectors", [effector.name for effector in self.effectors])
        check_unique("obstacles", [obstacle.name for obstacle in self.obstacles])
        single = self.single_actuators
        if self.is_driven and not single:
            raise ValueError(
                f"a robot needs an actuator: a table {', '.join(ACTUATOR_TABLES[:-1])} or "
                f"{ACTUATOR_TABLES[-1]}"
            )
        check_unique("actuators", [item.name for item in (*single, *self.couplings)])
        sprung = {
            cable.name
            for cable in self.cables
            if cable.spring is not None and cable.min_tension >= 0.0
        }
        check_couplings(self.couplings, {item.name: item.kind for item in single}, sprung)
        return self

    def named_regions(self) -> dict[str, Region]:
        """Regions and surfaces by name.

        Raises:
            ValueError: a region without a name, or a name used twice.
        """
        for index, region in enumerate(self.regions):
            if region.name is None:
                raise ValueError(f"regions.{index}: it needs a name")
        names = [region.name or "" for region in self.regions]
        check_unique("regions", names)
        surfaces = {surface.name: surface.region() for surface in self.surfaces}
        check_unique("surfaces", [surface.name for surface in self.surfaces])
        check_unique("surfaces and regions", [*surfaces, *names])
        return {**dict(zip(names, self.regions, strict=True)), **surfaces}

    def selections(self) -> list[tuple[str, Region | str]]:
        """Selections outside of `regions`, with the fields they come from."""
        found: list[tuple[str, Region | str | None]] = [
            *((f"fixed.{index}", item) for index, item in enumerate(self.fixed)),
            *((f"chambers.{index}.surface", c.surface) for index, c in enumerate(self.chambers)),
            *((f"drives.{index}.region", d.region) for index, d in enumerate(self.drives)),
            *((f"forces.{index}.region", f.region) for index, f in enumerate(self.forces)),
            *((f"transmissions.{i}.region", t.region) for i, t in enumerate(self.transmissions)),
            *((f"effectors.{index}.region", e.region) for index, e in enumerate(self.effectors)),
            *((f"materials.{i}.region", item.region) for i, item in enumerate(self.materials)),
            *((f"rigid.{item.name}.region", item.region) for item in self.rigid),
            *((f"attachments.{i}.region", item.region) for i, item in enumerate(self.attachments)),
            *((f"attachments.{i}.to", item.to) for i, item in enumerate(self.attachments)),
        ]
        for b, body in enumerate(self.bodies):
            parts = enumerate(body.materials)
            found += [(f"bodies.{b}.materials.{i}.region", item.region) for i, item in parts]
            found += [(f"bodies.{b}.fixed.{i}", region) for i, region in enumerate(body.fixed)]
        return [(field, selection) for field, selection in found if selection is not None]

    @model_validator(mode="after")
    def _regions(self) -> Self:
        check_regions(self.named_regions(), self.selections())
        return self

    @property
    def single_actuators(self) -> tuple[SingleActuator, ...]:
        """All actuators but couplings: cables, chambers, drives, forces, transmissions as listed."""
        return (*self.cables, *self.chambers, *self.drives, *self.forces, *self.transmissions)

    @property
    def actuators(self) -> tuple[SingleActuator | CouplingSettings, ...]:
        """In the order of λ_a: a coupling stands where its first member stood, the others vanish."""
        coupling_of = {name: item for item in self.couplings for name in item.members}
        found = (coupling_of.get(item.name, item) for item in self.single_actuators)
        return tuple({item.name: item for item in found}.values())

    @model_validator(mode="before")
    @classmethod
    def _densities(cls, raw: Any) -> Any:
        if isinstance(raw, dict) and "beams" in raw:
            raise ValueError(AS_BODY)
        has_body = isinstance(raw, dict) and bool(raw.get("mesh", raw.get("bodies")))
        if cls.is_driven and has_body and "effectors" not in raw:
            raise ValueError(NO_EFFECTOR)
        raw = with_densities(raw)
        if isinstance(raw, dict) and isinstance(raw.get("bodies"), list | tuple):
            shared = raw.get("material")
            raw = {**raw, "bodies": [with_densities(body, shared) for body in raw["bodies"]]}
        return raw

    @model_validator(mode="after")
    def _bodies(self) -> RobotConfig:
        if (self.mesh is None) != bool(self.bodies):
            found = "both" if self.bodies else "neither"
            raise ValueError(f"mesh: a robot has a mesh or bodies, this one has {found}")
        if self.bodies and self.materials:
            raise ValueError("materials: with bodies they stand in the table of each body")
        check_unique("bodies", [body.name for body in self.bodies])
        check_unique("rigid", [item.name for item in self.rigid])
        check_unique("profiles", [profile.name for profile in self.profiles])
        known = [profile.name for profile in self.profiles]
        for index, body in enumerate(self.bodies):
            if body.beam is not None and body.beam.profile not in (None, *known):
                raise ValueError(
                    f"bodies.{index}.beam.profile: {body.beam.profile!r} is not one of profiles, "
                    f"which has {', '.join(known) or 'none'}"
                )
        for index, body in enumerate(self.bodies):
            if body.material is None and self.material is None:
                raise ValueError(f"bodies.{index}.material: Field required, or material for all")
        if self.mesh is not None and self.material is None:
            raise ValueError("material: Field required")
        return self

    @property
    def all_bodies(self) -> tuple[BodySettings, ...]:
        """The bodies, each with its material; the one of `mesh` has the name "body"."""
        if self.mesh is not None:
            one = {"name": "body", "mesh": self.mesh, "material": self.material}
            return (BodySettings.model_validate({**one, "materials": self.materials}),)
        return tuple(
            body if body.material else body.model_copy(update={"material": self.material})
            for body in self.bodies
        )

    @property
    def meshes(self) -> tuple[MeshSettings, ...]:
        """The meshes of the bodies that have one."""
        return tuple(body.mesh for body in self.all_bodies if body.mesh is not None)

    @property
    def needs_boundary(self) -> bool:
        """Whether something lies on the boundary of a mesh, which tetrahedra that overlap do not have.

        These are contacts and cavities, of chambers and of effectors.
        """
        cavities = [chamber for chamber in self.chambers if not chamber.own_surface]
        volumes = [effector for effector in self.effectors if effector.kind == "volume"]
        return bool(self.contacts or cavities or volumes)

    def with_element(self, element: ElementName) -> RobotConfig:
        """The same file with all bodies made of another element."""
        changed = {"element": element}
        bodies = tuple(
            body.model_copy(update={"mesh": body.mesh and body.mesh.model_copy(update=changed)})
            for body in self.bodies
        )
        mesh = self.mesh and self.mesh.model_copy(update=changed)
        return self.model_copy(update={"mesh": mesh, "bodies": bodies})

    @model_validator(mode="after")
    def _surfaces(self) -> RobotConfig:
        obstacles = [obstacle.name for obstacle in self.obstacles]
        check_surfaces(self.contacts, set(self.named_regions()), obstacles)
        return self


class PartRobotConfig(RobotConfig):
    """The file of a part, which may be an object: without actuators and effectors."""

    is_driven: ClassVar[bool] = False

    effectors: list[EffectorSettings] = Field(
        default_factory=list, description="What is to reach targets, one table each."
    )
