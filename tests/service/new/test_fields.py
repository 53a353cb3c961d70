"""Lines that a command writes into a robot file: nothing else of it changes."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from tauten.model import RobotFileError
from tauten.service.new import fields_text, set_fields

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
        'name = "arm"\n[controller]\n"basis" = "old \\"one\\"" # yet\n[model]\n\'order\' = "full"\n',
        'name = "arm"\nnotes = """\n[controller]\nbasis = "x"\n"""\n[controller]\nrate = 1.0  # Hz\n',
        'name = "arm"\nnotes = """\n[controller]\n"""\n',
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


def test_a_link_remains_and_its_file_keeps_its_permissions(tmp_path: Path) -> None:
    text, link = 'name = "arm"\n[controller]\n', tmp_path / "link.toml"
    (tmp_path / "arm.toml").write_text(text, encoding="utf-8")
    (tmp_path / "arm.toml").chmod(0o640)
    link.symlink_to("arm.toml")
    set_fields(link, FIELDS)
    assert link.is_symlink() and "arm.basis" in (tmp_path / "arm.toml").read_text(encoding="utf-8")
    assert (tmp_path / "arm.toml").stat().st_mode & 0o777 == 0o640


def test_a_table_in_another_form_is_left_alone(tmp_path: Path) -> None:
    text = 'name = "arm"\ncontroller = { rate = 50.0 }\n'
    with pytest.raises(RobotFileError, match=r"has no line \[controller\]") as error:
        written(tmp_path, text)
    assert '\n[controller]\nbasis = "arm.basis"' in str(error.value)
    assert (tmp_path / "arm.toml").read_text(encoding="utf-8") == text


def test_what_would_not_be_read_so_is_left_alone(tmp_path: Path) -> None:
    text = 'name = "arm"\n[controller]\nbasis = """\nold"""\n'
    with pytest.raises(RobotFileError, match="by hand"):
        written(tmp_path, text)
    assert (tmp_path / "arm.toml").read_text(encoding="utf-8") == text


@pytest.mark.parametrize("name", ['a "b"/arm.basis', "a\\b/arm.basis", "d'e\x7fé\t/arm.basis"])
def test_any_name_of_a_file_is_written_as_it_is(tmp_path: Path, name: str) -> None:
    file = tmp_path / "arm.toml"
    file.write_text('name = "arm"\n', encoding="utf-8")
    for _ in range(2):
        set_fields(file, {"controller": {"basis": name}})
        assert tomllib.loads(file.read_text(encoding="utf-8"))["controller"] == {"basis": name}
    assert tomllib.loads(fields_text({"t": {"f": name}})) == {"t": {"f": name}}
