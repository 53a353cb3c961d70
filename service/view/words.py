"""What the panel says: mode and health as plain text, and the HTML that shows it."""

from __future__ import annotations

import html
from dataclasses import dataclass

from tauten.service.frames import Miss, RobotLook, ViewFrame
from tauten.service.wire import Cause, Mode

_TITLES = {
    Mode.IDLE: "IDLE: at rest",
    Mode.RUN: "RUN: follows the target",
    Mode.HOLD: "HOLD: the actuators do not move",
    Mode.STOP: "STOP: the actuators are released",
}
_ADVICE = {
    Cause.NONE: "",
    Cause.NO_TARGET: "no target: switch “follow” on and drag the target",
    Cause.OPERATOR: "by the operator: press “enable”",
    Cause.LATE: "too many deadlines were missed: give the node a lower rate or more processor time",
    Cause.UNMEASURED: "an effector is not measured: check the camera",
    Cause.IMPLAUSIBLE: "a measurement is not plausible: check the camera, then press “enable”",
    Cause.UNUSABLE: "no usable decision: move the target back",
    Cause.SHUTDOWN: "the node is shutting down",
    Cause.HURRIED: "the node is shutting down as fast as it may",
}
_STATUSES = {  # by the names of `Status`
    "FEASIBLE_ONLY": "the decision may not be the best one",
    "NOT_FOUND": "no decision within the limits was found",
    "INFEASIBLE": "no efforts of the actuators meet the limits",
    "MAX_PIVOTS": "the decision was ended before it was the best one",
    "NOT_EXACT": "an effector that must reach its target exactly cannot",
    "RELAXED": "limits cannot all be met: actuators come as near to them as they can",
    "SEEKING_CONTACT": "no efforts were found that bring the effectors nearer",
    "NOT_FINITE": "the target, the model's state or what an extension gives is not finite: health names it",
}
_NEAR = 1e-3  # of the distance between limits
_MOST_TEXT = 400  # characters of a sentence
_MOST_ITEMS = 30
_BOX = '<div style="padding:0 12px 8px;font-size:13px;line-height:1.35;overflow-wrap:anywhere">{}</div>'
_LIST = '<ul style="margin:4px 0;padding-left:20px">{}</ul>'


@dataclass(frozen=True, slots=True)
class Words:
    """A text of the panel. Its parts are plain text: markup in what a node or a log says is shown as it is.

    Attributes:
        title: shown in bold.
        advice: what to do about it.
        items: of a list.
    """

    title: str = ""
    advice: str = ""
    items: tuple[str, ...] = ()

    @property
    def html(self) -> str:
        """The text as HTML that has no other elements than those for title, advice and list."""
        found = []
        if self.title:
            found.append(f"<b>{_escaped(self.title)}</b>")
        if self.advice:
            found.append(f"<div>{_escaped(self.advice)}</div>")
        if self.items:
            rows = (f"<li>{_escaped(item)}</li>" for item in self.items[:_MOST_ITEMS])
            found.append(_LIST.format("".join(rows)))
        return _BOX.format("".join(found)) if found else ""


def frame_in_words(
    look: RobotLook,
    frame: ViewFrame,
    notes: tuple[str, ...],
    advice: bool = True,
    miss: Miss | None = None,
) -> Words:
    """What a frame says about the robot.

    Args:
        look: of the robot.
        frame: that is shown.
        notes: further sentences.
        advice: whether to say what to do where the robot does not follow; otherwise the cause alone is named.
        miss: a target that is out of reach; None: there is none.
    """
    if miss is not None:
        name = look.robot.effectors[miss.effector].name
        return Words(
            "RUN: the target is out of reach",
            f"{name} stays {1e3 * miss.distance:.1f} mm away, at the nearest point",
            (*_health(look, frame, far=False), *notes),
        )
    return Words(
        _TITLES[frame.mode],
        _advice(frame.mode, frame.cause) if advice else str(frame.cause),
        (*_health(look, frame), *notes),
    )


def in_the_past(words: Words, time: float, last: float) -> Words:
    """What is said about a frame that is not the newest one: its time first.

    Args:
        words: about the frame.
        time: of the frame [s].
        last: of the newest one [s].
    """
    if time >= last:
        return Words("PAUSED", f"at {time:.2f} s", (words.title, *words.items))
    return Words(
        f"PAST: {time:.2f} s, {last - time:.2f} s ago",
        "target and plots are those of then; press “now” to return",
        (words.title, *words.items),
    )


def without_node(words: Words, silence: float) -> Words:
    """What is said while the node has sent nothing for some time [s], beside words about the newest frame."""
    return Words(
        "NO NODE: where the robot is now is not known",
        f"no message has come for {silence:.0f} s: start the node, then switch “follow” on",
        (f"the last was {words.title}", *words.items),
    )


def at_limit(look: RobotLook, frame: ViewFrame) -> list[str]:
    """Names of the actuators whose position or effort is at a limit; a lower one of 0 is rest."""
    pairs = zip(frame.position.tolist(), frame.effort.tolist(), strict=True)
    return [
        actuator.name
        for actuator, (travel, force) in zip(look.robot.actuators, pairs, strict=True)
        if _at_end(travel, actuator.position) or _at_end(force, actuator.effort)
    ]


def beyond_limit(look: RobotLook, frame: ViewFrame) -> list[str]:
    """Efforts of a simulated robot beyond their limits, which decisions keep, and what was decided."""
    if frame.decided is None:
        return []
    found = []
    for one, has, decided in zip(look.robot.actuators, frame.effort, frame.decided, strict=True):
        low, high = one.effort
        room = _NEAR * (high - low)
        if has > high + room or has < low - room:
            text = one.kind.effort.text
            found.append(f"{one.name} {text(float(has))}, decided {text(float(decided))}")
    return found


def _at_end(value: float, limits: tuple[float, float]) -> bool:
    low, high = limits
    near = _NEAR * (high - low)
    return value >= high - near or (low < 0.0 and value <= low + near)


def _advice(mode: Mode, cause: Cause) -> str:
    if mode is Mode.RUN:
        return ""
    if mode is Mode.STOP and cause is Cause.OPERATOR:
        return "press “reset” once they are at rest"
    return _ADVICE[cause]


def _health(look: RobotLook, frame: ViewFrame, far: bool = True) -> list[str]:
    found = []
    error = look.error(frame)
    if far and error == error:
        found.append(f"{1e3 * error:.1f} mm from the target")
    if names := at_limit(look, frame):
        found.append(f"at the limit: {', '.join(names)}")
    if efforts := beyond_limit(look, frame):
        found.append(
            f"the simulated robot moves otherwise than the model that decides: {'; '.join(efforts)}"
        )
    if frame.status not in ("", "OK"):
        found.append(_STATUSES.get(frame.status, f"status {frame.status}"))
    if frame.mode is Mode.STOP and frame.modelled is None:  # what is shown is the model itself
        found.append("the picture is of before the stop: the model does not move")
        return found
    count = len(frame.geometry.contacts.points)
    if count:
        found.append(f"{count} contact points push" if count > 1 else "1 contact point pushes")
    return found


def _escaped(text: str) -> str:
    """A text of bounded length as HTML, without elements and without characters that are not printable."""
    shown = text if len(text) <= _MOST_TEXT else f"{text[:_MOST_TEXT]}…"
    return html.escape("".join(c if c.isprintable() else " " for c in shown))
