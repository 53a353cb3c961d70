"""What a basis was made for: a digest of a robot's description, and in what two of them differ.

The digest is made of what was read, the settings and the content of files, and of nothing that is computed
from it: another compiler, processor or version of a library gives the same one. Settings at their default
are left out, so that files made before a setting existed keep their digest.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tauten.model.schema.actuators import (
    ChamberSettings,
    ForceSettings,
    TransmissionSettings,
)
from tauten.model.schema.body import BeamSettings, BodySettings, MeshSettings
from tauten.model.schema.cable import CableSettings, CouplingSettings
from tauten.model.schema.constraints import DriveSettings
from tauten.model.schema.contact import ITSELF, ContactSettings, ObstacleSettings, TouchSettings
from tauten.model.schema.material import SolidMaterialSettings
from tauten.model.schema.region import NearStl, Region
from tauten.model.schema.robot_file import RobotConfig
from tauten.model.schema.section import Parameters, Section

# To be raised by every change of the code that gives the same file other contact candidates, elements or
# actuators, or that changes a default: bases that were made before are then refused.
FORM = 1
PARTS = (
    "mesh", "materials", "supports", "cables", "other actuators", "couplings", "contacts",
    "versions of the model",
)  # fmt: skip
_DIGITS = 8  # hexadecimal digits of each part
_ACTUATORS = (
    CableSettings | ChamberSettings | CouplingSettings | DriveSettings | ForceSettings
    | TransmissionSettings
)  # fmt: skip


def robot_digest(config: RobotConfig, meshes: Sequence[bytes], folder: Path) -> str:
    """The digest of a robot with bodies: eight digits of a SHA-256 for each of `PARTS`.

    It covers what contact forces depend on, and neither loads, limits, control nor effectors.
    """
    write, bodies = _Writer(_named(config), folder), config.all_bodies
    outside = [] if config.extrapolate_from == "face" else [config.extrapolate_from]
    contents = [hashlib.sha256(content).hexdigest() for content in meshes]
    parts = [
        [*contents, write.plain(bodies), *outside],
        [
            *(write.plain((body.material, body.materials)) for body in bodies),
            write.plain(config.profiles),
        ],
        [
            *(write.selections(item) for item in (config.fixed, *(body.fixed for body in bodies))),
            write.plain((config.rigid, config.attachments)),
        ],
        *_actuators(config, write),
        _contacts(config, write, len(config.contacts)),
        FORM,
    ]
    return "".join(map(_hashed, parts))


def digests_of_fewer(digest: str, config: RobotConfig, folder: Path) -> tuple[str, ...]:
    """Digests of the robot with the first 0, 1, 2, ... of its contacts, the last one left out at least.

    A basis of contact forces that was made before contacts were added to a file still fits the others.
    """
    write, at = _Writer(_named(config), folder), PARTS.index("contacts") * _DIGITS
    return tuple(
        digest[:at] + _hashed(_contacts(config, write, count)) + digest[at + _DIGITS :]
        for count in range(len(config.contacts))
    )


def joined_digest(robots: Sequence[str], couplings: str, contacts: str) -> str:
    """The digest of a robot of several parts from theirs, part by part of `PARTS`."""
    more, found = {"couplings": couplings, "contacts": contacts}, []
    for k, what in enumerate(PARTS):
        own = [digest[k * _DIGITS : (k + 1) * _DIGITS] for digest in robots]
        text = json.dumps([*own, more.get(what, "")])
        found.append(hashlib.sha256(text.encode()).hexdigest()[:_DIGITS])
    return "".join(found)


def same_but_contacts(one: str, other: str) -> bool:
    """Whether two robots differ in nothing or in their contacts alone, by their digests."""
    return differences(one, other) in ("", "contacts")


def differences(one: str, other: str) -> str:
    """In what two robots differ by their digests, in words: "mesh and cables"; "" where they are the same."""
    size = len(PARTS) * _DIGITS
    if one == other:
        return ""
    if len(one) != size or len(other) != size or one[-_DIGITS:] != other[-_DIGITS:]:
        return PARTS[-1]
    found = [
        part
        for k, part in enumerate(PARTS)
        if one[k * _DIGITS : (k + 1) * _DIGITS] != other[k * _DIGITS : (k + 1) * _DIGITS]
    ]
    return " and ".join(filter(None, [", ".join(found[:-1]), found[-1]]))


def _hashed(part: Any) -> str:
    """Eight digits of one part."""
    return hashlib.sha256(json.dumps(part).encode()).hexdigest()[:_DIGITS]


def _contacts(config: RobotConfig, write: _Writer, count: int) -> list[Any]:
    """What the first contacts of a robot depend on."""
    contacts, alarm = config.contacts[:count], config.contact.alarm_distance
    folded = any(item.against == ITSELF for item in contacts)
    held = [config.contact.distance] if config.contact.distance else []
    return [write.plain(contacts), alarm if folded else None, *held]


def _named(config: RobotConfig) -> dict[str, Section]:
    """Regions and obstacles by name."""
    return {**config.named_regions(), **{one.name: one for one in config.obstacles}}


def _actuators(config: RobotConfig, write: _Writer) -> list[Any]:
    """Cables, other actuators and couplings; members of a coupling by their numbers."""
    names = [item.name for item in config.single_actuators]
    couplings = [
        [write.plain(item), [names.index(name) for name in item.members]]
        for item in config.couplings
    ]
    others: tuple[Any, ...] = (config.chambers, config.drives, config.forces)
    if config.transmissions:  # files made before these existed keep their digest
        others = (*others, config.transmissions)
    return [write.plain(config.cables), write.plain(others), couplings]


@dataclass(frozen=True, slots=True)
class _Writer:
    """Turns settings into values of JSON, always the same for the same robot.

    It knows regions and obstacles by name, and the folder of files that settings name.
    """

    named: Mapping[str, Section]
    folder: Path

    def plain(self, value: Any) -> Any:
        """Settings without defaults, with regions and the content of files instead of their names."""
        if isinstance(value, Section):
            fields = type(value).model_fields
            kept = {name: getattr(value, name) for name in sorted(fields) if _counts(value, name)}
            return {
                name: self._field(value, name, item)
                for name, item in kept.items()
                if item != fields[name].get_default(call_default_factory=True)
            }
        if isinstance(value, list | tuple):
            return [self.plain(item) for item in value]
        if isinstance(value, dict):
            return {name: value[name] for name in sorted(value)}
        return value

    def _field(self, section: Section, name: str, value: Any) -> Any:
        """One field; names of regions and files are resolved where the field holds such."""
        if (isinstance(section, NearStl) and name == "file") or (
            isinstance(section, ChamberSettings) and name == "stl"
        ):
            return hashlib.sha256((self.folder / value).read_bytes()).hexdigest()
        if isinstance(section, ObstacleSettings) and name == "parameters":
            return self.plain(by_content(value, self.folder))
        if isinstance(section, ContactSettings) or name in ("region", "surface", "to"):
            return self._selection(value)
        return self.selections(value) if name == "of" else self.plain(value)

    def selections(self, values: Sequence[Region | str]) -> list[Any]:
        """Several regions, or names of such."""
        return [self._selection(value) for value in values]

    def _selection(self, value: Any) -> Any:
        """A region or an obstacle instead of its name; other values as they are."""
        return self.plain(self.named.get(value, value) if isinstance(value, str) else value)


def by_content(parameters: Parameters, folder: Path) -> dict[str, Any]:
    """Parameters of an obstacle, of which a file counts by its content."""
    if "file" not in parameters:
        return parameters
    content = (folder / str(parameters["file"])).read_bytes()
    return {**parameters, "file": hashlib.sha256(content).hexdigest()}


def _counts(section: Section, name: str) -> bool:
    """Whether contact forces depend on a field of a section."""
    if isinstance(section, _ACTUATORS):
        return name not in ("name", "held", "members") and not name.startswith(("min_", "max_"))
    if isinstance(section, BodySettings):
        return name not in ("material", "materials", "fixed")
    if isinstance(section, MeshSettings):
        return name not in ("file", "length_unit")  # the content counts, in metres
    if isinstance(section, BeamSettings):
        return name != "file"
    if isinstance(section, ContactSettings):
        return name not in TouchSettings.model_fields  # candidates are the same without
    if isinstance(section, SolidMaterialSettings):
        return name != "viscosity"  # bases are made at rest
    if isinstance(section, ObstacleSettings) and name == "stream":
        return False
    return not (isinstance(section, Region | ObstacleSettings) and name == "name")
