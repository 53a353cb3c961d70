"""`tauten schema`: the JSON Schema accepts what loads, refuses what does not, and describes every field."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from support.processes import ROBOT, run_main

from tauten.model.schema import Section
from tauten.service.file_schema import PartsRobotFile, RobotFile, robot_file_schema

ROOT = Path(__file__).resolve().parents[2]
FILES = [*(ROOT / "model" / "robots").glob("**/*.toml"), *(ROOT / "tests").glob("**/*.toml")]


def described(schema: dict[str, Any]) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Table, field and schema of every field of all tables."""
    for table, contents in schema["$defs"].items():
        for field, properties in contents.get("properties", {}).items():
            yield table, field, properties


def test_every_field_has_a_description() -> None:
    fields = list(described(robot_file_schema()))
    assert len(fields) > 80
    assert (
        not [  # a kind that can only be one is described by its table
            f"{table}.{field}"
            for table, field, rest in fields
            if not {"description", "const"} & set(rest)
        ]
    )


@pytest.fixture(scope="module")
def schema() -> jsonschema.Draft202012Validator:
    """The schema, which is one."""
    found = robot_file_schema()
    jsonschema.Draft202012Validator.check_schema(found)
    return jsonschema.Draft202012Validator(found)


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_files_that_load_are_valid(schema: jsonschema.Draft202012Validator, file: Path) -> None:
    schema.validate(tomllib.loads(file.read_text()))


@pytest.mark.parametrize(
    ("found", "wrong"),
    [
        ("rate = 50.0", "rate = -1.0"),  # of a range
        ("rate = 50.0", "speed = 50.0"),  # no such field
        ("rayleigh_stiffness = 0.02", 'scheme = "explicit"'),
        ("young_modulus", "c01"),  # not enough for a material
    ],
)
def test_files_that_do_not_load_are_not_valid(
    schema: jsonschema.Draft202012Validator, found: str, wrong: str
) -> None:
    schema.validate(tomllib.loads(ROBOT))
    assert found in ROBOT
    with pytest.raises(jsonschema.ValidationError):
        schema.validate(tomllib.loads(ROBOT.replace(found, wrong)))


def test_command_prints_it(capsys: pytest.CaptureFixture[str]) -> None:
    assert run_main("schema") == 0
    assert json.loads(capsys.readouterr().out) == robot_file_schema()


def numbers(tree: Any, way: Sequence[str | int] = ()) -> Iterator[tuple[str | int, ...]]:
    """Where the numbers of nested tables and lists are, of each list only the first."""
    if isinstance(tree, dict):
        for key, value in tree.items():
            yield from numbers(value, (*way, key))
    elif isinstance(tree, list):
        yield from numbers(tree[0], (*way, 0)) if tree else ()
    elif isinstance(tree, int | float) and not isinstance(tree, bool):
        yield tuple(way)


@pytest.mark.versions
@pytest.mark.parametrize(
    ("kind", "file"),
    [
        (RobotFile, "model/robots/finger.toml"),
        (RobotFile, "model/robots/pneumatic_finger.toml"),
        (RobotFile, "examples/tentacle.toml"),
        (RobotFile, "examples/fork.toml"),
        (RobotFile, "model/robots/manipulator.toml"),
        (PartsRobotFile, "examples/lift.toml"),
    ],
)
@pytest.mark.parametrize("wrong", [True, "1"])
def test_no_number_may_be_true_or_a_text(kind: type[Section], file: str, wrong: bool | str) -> None:
    """`min_force = true` is no newton: every number of every table, but texts where functions take them."""
    contents = tomllib.loads((ROOT / file).read_text())
    kind.model_validate(contents)
    found = [way for way in numbers(contents) if wrong is True or "parameters" not in way]
    assert len(found) >= 3
    for *way, key in found:
        table = contents
        for step in way:
            table = table[step]
        right, table[key] = table[key], wrong
        with pytest.raises(ValueError, match="Input should be a valid"):
            kind.model_validate(contents)
        table[key] = right


@pytest.mark.parametrize("found", [100.0, np.int64(100), np.float64(100.0)])
def test_whole_numbers_may_be_floats_or_of_numpy(
    schema: jsonschema.Draft202012Validator, found: float | np.number
) -> None:
    """JSON Schema calls 100.0 an integer, and so does what loads the file."""
    contents = tomllib.loads(ROBOT)
    contents.setdefault("controller", {})["max_pivots"] = found
    loaded = RobotFile.model_validate(contents).controller.max_pivots
    assert (loaded, type(loaded)) == (100, int)
    contents["controller"]["max_pivots"] = found.item() if isinstance(found, np.generic) else found
    schema.validate(contents)
    contents["controller"]["max_pivots"] = 100.5
    with pytest.raises(ValueError, match="a number with a fractional part"):
        RobotFile.model_validate(contents)
    with pytest.raises(jsonschema.ValidationError):
        schema.validate(contents)
