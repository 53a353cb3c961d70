"""Pages that name no extra run where none is installed."""

from __future__ import annotations

import re
import subprocess
import venv
from pathlib import Path

import film_strip
import pytest

README = (Path(__file__).resolve().parents[1] / "README.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_python_of_the_readme_and_the_lessons_need_no_extra(tmp_path: Path) -> None:
    """In an environment of their own, with `pip install -e .` as the index of the lessons says."""
    (tmp_path / "clone").mkdir()
    clone, environment = film_strip.copy_of_repository(tmp_path / "clone"), tmp_path / "venv"
    venv.create(environment, with_pip=True)
    done = subprocess.run(
        [environment / "bin" / "pip", "install", "-q", "-e", "."],
        cwd=clone, capture_output=True, text=True,
    )  # fmt: skip
    if done.returncode:
        pytest.skip(f"packages cannot be installed here: {done.stderr.strip().splitlines()[-1]}")
    python = environment / "bin" / "python"
    assert subprocess.run([python, "-c", "import viser"], capture_output=True).returncode
    subprocess.run([python, "docs/scripts/lessons.py"], cwd=clone, check=True)
    for code in re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL):
        subprocess.run([python, "-c", code], cwd=clone, check=True)
