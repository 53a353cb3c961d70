"""From names on the command line to a robot with its contact basis, and the settings of its node."""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from tauten.controller import (
    ControllerSetup,
    Order,
    controller_setup,
    load_controller_settings,
    part_files,
)
from tauten.model.load import robot_path
from tauten.model.schema import read_toml, validated
from tauten.service.check import mesh_error_text
from tauten.service.settings import ServiceSettings

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Setup(ControllerSetup):
    """All that a node is made from.

    Attributes:
        service: settings of the node.
    """

    service: ServiceSettings = field(default_factory=ServiceSettings)

    def basis_digest(self) -> str:
        """SHA-256 of the modes; "" without basis."""
        if isinstance(self.contact, str):
            return ""
        return hashlib.sha256(np.ascontiguousarray(self.contact.Psi).tobytes()).hexdigest()

    def states_digest(self) -> str:
        """SHA-256 of the state bases; "" with the full model."""
        digests = [basis.digest() for basis in self.states]
        if len(digests) < 2:
            return "".join(digests)
        return hashlib.sha256("".join(digests).encode()).hexdigest()

    @property
    def basis_modes(self) -> int:
        """Number of modes of the contact basis; 0 without one."""
        return 0 if isinstance(self.contact, str) else self.contact.k

    @property
    def mesh_error(self) -> str:
        """The error of the robot's mesh in one sentence."""
        return mesh_error_text(self.path, self.robot.digest)

    @property
    def order(self) -> Order:
        """The model that decides."""
        return "reduced" if self.states else "full"

    def in_full_order(self) -> Setup:
        """The same with the full model, which a reduced one was made from."""
        if self.reduced is None:
            return self
        return replace(self, robot=self.reduced.body.full, states=(), reduced=None)


def load_setup(
    robot: str | Path,
    rate: float | None = None,
    basis: str | None = None,
    model: Order | None = None,
    accept_error: bool = False,
    young_scale: float = 1.0,
) -> Setup:
    """Load a robot, its contact basis, and its state basis where the model is reduced.

    Args:
        robot: name of a shipped robot or path of a robot file.
        rate: another control rate than the file's [Hz].
        basis: another basis than the file's; "none" for no contact, "full" for pointwise contact. A file
            .basis here comes before one of this name beside the robot file.
        model: another model than the file's.
        accept_error: accept a state basis with a larger error than the robot file allows.
        young_scale: of Young's modulus; a robot of another stiffness than the file's has no state basis.

    Raises:
        RobotFileError: the robot file cannot be used.
        MeshError: its mesh cannot be used.
        BasisError: its contact basis cannot be used.
        StateBasisError: its state basis cannot be used.
    """
    path = robot_path(robot)
    contents = read_toml(path)
    service = validated(ServiceSettings, contents.get("service", {}), path, "service")
    if basis is not None and basis.endswith(".basis") and Path(basis).is_file():
        basis = str(Path(basis).resolve())
    made = controller_setup(contents, path, rate, basis, model, accept_error, young_scale)
    for note in unused_tables(contents, path):
        log.warning("%s: %s", path, note)
    return Setup(
        made.robot, made.path, made.contact, made.basis_name, made.controller, made.model, made.states,
        made.reduced, made.start, service,
    )  # fmt: skip


def unused_tables(contents: dict[str, Any], path: Path) -> Iterator[str]:
    """What tables of parts' files say otherwise than the file of all parts, which does not say it but counts.

    Of `controller` a part has its own contact basis; its rate is compared where the robot is made.

    Raises:
        RobotFileError: a table of a part's file cannot be used.
    """
    for file in dict.fromkeys(part_files(contents, path)):
        own = validated(ServiceSettings, read_toml(file).get("service", {}), file, "service")
        for table, settings, apart in (
            ("controller", load_controller_settings(file), {"basis"}),
            ("service", own, set[str]()),
        ):
            used = type(settings)()
            fields = sorted(
                field
                for field in settings.model_fields_set - apart - contents.get(table, {}).keys()
                if getattr(settings, field) != getattr(used, field)
            )
            if fields:
                what = f"{', '.join(fields)} in the table {table} of {file}"
                yield (
                    f"{what} {'is' if len(fields) == 1 else 'are'} not used; write what is to count into "
                    "this file, which has the default"
                )


def interpolated(setup: Setup, delay: float) -> Setup:
    """A setup whose node follows targets on straight lines between them, so much later [s]; 0: the latest.

    Raises:
        RobotFileError: the delay is not allowed.
    """
    service = setup.service.model_dump() | {"interpolation_delay": delay}
    return replace(setup, service=validated(ServiceSettings, service, "--interpolate"))
