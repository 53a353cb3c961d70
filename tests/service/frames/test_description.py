"""A node's description as a viewer reads it: a robot, or one sentence; never markup in a name."""

from __future__ import annotations

import base64
import json
import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.processes import ROBOT, write_robot

from tauten.model import obstacles_of
from tauten.service.describing import describe
from tauten.service.setup import load_setup
from tauten.service.wire import NetworkError
from tauten.service.wire.description import read_description

ODD: tuple[object, ...] = (
    None, True, -1, 0, 10**400, 1e308, "", "x", "<img src=x onerror=stop()>", "a b", "../x", "\0", [], {},
    [[]] * 3, "AAAA", "A" * 5,
)  # fmt: skip


@pytest.fixture(scope="module")
def honest(beam_file: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(describe(load_setup(beam_file)).as_json())
    return found


def doctored(value: Any, change: random.Random) -> Any:
    """A description of which some values are others, and some entries are missing."""
    if change.random() < 0.03:
        return change.choice(ODD)
    if isinstance(value, dict):
        return {k: doctored(v, change) for k, v in value.items() if change.random() > 0.004}
    if isinstance(value, list):
        return [doctored(one, change) for one in value]
    return value


def test_a_doctored_description_is_read_or_refused(honest: dict[str, Any]) -> None:
    read = 0
    for seed in range(400):
        payload = json.dumps(doctored(honest, random.Random(seed))).encode()
        try:
            found = read_description("beam", payload)
        except NetworkError as error:
            assert str(error).startswith("the node of 'beam'")
            assert "<img" not in str(error)
            assert len(str(error)) < 400
            continue
        parts = (*found.actuators, *found.effectors)
        names = [found.name, found.frame, *(one.name for one in parts)]
        assert all(name.isidentifier() for name in names), names
        read += 1
    assert 20 < read < 380


def test_a_slow_robot_has_the_timeout_that_its_node_keeps(tmp_path: Path) -> None:
    setup = load_setup(write_robot(tmp_path, ROBOT.replace("rate = 50.0", "rate = 1.0")))
    assert setup.service.target_timeout == pytest.approx(0.3)
    assert describe(setup).target_timeout == pytest.approx(3.0 * setup.robot.h)


@pytest.mark.long
def test_many_round_obstacles_fit_in_an_answer(tmp_path: Path) -> None:
    """Balls and rods are sent as they are made; what is read has the surfaces that were described."""
    table = ""
    for i in range(60):
        shape = (
            'shape = "sphere"\nparameters = { centre = [0.0, 0.0, 0.0], radius = 0.01 }',
            'shape = "cylinder"\n'
            "parameters = { start = [0.0, 0.0, 0.0], end = [0.0, 0.02, 0.0], radius = 0.01 }",
            'shape = "box"\nparameters = { lower = [0.0, 0.0, 0.0], upper = [0.01, 0.02, 0.03] }',
        )[i % 3]
        table += f'[[obstacles]]\nname = "one{i}"\n{shape}\nposition = [0.5, 0.0, {0.1 * i}]\n'
        table += f'[[contacts]]\nagainst = "one{i}"\npoints = 1\n'
    setup = load_setup(write_robot(tmp_path, ROBOT + table))
    payload = describe(setup).as_json().encode()
    assert len(payload) < 2**17
    found = read_description("beam", payload).surface.obstacles
    outlines = obstacles_of(setup.robot)
    assert len(found) == len(outlines) == 60
    for one, outline in list(zip(found, outlines, strict=True))[:6]:
        vertices, triangles = one.outline
        np.testing.assert_allclose(vertices, outline.vertices, atol=1e-8)
        np.testing.assert_array_equal(triangles, outline.triangles)


def test_points_of_an_obstacle_are_numbers_in_base64(honest: dict[str, Any]) -> None:
    found = json.loads(json.dumps(honest))
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.5]], "<f4")
    coded = {
        "vertices": base64.b64encode(vertices.tobytes()).decode(),
        "triangles": "AAAAAAEAAAACAAAA",
    }
    found["surface"]["obstacles"] = [{"name": "triangle", **coded}]
    (triangle,) = read_description("beam", json.dumps(found).encode()).surface.obstacles
    np.testing.assert_array_equal(triangle.outline[0], vertices)
    np.testing.assert_array_equal(triangle.outline[1], [[0, 1, 2]])
    spoiled = (np.array([0.0, bad, 0.0], "<f4") for bad in (np.nan, 1e30))
    texts = [base64.b64encode(one.tobytes()).decode() for one in spoiled]
    for wrong in (*texts, "AAAA", "AAA", vertices.tolist(), [[1, 2, "x"]], 5, None):
        found["surface"]["obstacles"][0]["vertices"] = wrong
        with pytest.raises(NetworkError, match="vertices"):
            read_description("beam", json.dumps(found).encode())


@pytest.mark.parametrize("place", ["robot", "frame", "actuators", "effectors"])
def test_a_name_is_one_that_a_robot_file_may_have(honest: dict[str, Any], place: str) -> None:
    found = json.loads(json.dumps(honest))
    assert read_description("beam", json.dumps(found).encode()).name == "beam"
    if place in ("robot", "frame"):
        found[place] = "<b>x</b>"
    else:
        found[place][0]["name"] = "<b>x</b>"
    with pytest.raises(NetworkError, match=place):
        read_description("beam", json.dumps(found).encode())
