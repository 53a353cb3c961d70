"""The table `service` of a robot file."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, ValidationInfo, field_validator

from tauten.model.schema import Name, Positive, Section, in_range

LEAST_PERIODS = 3.0  # what arrives once a period is read at the next tick, and one may come late


def lasting_timeout(timeout: float, period: float) -> float:
    """A timeout of three periods at least [s]."""
    return max(timeout, LEAST_PERIODS * period)


class ServiceSettings(Section):
    """The node."""

    target_timeout: Annotated[Positive, in_range(1e-3, 60.0, "s")] = Field(
        default=0.5,
        description="Time without target after which the node holds [s], by default 0.5; three periods of "
        "the controller at least.",
    )
    release_time: Annotated[Positive, in_range(1e-3, 60.0, "s")] = Field(
        default=1.0, description="Least duration of a release [s], by default 1."
    )
    late_limit: Annotated[int, Field(ge=1, le=100_000)] = Field(
        default=25,
        description="Deadlines missed in a row after which the node holds, by default 25.",
    )
    decision_share: Annotated[float, Field(gt=0.0, le=1.0)] = Field(
        default=0.5,
        description="Share of the period after which the node ends a decision about contacts with friction "
        "with the best point that it has, by default 0.5. It is never worse than holding.",
    )
    measurement_timeout: Annotated[Positive, in_range(1e-3, 10.0, "s")] = Field(
        default=0.25,
        description="Time without measurement after which a closed loop holds [s], by default 0.25; three "
        "periods of the controller at least.",
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

    def lasting(self, period: float) -> ServiceSettings:
        """The same with timeouts of three periods at least: what arrives once a period is not too old [s]."""
        target = lasting_timeout(self.target_timeout, period)
        measured = lasting_timeout(self.measurement_timeout, period)
        return self.model_copy(update={"target_timeout": target, "measurement_timeout": measured})
