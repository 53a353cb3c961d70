"""Ctrl-C in the equilibria of `tauten new` ends it, with the meshes that are compared."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import meshio
import pytest
from support.robots.bodies import box_mesh

from tauten.model.mesh import TetMesh
from tauten.service.new import CadPart, NewRobot, make, make_new_robot, read_part
from tauten.service.process import Interrupted, StopFlag

SIZES = (6e-3, 5e-3)


@pytest.fixture
def solid(tmp_path: Path) -> Path:
    """A file that holds tetrahedra, in metres."""
    path = tmp_path / "bar.vtu"
    mesh = box_mesh((0.06, 0.012, 0.012), (6, 2, 2))
    meshio.Mesh(mesh.nodes, [("tetra", mesh.tets)]).write(path)
    return path


@pytest.mark.long
def test_what_a_killed_command_left_is_not_in_the_way(solid: Path, tmp_path: Path) -> None:
    (tmp_path / ".bar.partial").mkdir()
    (tmp_path / "usual").mkdir()
    before = set(tmp_path.iterdir())
    new = NewRobot("bar", read_part(solid, "m", False))
    made = make_new_robot(new, tmp_path / "bar", StopFlag(), lambda share, what: None)
    assert made.file == tmp_path / "bar" / "bar.toml"
    assert set(tmp_path.iterdir()) - before == {tmp_path / "bar"}
    assert (tmp_path / "bar").stat().st_mode == (tmp_path / "usual").stat().st_mode


@pytest.mark.parametrize("done", [0, 1])
def test_ctrl_c_in_the_equilibria_keeps_the_meshes_that_are_compared(
    solid: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, done: int
) -> None:
    """The request comes during the equilibria of the mesh after `done` ones, as from a signal."""
    stop, part = StopFlag(), read_part(solid, "m", False)
    pulled, calls = make.pulled, [0]
    monkeypatch.setattr(make, "_meshes", lambda part, *_: [(s, part_mesh(part)) for s in SIZES])

    def part_mesh(part: CadPart) -> TetMesh:
        return make.mesh_part(part, 1.0)

    def interrupted(*arguments: Any) -> Any:
        calls[0] += 1
        if calls[0] > done:
            stop.request()
            raise AssertionError("the request has ended this")
        return pulled(*arguments)

    monkeypatch.setattr(make, "pulled", interrupted)
    new = NewRobot("bar", part)
    if not done:
        with pytest.raises(Interrupted):
            make_new_robot(new, tmp_path / "bar", stop, lambda share, what: None)
        assert not (tmp_path / "bar").exists()
        return
    made = make_new_robot(new, tmp_path / "bar", stop, lambda share, what: None)
    assert len(made.trials) == 1
    assert made.file.is_file()
