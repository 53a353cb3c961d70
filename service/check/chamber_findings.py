"""What the surfaces of chambers in STL files are like."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tauten.model.actuators import inside_out
from tauten.model.mesh import read_triangles
from tauten.model.schema import RobotConfig
from tauten.service.check.findings import Finding


def chamber_findings(config: RobotConfig, folder: Path) -> Iterator[Finding]:
    """Whether the STL files of chambers have their normals out of the chamber.

    Args:
        config: the robot file, from which a robot can be built.
        folder: of the file.
    """
    for chamber in config.chambers:
        if chamber.stl is None:
            continue
        subject = f"chamber {chamber.name}"
        if inside_out(*read_triangles(folder / chamber.stl)):
            found = f"the surface in {chamber.stl} is inside out and has been turned"
            advice = "turn its triangles, so that their normals point out of the chamber"
            yield Finding(subject, "doubtful", found, advice)
        else:
            yield Finding(subject, "fine", f"the normals of {chamber.stl} point out of it")
