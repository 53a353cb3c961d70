"""The lessons run as they are written, each in a folder of its own, and leave the picture that they show."""

from __future__ import annotations

from pathlib import Path

import lessons
import pytest

SHORT = ("1-see-it-move", "2-inverse-problem", "6-own-part")  # the others take several seconds each


@pytest.mark.long
@pytest.mark.parametrize(
    "page",
    [
        pytest.param(page, id=page.stem, marks=[] if page.stem in SHORT else pytest.mark.slow)
        for page in lessons.LESSONS
    ],
)
def test_it_runs_as_written(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    picture = lessons.run(page)
    assert picture.stat().st_size > 10_000
    assert f"(../figures/lesson-{picture.name})" in page.read_text(encoding="utf-8")


def test_there_are_six_and_each_ends_with_a_question() -> None:
    assert len(lessons.LESSONS) == 6
    for page in lessons.LESSONS:
        end = page.read_text(encoding="utf-8").splitlines()[-5:]
        assert any(line.startswith("**Question.**") for line in end), page.name
