"""Pictures are written whole, into a folder that may be new, and in the format of their suffix."""

from __future__ import annotations

import resource
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from tauten.service.plots.saving import save_figure


@pytest.mark.parametrize(
    ("name", "begin"), [("a.png", b"\x89PNG"), ("a.JPG", b"\xff\xd8"), ("a.svg", b"<?xml")]
)
def test_a_picture_is_drawn_into_a_new_folder(tmp_path: Path, name: str, begin: bytes) -> None:
    """Commands draw at their end, after minutes."""
    save_figure(Figure(), tmp_path / "new" / "one" / name, 50)
    assert (tmp_path / "new" / "one" / name).read_bytes().startswith(begin)


def test_a_full_disk_is_named_and_leaves_no_half_of_a_picture(tmp_path: Path) -> None:
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, hard))  # files cannot grow beyond this
    try:
        with pytest.raises(OSError, match="File too large") as refused:
            save_figure(Figure(), tmp_path / "a.png", 50)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert refused.value.filename == str(tmp_path / "a.png")
    assert not list(tmp_path.iterdir())
