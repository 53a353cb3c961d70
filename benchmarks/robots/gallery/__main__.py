"""Makes the robots of the gallery: `python -m benchmarks.robots.gallery [FOLDER]`."""

from __future__ import annotations

import sys
from pathlib import Path

from benchmarks.robots.gallery import ROBOTS
from tauten.model.load import shipped_folder


def main() -> None:
    """Write robot files and meshes into the folder given, by default that of the shipped robots."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else shipped_folder()
    for make in ROBOTS.values():
        for line in make(folder):
            print(line)


if __name__ == "__main__":
    main()
