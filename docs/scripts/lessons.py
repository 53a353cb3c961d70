"""Runs the lessons as they are written and takes their pictures.

    python docs/scripts/lessons.py [NAME ...]

Each page of docs/lessons is a program: its blocks of Python, one after the other. The picture that it saves
as NAME.png is kept as docs/figures/lesson-NAME.png.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import tempfile
import time
from pathlib import Path
from typing import Any

DOCS = Path(__file__).resolve().parents[1]
LESSONS = sorted((DOCS / "lessons").glob("[0-9]-*.md"))
BLOCK = re.compile(r"^```python\n(.*?)^```", re.DOTALL | re.MULTILINE)


def run(page: Path) -> Path:
    """Run a lesson in the present folder; the picture that it leaves there."""
    names: dict[str, Any] = {}
    for code in BLOCK.findall(page.read_text(encoding="utf-8")):
        exec(compile(code, str(page), "exec"), names)
    (picture,) = Path().glob("*.png")
    return picture.resolve()


def main() -> None:
    """Run lessons, and keep their pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="such as 3-contact; default: all")
    chosen = parser.parse_args().names
    home = Path.cwd()
    for page in LESSONS:
        if chosen and page.stem not in chosen:
            continue
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            started = time.perf_counter()
            picture = run(page)
            print(f"{page.stem}: {time.perf_counter() - started:.1f} s")
            shutil.copy(picture, DOCS / "figures" / f"lesson-{picture.name}")
            os.chdir(home)


if __name__ == "__main__":
    main()
