"""`tauten schema`: the JSON Schema accepts what loads, refuses what does not, and describes every field."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from support.processes import ROBOT, run_main

from tauten.service.file_schema import robot_file_schema

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
