"""Every shipped file fits its robot, with whatever versions of Python and libraries this runs."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest
from pydantic import TypeAdapter

from tauten.model import Robot, load_robot
from tauten.model.load import robot_path
from tauten.reduction import ContactBasis
from tauten.reduction.state import StateBasis
from tauten.service.check import MeshCertificate
from tauten.service.check.certificate import certificate_file

pytestmark = pytest.mark.versions
FOLDER = robot_path("finger").parent


def shipped(suffix: str) -> list[str]:
    return sorted(path.stem for path in FOLDER.glob(f"*{suffix}"))


@cache
def robot(name: str) -> Robot:
    return load_robot(name)


@pytest.mark.parametrize("name", shipped(".basis"))
def test_contact_basis_fits(name: str) -> None:
    ContactBasis.load(name).check_robot(robot(name))


@pytest.mark.parametrize("name", shipped(".states"))
def test_state_basis_fits(name: str) -> None:
    StateBasis.load(name).check_robot(robot(name))


@pytest.mark.parametrize("name", [name.removesuffix(".mesh") for name in shipped(".mesh.json")])
def test_mesh_error_is_of_the_robot(name: str) -> None:
    text = certificate_file(Path(FOLDER, f"{name}.toml")).read_text(encoding="utf-8")
    found = TypeAdapter(MeshCertificate).validate_json(text)
    assert found.robot_digest == robot(name).digest
