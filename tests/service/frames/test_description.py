"""A node's description as a viewer reads it: a robot, or one sentence; never markup in a name."""

from __future__ import annotations

import json
import random
from pathlib import Path
from typing import Any

import pytest

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
