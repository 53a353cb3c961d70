"""The digest of a robot follows its description, says what differs, and depends on nothing computed."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from support.robots.bodies import beam_config, box_mesh
from support.robots.short_arm import COUPLING, short_arm, write_short_arm
from support.robots.small_bodies import rigid_box

from tauten.model.load import build_robot, load_robot
from tauten.model.schema import RobotConfig, differences

SIZE = (0.1, 0.02, 0.02)
TENDON = beam_config(SIZE)["cables"][0]  # type: ignore[index]
TOP = {"lower": [0.0, 0.0, 0.02], "upper": [0.1, 0.02, 0.02]}
BOTTOM = {"lower": [0.0, 0.0, 0.0], "upper": [0.1, 0.02, 0.0]}
FACES: dict[str, Any] = {
    "surfaces": [{"name": "top", "box": TOP}, {"name": "bottom", "box": BOTTOM}],
    "contacts": [{"candidates": "top", "against": "bottom", "points": 6}],
}
SECOND = {**TENDON, "name": "other", "points": [[0.01, 0.01, 0.018], [0.1, 0.01, 0.018]]}
MOTOR = {
    "name": "motor", "members": ["tendon", "other"], "gains": [1.0, 0.5], "max_position": 0.02,
    "max_effort": 9.0, "max_rate": 0.1,
}  # fmt: skip


def digest(cells: int = 4, **changes: object) -> str:
    config = RobotConfig.model_validate(beam_config(SIZE, **{**FACES, **changes}))
    return build_robot(config, box_mesh(SIZE, (cells, 2, 2)), "beam.toml").digest


@pytest.mark.parametrize(
    ("changes", "part"),
    [
        ({"cells": 5}, "mesh"),
        ({"mesh": {"file": "beam.vtu", "element": "smoothed"}}, "mesh"),
        ({"material": {"young_modulus": 2e6, "poisson_ratio": 0.3, "density": 1e3}}, "materials"),
        ({"fixed": [{"lower": [0, 0, 0], "upper": [0.03, 1, 1]}]}, "supports"),
        ({"cables": [{**TENDON, "points": [[0.02, 0.01, 0.002], [0.1, 0.01, 0.002]]}]}, "cables"),
        ({"cables": [{**TENDON, "spring": {"stiffness": 1e3}}]}, "cables"),
        ({"contacts": [{"candidates": "top", "against": "bottom", "points": 7}]}, "contacts"),
        ({"surfaces": [{"name": "top", "box": TOP},
                       {"name": "bottom", "box": BOTTOM, "normal": [0, 0, -1]}]}, "contacts"),
        ({"cables": [TENDON, SECOND], "couplings": [MOTOR]}, "cables and couplings"),
    ],
)  # fmt: skip
def test_what_differs_is_said(changes: dict[str, Any], part: str) -> None:
    assert differences(digest(), digest(**changes)) == part


@pytest.mark.parametrize(
    "changes",
    [
        {"gravity": [0.0, 0.0, -1.0], "controller": {"rate": 200.0}},
        {"cables": [{**TENDON, "name": "pull", "max_tension": 3.0, "min_pull": -0.01}]},
        {"integration": {"rayleigh_mass": 0.1}, "contact": {"tolerance": 1e-6}},
        {"mesh": {"file": "other.vtu", "element": "linear"}},
        {"regions": [{"name": "lid", **TOP}],
         "contacts": [{"candidates": "lid", "against": "bottom", "points": 6}]},
    ],
)  # fmt: skip
def test_loads_limits_names_and_defaults_do_not_count(changes: dict[str, Any]) -> None:
    assert differences(digest(), digest(**changes)) == ""


def test_couplings_and_springs_count_in_robots_of_every_kind(tmp_path: Path) -> None:
    """They were missing where a robot has constraints, or is made of beams."""

    def box(gain: float) -> str:
        motor = {**MOTOR, "gains": [1.0, gain]}
        return rigid_box(cables=[TENDON, SECOND], couplings=[motor]).digest

    assert differences(box(0.5), box(0.6)) == "couplings"
    plain, coupled = short_arm(tmp_path).digest, short_arm(tmp_path, COUPLING).digest
    assert differences(plain, coupled) == "couplings"
    other = short_arm(tmp_path, COUPLING.replace("-0.5", "-0.6")).digest
    assert differences(coupled, other) == "couplings"


def test_digests_of_other_versions_are_said_to_be_such() -> None:
    old = "b76f18efae996be84bcf7c56163fc57544d122b0e0bffd7687d271da3375b85c"
    assert differences(old, digest()) == "versions of the model"


FOUND = """
import hashlib, json, sys
from tauten.model.load import load_robot
def found_here(name):
    robot = load_robot(name)
    slots = [[pair.nodes.tolist(), pair.weights.round(9).tolist()] for pair in robot.contacts.pairs]
    return [robot.digest, hashlib.sha256(json.dumps(slots).encode()).hexdigest()]
print(json.dumps([found_here(name) for name in sys.argv[1:]]))
"""


def found_by_interpreter(names: list[str]) -> list[list[str]]:
    """Digest and candidates of robots in a process in which no kernel is compiled."""
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    command = [sys.executable, "-c", FOUND, *names]
    text = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    answer: list[list[str]] = json.loads(text.stdout)
    return answer


def found_here(name: str) -> list[str]:
    """The same in this process."""
    robot = load_robot(name)
    slots = [[pair.nodes.tolist(), pair.weights.round(9).tolist()] for pair in robot.contacts.pairs]
    return [robot.digest, hashlib.sha256(json.dumps(slots).encode()).hexdigest()]


@pytest.mark.long
def test_digest_and_candidates_are_the_same_however_kernels_run(tmp_path: Path) -> None:
    """Candidates are placed by searches, in which symmetric meshes have ties."""
    file = str(write_short_arm(tmp_path))
    assert found_by_interpreter([file]) == [found_here(file)]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["finger", "pneumatic_finger", "manipulator_1290", "gripper"])
def test_shipped_robots_are_the_same_however_kernels_run(name: str) -> None:
    assert found_by_interpreter([name]) == [found_here(name)]
