"""What the caller of `load_robot` changes in a robot file."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from tauten.model.schema.robot_file import BackEnd, Threads
from tauten.model.schema.section import Rate, Section, in_range


class Changes(Section):
    """The arguments with which `load_robot` changes a robot file."""

    rate: Rate | None = Field(default=None, description="Control rate [Hz].")
    refinements: Annotated[int, Field(ge=0, le=4)] = Field(
        default=0,
        description="How often every tetrahedron is cut into eight, and every beam into two.",
    )
    factorisation: BackEnd | None = Field(default=None, description="Sparse factorisation.")
    threads: Threads | None = Field(
        default=None, description="Threads of the sparse factorisation."
    )
    young_scale: Annotated[float, in_range(1e-6, 1e6, "")] = Field(
        default=1.0, description="Factor of Young's modulus, unitless."
    )
