"""What all tables of the robot file have in common."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, model_validator

Vector = tuple[float, float, float]


class Section(BaseModel):
    """A table of the robot file: unknown keys and non-finite numbers are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Box(Section):
    """Nodes, elements or triangles between two corners [m]."""

    lower: Vector
    upper: Vector

    @model_validator(mode="after")
    def _ordered(self) -> Box:
        if any(low > high for low, high in zip(self.lower, self.upper, strict=True)):
            raise ValueError(f"lower {self.lower} must not exceed upper {self.upper}")
        return self
