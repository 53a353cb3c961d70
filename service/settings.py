"""The tables `model` and `service` of a robot file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, ValidationInfo, field_validator

from tauten.model.load import robot_path
from tauten.model.schema import Name, Positive, Rate, Section, in_range, read_toml, validated


class ModelSettings(Section):
    """Which model decides: the full one, or that of a state basis with its sample of elements.

    While serving, the full model computes at intervals how far it would move the tip from where the reduced
    one has it. Where this exceeds `max_tip_error`, health warns, and with `fall_back` the full model takes
    over.
    """

    order: Literal["full", "reduced"] = Field(
        default="full", description="Which model, by default full."
    )
    states: str | None = Field(
        default=None,
        description="Name of the state basis, a .states file beside the robot file or a shipped one; by "
        "default the robot's name.",
    )
    max_tip_error: Annotated[Positive, in_range(0.0, 10.0, "m")] = Field(
        default=1e-3,
        description="Error of the tip that a reduced model may have [m], by default 1e-3.",
    )
    check_period: Annotated[Positive, in_range(1e-3, 3600.0, "s")] = Field(
        default=1.0,
        description="Time between two comparisons with the full model [s], by default 1.",
    )
    fall_back: bool = Field(
        default=False,
        description="Whether the full model replaces a reduced one that exceeds `max_tip_error`; by default "
        "not.",
    )
    fall_back_rate: Rate = Field(
        default=50.0, description="Control rate of the full model then [Hz], by default 50."
    )


class ServiceSettings(Section):
    """The node."""

    target_timeout: Annotated[Positive, in_range(1e-3, 60.0, "s")] = Field(
        default=0.5,
        description="Time without target after which the node holds [s], by default 0.5.",
    )
    release_time: Annotated[Positive, in_range(1e-3, 60.0, "s")] = Field(
        default=1.0, description="Least duration of a release [s], by default 1."
    )
    late_limit: Annotated[int, Field(ge=1, le=100_000)] = Field(
        default=25,
        description="Deadlines missed in a row after which the node holds, by default 25.",
    )
    measurement_timeout: Annotated[Positive, in_range(1e-3, 10.0, "s")] = Field(
        default=0.25,
        description="Time without measurement after which a closed loop holds [s], by default 0.25.",
    )
    feedback_gain: Annotated[Positive, in_range(0.0, 1e3, "1/s")] = Field(
        default=2.0,
        description="Gain with which a closed loop corrects targets [1/s], by default 2.",
    )
    estimator: Name = Field(
        default="feedback",
        description="What corrects targets in a closed loop: feedback (default), or one that an installed "
        "package adds.",
    )
    measurement_delay: Annotated[float, Field(ge=0.0, le=10.0)] = Field(
        default=0.0, description="Age of a measurement when it arrives [s], by default 0."
    )
    interpolation_delay: Annotated[float, Field(ge=0.0, le=10.0)] = Field(
        default=0.0,
        description="Delay with which targets are followed on straight lines between them [s], shorter than "
        "`target_timeout`; by default 0, the latest target is followed.",
    )

    @field_validator("interpolation_delay")
    @classmethod
    def _shorter_than_the_timeout(cls, delay: float, info: ValidationInfo) -> float:
        timeout = info.data.get("target_timeout", delay)  # missing where it is wrong itself
        if delay > 0.0 and not delay < timeout:
            raise ValueError(
                f"must be shorter than target_timeout, {timeout:g} s: targets are too old after it"
            )
        return delay


def load_model_settings(name_or_path: str | Path) -> ModelSettings:
    """The table `model` of a shipped robot's file, by name, or of a robot file.

    Raises:
        RobotFileError: the file, or its table `model`, cannot be used.
    """
    path = robot_path(name_or_path)
    return validated(ModelSettings, read_toml(path).get("model", {}), path, "model")
