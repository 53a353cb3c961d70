"""The error of a robot's mesh as a file beside the robot, for reports of runs and benchmarks."""

from __future__ import annotations

import json
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path

from pydantic import TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass

from tauten.model.load import command_name
from tauten.model.schema import differences, read_toml
from tauten.reduction import write_text
from tauten.service.check.mesh_error import MeshErrorEstimate, errors_in_words


@dataclass(frozen=True, slots=True)
class MeshCertificate:
    """How wrong a robot's mesh is, as `tauten check` found it.

    Attributes:
        robot_digest: of the robot that was checked; the numbers hold for no other one.
        date: when, ISO 8601.
        effort: relative error of the effort that differs most; None where none was found.
        tip: largest error of an effector [m].
        contact: relative error of the contact force; None where nothing touches.
        reference: what the mesh was compared with.
        largest_share: of every actuator's range, up to which it was compared.
        effort_name: what the efforts are called.
    """

    robot_digest: str
    date: str
    effort: float | None
    tip: float | None
    contact: float | None
    reference: str
    largest_share: float
    effort_name: str = "tension"

    def save(self, path: Path) -> None:
        """Write as JSON beside a robot file."""
        write_text(certificate_file(path), json.dumps(asdict(self), indent=2) + "\n")


def certificate_file(robot_file: Path) -> Path:
    """Where the certificate of a robot file is: finger.mesh.json beside finger.toml."""
    return robot_file.with_suffix(".mesh.json")


def certified(estimate: MeshErrorEstimate, robot_digest: str) -> MeshCertificate:
    """The certificate of the robot's own mesh.

    Raises:
        ValueError: the comparison was stopped early, or found no equilibrium to compare.
    """
    own = estimate.variants[0] if estimate.variants else None
    if not estimate.complete or own is None or own.effort is None or own.unsettled:
        raise ValueError(f"there is nothing to save: {estimate.verdict}")
    return MeshCertificate(
        robot_digest,
        datetime.now(UTC).isoformat(timespec="seconds"),
        own.effort,
        own.tip,
        own.contact,
        estimate.against,
        max(load.share for load in estimate.loads),
        estimate.effort_name,
    )


def mesh_error_text(robot_file: Path, robot_digest: str) -> str:
    """The error of a robot's mesh in one sentence, for reports."""
    command = f"run tauten check {command_name(robot_file)} --save"
    try:
        text = certificate_file(robot_file).read_text(encoding="utf-8")
        found = TypeAdapter(MeshCertificate).validate_json(text)
    except FileNotFoundError:
        why_not = not_compared(robot_file) if robot_file.is_file() else ""
        return f"not looked at: {why_not}" if why_not else f"unknown, {command}"
    except (OSError, UnicodeDecodeError, ValidationError):
        return f"unknown, {certificate_file(robot_file)} cannot be read, {command}"
    if found.robot_digest != robot_digest:
        changed = differences(found.robot_digest, robot_digest)
        return f"unknown since the robot was changed ({changed}), {command}"
    parts = errors_in_words(found.effort, found.tip, found.contact, found.effort_name)
    return f"{', '.join(parts)} (tauten check, {found.date[:10]})"


def not_compared(robot_file: Path) -> str:
    """Why `tauten check` compares no meshes of a robot that can be built; "" where it does."""
    contents = read_toml(robot_file)
    if "parts" in contents:
        return "meshes of parts are compared by themselves, with tauten check of their files"
    free = [body["name"] for body in contents.get("bodies", ()) if body.get("free")]
    return f"nothing holds {', '.join(free)} but contact" if free else ""
