"""Makes the robots of the gallery: `python -m tauten.model.robots.gallery [FOLDER]`."""

from __future__ import annotations

import sys
from pathlib import Path

from tauten.model.robots.gallery import make_diamond, make_trunk


def main() -> None:
    """Write robot files and meshes into the folder given, by default that of the shipped robots."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1]
    for make in (make_trunk, make_diamond):
        for line in make(folder):
            print(line)


if __name__ == "__main__":
    main()
