"""Lines that a command writes into a robot file: nothing else of it changes."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from tauten.model import RobotFileError
from tauten.service.new import set_fields

FIELDS = {"controller": {"basis": "arm.basis"}, "model": {"order": "reduced"}}


def written(folder: Path, text: str) -> str:
    """A file with the fields set."""
    file = folder / "arm.toml"
    file.write_text(text, encoding="utf-8")
    set_fields(file, FIELDS)
    return file.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "text",
    [
        'name = "arm"  # mine\n',
        'name = "arm"\n[controller]   # decisions\nrate = 50.0  # Hz\n\n[[cables]]\nname = "c"\n',
        'name = "arm"\n[model]\norder = "full"  # now\n[controller]\nbasis = \'none\' # yet\nrate = 1.0',
        'name = "arm"\n[controller]',
    ],
)
def test_fields_are_set_and_comments_stay(tmp_path: Path, text: str) -> None:
    after = written(tmp_path, text)
    before, now = tomllib.loads(text), tomllib.loads(after)
    assert now["controller"] == before.get("controller", {}) | FIELDS["controller"]
    assert now["model"] == before.get("model", {}) | FIELDS["model"]
    assert {k: v for k, v in now.items() if k not in FIELDS} == {
        k: v for k, v in before.items() if k not in FIELDS
    }
    for line in text.splitlines():
        if "#" in line:
            assert line[line.index("#") :] in after
    assert written(tmp_path, after) == after


def test_a_table_in_another_form_is_left_alone(tmp_path: Path) -> None:
    text = 'name = "arm"\ncontroller = { rate = 50.0 }\n'
    with pytest.raises(RobotFileError, match=r"has no line \[controller\]"):
        written(tmp_path, text)
    assert (tmp_path / "arm.toml").read_text(encoding="utf-8") == text
