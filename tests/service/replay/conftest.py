"""A recorded run."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.processes import write_robot
from support.recorded_run import HEAVY, write_run

from tauten.service.setup import load_setup


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("run")  # a replay opens files beside the log
    file = write_robot(folder, HEAVY)
    write_run(load_setup(file), folder / "log.mcap")
    return folder / "log.mcap"
