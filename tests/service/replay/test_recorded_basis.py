"""The contact basis of a log, where the log has it by a name alone."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from support.recorded_run import with_entry

from tauten.model.load import shipped_folder
from tauten.service.log import LogError, LogReader
from tauten.service.replay.recorded_setup import recorded_setup


@pytest.mark.parametrize("name", ["thumb", "soft.v2", "thumb.basis"])
def test_a_basis_by_name_is_that_beside_the_log_or_on_request_the_recorded_one(
    log: Path, name: str, tmp_path: Path
) -> None:
    """Of a robot file that was copied beside the log, one with a dot in its name was never found."""
    own, away, file = tmp_path / "own", tmp_path / "away", f"{name.removesuffix('.basis')}.basis"
    for folder in (own, away):
        folder.mkdir()
        shutil.copy(log.parent / "beam.toml", folder)
        (folder / file).touch()
    metadata = LogReader(log).read_metadata()
    metadata["description"] = with_entry(metadata["description"], "basis.name", name)
    metadata["robot_path"] = str(own / "beam.toml")
    found = recorded_setup(away / "log.mcap", metadata)
    assert found.contact_basis(False) == name
    (away / file).unlink()
    with pytest.raises(LogError, match=f"with the basis {name} beside .*: allow recorded paths"):
        found.contact_basis(False)
    assert found.contact_basis(True) == str(own / file)
    (away / "beam.toml").unlink()  # the recorded robot file names the one beside it
    assert found.contact_basis(True) == name


def test_the_basis_of_a_shipped_robot_is_shipped(log: Path) -> None:
    """Its log has the path of the robot in the installation, and may be replayed by another one."""
    metadata = LogReader(log).read_metadata()
    metadata["robot_path"] = str(shipped_folder() / "finger.toml")
    for place, value in (("robot", "finger"), ("basis.name", "finger")):
        metadata["description"] = with_entry(metadata["description"], place, value)
    assert recorded_setup(log, metadata).contact_basis(False) == "finger"
