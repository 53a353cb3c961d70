"""Mode and health in words."""

from __future__ import annotations

from tauten.service.frames import RobotLook, ViewFrame
from tauten.service.wire import Cause, Mode

_TITLES = {
    Mode.IDLE: "IDLE: at rest",
    Mode.RUN: "RUN: follows the target",
    Mode.HOLD: "HOLD: the actuators do not move",
    Mode.STOP: "STOP: the actuators are released",
}
_ADVICE = {
    Cause.NONE: "",
    Cause.NO_TARGET: "no target: switch *follow* on and drag the target",
    Cause.OPERATOR: "by the operator: press *enable*, or *reset* after a stop",
    Cause.LATE: "too many deadlines were missed: give the node a lower rate or more processor time",
    Cause.UNMEASURED: "an effector is not measured: check the camera",
    Cause.IMPLAUSIBLE: "a measurement is not plausible: check the camera, then press *enable*",
    Cause.UNUSABLE: "no usable decision: move the target back",
    Cause.SHUTDOWN: "the node is shutting down",
}


def mode_in_words(mode: Mode, cause: Cause, advice: bool = True) -> str:
    """Mode and cause as a short text in Markdown.

    Args:
        mode: of the node.
        cause: why it does not follow.
        advice: whether to say what to do about it; otherwise the cause alone is named.
    """
    title = f"**{_TITLES[mode]}**"
    if mode is Mode.RUN or cause is Cause.NONE:
        return title
    if not advice:
        return f"{title}\n\n{cause}"
    if mode is Mode.STOP and cause is Cause.OPERATOR:
        return f"{title}\n\npress *reset* once they are slack"
    return f"{title}\n\n{_ADVICE[cause]}"


def health_in_words(look: RobotLook, frame: ViewFrame, notes: tuple[str, ...]) -> str:
    """What a frame says about the robot, as a list in Markdown.

    Args:
        look: of the robot.
        frame: that is shown.
        notes: further sentences.
    """
    found = []
    error = look.error(frame)
    if error == error:
        found.append(f"{1e3 * error:.1f} mm from the target")
    if names := at_limit(look, frame):
        found.append(f"at the limit: {', '.join(names)}")
    if frame.status not in ("", "OK"):
        found.append(f"decision: {frame.status.lower().replace('_', ' ')}")
    count = len(frame.geometry.contacts.points)
    if count:
        found.append(f"{count} contact points push")
    return "\n".join(f"- {text}" for text in [*found, *notes])


def at_limit(look: RobotLook, frame: ViewFrame) -> list[str]:
    """Names of the actuators whose position or effort is at its upper limit."""
    return [
        actuator.name
        for actuator, travel, force in zip(
            look.actuators, frame.pull.tolist(), frame.tension.tolist(), strict=True
        )
        if travel >= actuator.pull[1] - 1e-3 * (actuator.pull[1] - actuator.pull[0])
        or force >= actuator.tension[1] - 1e-3 * abs(actuator.tension[1])
    ]
