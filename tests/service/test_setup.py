"""One robot file, read once: every layer takes its own table and refuses what it does not allow."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.processes import ROBOT, write_robot
from support.robots.thumb import write_thumb
from support.state_bases import basis_of, turned_space

from tauten.controller import ControllerSettings, ModelSettings, load_controller_settings
from tauten.model import RobotFileError, load_robot
from tauten.model.load import shipped_folder
from tauten.model.tetra import NodalBody
from tauten.reduction import BasisError, ContactBasis, Provenance
from tauten.reduction.state import StateBasisError
from tauten.service.settings import ServiceSettings
from tauten.service.setup import load_setup

TABLES = """
[controller]
rate = 80.0
regularisation = 3e-3
max_pivots = 7
[service]
target_timeout = 0.3
late_limit = 9
[model]
check_period = 2.0
"""


@pytest.fixture
def folder(tmp_path: Path, beam_file: Path) -> Path:
    text = beam_file.read_text()
    for table in ("controller = ", "service = "):
        text = "\n".join(line for line in text.splitlines() if not line.startswith(table))
    (tmp_path / "bare.toml").write_text(text)
    for path in beam_file.parent.iterdir():
        if path.is_file() and path != beam_file:
            (tmp_path / path.name).write_bytes(path.read_bytes())
    return tmp_path


def written(folder: Path, tables: str) -> Path:
    path = folder / "with_tables.toml"
    path.write_text((folder / "bare.toml").read_text() + "\n" + tables)
    return path


def test_each_layer_gets_its_table(folder: Path) -> None:
    path = written(folder, TABLES)
    setup = load_setup(path)
    assert setup.robot.integration.rate == 80.0
    assert setup.controller == ControllerSettings(regularisation=3e-3, max_pivots=7)
    assert setup.controller == load_controller_settings(path)
    assert setup.service == ServiceSettings(target_timeout=0.3, late_limit=9)
    assert setup.model == ModelSettings(check_period=2.0)
    assert load_setup(path, rate=40.0).robot.h == 1.0 / 40.0


def test_a_file_without_tables_has_the_defaults(folder: Path) -> None:
    setup = load_setup(folder / "bare.toml")
    assert setup.robot.integration.rate == load_robot(folder / "bare.toml").integration.rate == 50.0
    settings = (setup.controller, setup.model, setup.service)
    assert settings == (ControllerSettings(), ModelSettings(), ServiceSettings())


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        (
            "[service]\nrelease_time = 1e300",
            r"service.release_time: allowed is at least 0.001 and at most 60 s, found 1e\+300",
        ),
        (
            "[service]\ntarget_timeout = 61",
            "service.target_timeout: allowed is at least 0.001 and at most 60 s, found 61",
        ),
        (
            "[service]\nmeasurement_timeout = 1e300",
            r"service.measurement_timeout: allowed is at least 0.001 and at most 10 s, found 1e\+300",
        ),
        (
            "[model]\ncheck_period = 1e-300",
            "model.check_period: allowed is at least 0.001 and at most 3600 s, found 1e-300",
        ),
        (
            "[service]\nrelease = 1.0",
            "service.release: unknown field, allowed are target_timeout, release_time",
        ),
        ("[controller]\nqp_solver = 3", "controller.qp_solver: .*valid string, found 3"),
        ("[controller]\nrate = -1.0", "controller.rate: .* greater than 0, found -1.0"),
        ("[controller]\nrat = 1.0", "controller.rat: unknown field, allowed are rate, qp_solver,"),
        ("[extra]\nx = 1", "extra: unknown field, allowed are "),
    ],
)
def test_what_a_table_does_not_allow_is_named(folder: Path, tables: str, message: str) -> None:
    with pytest.raises(RobotFileError, match=f"with_tables.toml: {message}"):
        load_setup(written(folder, tables))


def reduced_thumb(folder: Path, basis: str, states: str) -> Path:
    """A robot file of one's own with bases beside it, under these names."""
    path = write_thumb(folder)
    robot = load_robot(path)
    assert isinstance(robot.body, NodalBody)
    elements = np.arange(robot.body.n_elements)
    made = basis_of(robot, turned_space(robot), elements, np.ones(len(elements)))
    made.save(folder / f"{states}.states")
    Psi = np.eye(robot.n_c)[:, :5]
    origin = Provenance(
        robot.name, robot.digest, "test", "", 0, "equal", "energy", 5, 0, 0.0, 0.0, 0.0, (), "", ()
    )  # fmt: skip
    ContactBasis(Psi, origin).save(folder / f"{basis}.basis")
    return path


def test_bases_beside_a_robot_file_need_no_suffix(tmp_path: Path) -> None:
    """`basis = "thumb"` and the default of `[model] states`, as `tauten reduce` names its files."""
    path = reduced_thumb(tmp_path, "thumb", "thumb")
    path.write_text(path.read_text().replace("controller = {", 'controller = {basis = "thumb", '))
    setup = load_setup(path, model="reduced", accept_error=True)
    assert isinstance(setup.contact, ContactBasis)
    assert setup.contact.k == 5
    assert setup.states
    assert setup.order == "reduced"


def test_bases_of_other_names_are_found_with_and_without_suffix(tmp_path: Path) -> None:
    path = reduced_thumb(tmp_path, "soft.v2", "fine")
    for basis, states in (("soft.v2", "fine"), ("soft.v2.basis", "fine.states")):
        tables = f'model = {{states = "{states}"}}\n'
        (tmp_path / "other.toml").write_text(tables + path.read_text())
        setup = load_setup(tmp_path / "other.toml", None, basis, "reduced", accept_error=True)
        assert isinstance(setup.contact, ContactBasis)
        assert setup.states
    said = f"no contact basis 'thumb'.*; no file thumb.basis is beside {path} either; `tauten reduce {path}`"
    with pytest.raises(BasisError, match=said):
        load_setup(path, basis="thumb")
    said = f"no state basis 'thumb'.*; no file thumb.states .*; `tauten reduce {path} --states` makes one$"
    with pytest.raises(StateBasisError, match=said):
        load_setup(path, model="reduced")


@pytest.mark.long
def test_a_basis_of_a_shipped_robot_made_here_is_used_and_not_the_shipped_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`tauten reduce finger` writes finger.basis here; --basis finger.basis took that of the package."""
    shipped = ContactBasis.load("finger")
    fewer = replace(shipped.provenance, k=3)
    ContactBasis(shipped.Psi[:, :3].copy(), fewer).save(tmp_path / "finger.basis")
    monkeypatch.chdir(tmp_path)
    assert load_setup("finger", basis="finger.basis").basis_modes == 3
    assert load_setup("finger", basis="finger").basis_modes == shipped.k


@pytest.mark.parametrize("suffix", ["basis", "states"])
def test_the_file_of_a_basis_of_another_robot_is_named(tmp_path: Path, suffix: str) -> None:
    """It was "this basis", of a file that may be in another folder than the robot file."""
    contact, model = 'rate = 50.0, basis = "other.basis"', 'model = { states = "other.states" }'
    if suffix == "basis":
        file = write_robot(tmp_path, ROBOT.replace("rate = 50.0", contact))
    else:
        file = write_robot(tmp_path, ROBOT.replace("[[cables]]", f"{model}\n\n[[cables]]", 1))
    shutil.copy(shipped_folder() / f"finger.{suffix}", tmp_path / f"other.{suffix}")
    said = (
        rf"^{tmp_path}/other\.{suffix}: this (state )?basis was made for robot 'finger', which is"
    )
    with pytest.raises((BasisError, StateBasisError), match=said):
        load_setup(file, model=None if suffix == "basis" else "reduced")
