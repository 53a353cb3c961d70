"""A node that serves a robot with a cable and a chamber: targets, locks, log, replay, release."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest
from support.nodes import check_limits, recorded, streaming, wait_for, wait_health, wait_tip
from support.processes import Served, run_main
from support.robots.bodies import hollow_beam

from tauten.model import Robot, Simulator, load_robot
from tauten.service.replay import replay
from tauten.service.wire import CDR, Joints, decode_joints

ROBOT = """\
name = "beam"
frame = "beam_base"
gravity = [0.0, 0.0, 0.0]
mesh = { file = "beam.vtu" }
material = { young_modulus = 5e5, poisson_ratio = 0.3, density = 1000.0 }
fixed = [{ lower = [0.0, 0.0, 0.0], upper = [0.0, 0.02, 0.02] }]
integration = { rayleigh_stiffness = 0.02 }
controller = { rate = 50.0 }
service = { target_timeout = 0.3, release_time = 0.4, late_limit = 100000 }

[[cables]]
name = "tendon"
points = [[0.01, 0.01, 0.018], [0.1, 0.01, 0.018]]
max_tension = 20.0
max_pull = 0.02
max_rate = 0.05

[[chambers]]
name = "bellows"
inside = [0.05, 0.01, 0.0125]
min_pressure = -2e3
max_pressure = 4e4
max_volume_change = 4e-6
max_rate = 1e-5

[[effectors]]
name = "tip"
point = [0.1, 0.01, 0.01]
"""


@pytest.fixture(scope="module")
def beam_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The file of a robot with a cable and a chamber; it stands in for that of the small robot."""
    folder = tmp_path_factory.mktemp("balloon")
    mesh = hollow_beam()
    meshio.Mesh(mesh.nodes, {"tetra": np.asarray(mesh.tets)}).write(folder / "beam.vtu")
    file = folder / "beam.toml"
    file.write_text(ROBOT)
    return file


@pytest.fixture(scope="module")
def beam(beam_file: Path) -> Robot:
    return load_robot(beam_file)


def tip_at(beam: Robot, position: float, pressure: float) -> list[float]:
    """Where the tip is under a pulled length and a pressure [m]."""
    simulator = Simulator(beam, contact="none")
    assert simulator.settle(position=[position, np.nan], effort=[np.nan, pressure]).converged
    found: list[float] = simulator.effector[0].tolist()
    return found


def wait_joints(served: Served, beam: Robot, i: int, position: float | None, effort: float) -> None:
    """Wait until position or effort of an actuator leave as wanted."""

    def reached(payload: bytes) -> bool:
        joints = decode_joints(payload, CDR, beam.actuators.names)
        assert isinstance(joints, Joints)
        if position is not None:
            return joints.position[i] == pytest.approx(position)
        return joints.effort[i] == pytest.approx(effort)

    wait_for(served, served.keys.actuation, reached, f"actuator {i} at {position}, {effort}")


@pytest.mark.long
def test_targets_locks_and_a_replay_of_both(
    served: Served, beam: Robot, capsys: pytest.CaptureFixture[str]
) -> None:
    by_cable = tip_at(beam, 0.003, 0.0)
    port = ("--port", served.port)
    with streaming(served, by_cable):
        wait_tip(served, served.keys.effectors(("tip",))[0], by_cable, 5e-4)
        assert run_main("lock", "beam", "bellows", "--force", "5000", *port) == 0
        assert "beam: lock bellows force 5000.0, " in capsys.readouterr().out
        wait_joints(served, beam, 1, None, 5e3)
        health = wait_health(served, lambda found: found["locks"].message != "none")
        assert health["locks"].message == "bellows at pressure 5000 Pa"
        assert run_main("lock", "beam", "tendon", "--position", "0.004", *port) == 0
        wait_joints(served, beam, 0, 0.004, 0.0)
        assert run_main("unlock", "beam", "tendon", *port) == 0
        assert run_main("unlock", "beam", "bellows", *port) == 0
        wait_tip(served, served.keys.effectors(("tip",))[0], by_cable, 5e-4)
    assert served.process.end() == 0
    ticks, joints, _ = recorded(served.log, beam)
    check_limits(joints, beam)
    assert len(ticks) > 50
    last = joints[-1]
    assert (last.position, last.effort) == (
        (0.0, 0.0),
        (0.0, 0.0),
    )  # released to the outer pressure
    result = replay(served.log, 1e-6, recorded_paths=True)
    assert result.same, (result.fraction, result.worst_tick, result.statuses)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (
            ("lock", "beam", "bellows", "--force", "1e6"),
            "chamber bellows at a pressure of 1e+06 Pa: allowed are -2000 to 40000 Pa",
        ),
        (
            ("lock", "beam", "tendon", "--position=-0.1"),
            "cable tendon at a pull of -0.1 m: allowed are 0 to 0.02 m",
        ),
        (("lock", "beam", "pump", "--force", "1"), "its actuators are tendon, bellows"),
        (("unlock", "beam", "pump"), "its actuators are tendon, bellows"),
        (("lock", "beam", "tendon"), "give either --position or --force"),
    ],
)
def test_a_lock_that_is_not_possible_is_refused(
    shared: Served, arguments: tuple[str, ...], text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run_main(*arguments, "--port", shared.port) == 2
    assert text in " ".join(capsys.readouterr().err.replace("│", " ").split())
