"""Ctrl-C in `tauten reduce` before the first equilibria are saved."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.processes import run_main

from tauten.service.cli.campaigns import Campaigns


def test_ctrl_c_before_anything_is_saved_names_no_folder_that_keeps_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(_self: Campaigns) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Campaigns, "whole", interrupted)
    files = ("--out", tmp_path / "finger.basis", "--snapshots", tmp_path / "cut")
    assert run_main("reduce", "finger", *files) == 130
    assert "stopped: nothing is finished yet" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
