"""The contact basis of a robot of several parts from those of its parts."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from datetime import UTC, datetime

import numpy as np

from tauten.model import Robot
from tauten.reduction.contact.basis import ContactBasis
from tauten.reduction.provenance import Provenance, package_versions


def joined_basis(robot: Robot, bases: Sequence[ContactBasis | None]) -> ContactBasis | None:
    """Modes of every part that has some, block by block; other contact is left to unit columns.

    None where no part has a basis.
    """
    found = [basis for basis in bases if basis is not None]
    if not found:
        return None
    Psi = np.zeros((robot.n_c, sum(basis.k for basis in found)))
    slot = mode = 0
    for part, basis in zip(robot.body.part_robots, bases, strict=True):
        if basis is not None:
            Psi[slot : slot + basis.n_c, mode : mode + basis.k] = basis.Psi
            mode += basis.k
        slot += part.n_c
    return ContactBasis(Psi, joined_provenance(robot, [basis.provenance for basis in found]))


def joined_provenance(robot: Robot, origins: Sequence[Provenance]) -> Provenance:
    """The origin of a basis that is joined of those of parts."""
    first = origins[0]
    text = "".join(origin.snapshots_digest for origin in origins)
    return Provenance(
        robot=robot.name,
        robot_digest=robot.digest,
        campaign="; ".join(f"{one.robot}: {one.campaign}" for one in origins),
        snapshots_digest=hashlib.sha256(text.encode()).hexdigest(),
        snapshots=sum(origin.snapshots for origin in origins),
        weighting=first.weighting,
        method=first.method,
        k=sum(origin.k for origin in origins),
        seed=first.seed,
        error=max(origin.error for origin in origins),
        energy_error=max(origin.energy_error for origin in origins),
        tip_error=max(origin.tip_error for origin in origins),
        curve=(),
        created=datetime.now(UTC).isoformat(timespec="seconds"),
        versions=package_versions(),
    )
