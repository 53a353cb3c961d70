"""Every shipped file fits its robot, with whatever versions of Python and libraries this runs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pydantic import TypeAdapter
from support.robots.examples import shipped_robot, shipped_setup

from tauten.model import Simulator
from tauten.model.load import robot_path
from tauten.reduction import ContactBasis
from tauten.reduction.state import StateBasis
from tauten.service.check import MeshCertificate
from tauten.service.check.certificate import certificate_file

pytestmark = pytest.mark.versions
FOLDER = robot_path("finger").parent


def shipped(suffix: str) -> list[str]:
    return sorted(path.stem for path in FOLDER.glob(f"*{suffix}"))


@pytest.mark.parametrize("name", shipped(".basis"))
def test_contact_basis_fits(name: str) -> None:
    ContactBasis.load(name).check_robot(shipped_robot(name))


@pytest.mark.parametrize("name", shipped(".states"))
def test_state_basis_fits(name: str) -> None:
    StateBasis.load(name).check_robot(shipped_robot(name))


@pytest.mark.parametrize("name", [name.removesuffix(".mesh") for name in shipped(".mesh.json")])
def test_mesh_error_is_of_the_robot(name: str) -> None:
    text = certificate_file(Path(FOLDER, f"{name}.toml")).read_text(encoding="utf-8")
    found = TypeAdapter(MeshCertificate).validate_json(text)
    assert found.robot_digest == shipped_robot(name).digest


@pytest.mark.long
def test_the_reduced_pneumatic_finger_is_where_the_full_one_is_at_equal_volumes() -> None:
    """Within half of what is asked of its path; its basis of 33 modes was 0.065 mm away in the middle."""
    reduced, full = (
        Simulator(shipped_setup("pneumatic_finger").robot),
        Simulator(shipped_robot("pneumatic_finger")),
    )
    for simulator in (reduced, full):
        assert simulator.settle_start().converged
    for pressure in (1e4, 2e4):
        assert reduced.settle(effort=[pressure]).converged
        assert full.settle(position=reduced.position).converged
        assert np.linalg.norm(full.effector - reduced.effector) < 2.5e-5
