"""The examples of docs/actuators.md are tables of a robot file that can be built."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest
from support.robots.bodies import CABLE, hollow_beam, pneumatic_config

from tauten.model.load import build_robot
from tauten.model.schema import RobotConfig, validated

PAGE = (Path(__file__).parents[3] / "docs" / "actuators.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```toml\n(.*?)```", PAGE, flags=re.DOTALL)


def test_there_are_examples_of_all_tables() -> None:
    assert {name for block in BLOCKS for name in tomllib.loads(block)} == {
        "cables", "chambers", "forces", "couplings",
    }  # fmt: skip


@pytest.mark.parametrize("block", BLOCKS, ids=lambda block: block.split("\n", maxsplit=1)[0])
def test_an_example_makes_a_robot(block: str) -> None:
    upper = {**CABLE, "name": "upper", "points": [[0.01, 0.01, 0.018], [0.1, 0.01, 0.018]]}
    tables = {"cables": [{**CABLE, "name": "lower"}, upper], **tomllib.loads(block)}
    config = validated(RobotConfig, pneumatic_config(**tables), "page.toml")
    robot = build_robot(config, hollow_beam(), "page.toml")
    assert set(tomllib.loads(block)) <= set(config.model_fields_set)
    assert robot.n_a == len(config.actuators)
