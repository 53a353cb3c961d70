"""Makes the meshes of the examples with friction: `python -m benchmarks.robots.grasping [FOLDER]`."""

from __future__ import annotations

import sys
from pathlib import Path

from benchmarks.robots.grasping import MESHES

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"


def main() -> None:
    """Write the meshes into the folder given, by default that of the examples."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else EXAMPLES
    for make in MESHES.values():
        for line in make(folder):
            print(line)


if __name__ == "__main__":
    main()
