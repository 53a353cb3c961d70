"""What the colours of the picture mean."""

from __future__ import annotations

from tauten.model import ActuatorKind
from tauten.service.frames import RobotLook
from tauten.service.view.actuators import (
    AXIS,
    FORCE,
    LINES,
    MIDDLE,
    NO_PRESSURE,
    PRESSURE,
    SLACK,
    SPRING,
    TIGHT,
    VACUUM,
    Colour,
)
from tauten.service.view.scene import CONTACT, EFFECTOR, GHOST, GRAVITY, TARGET, WAYPOINT

_ROW = (
    '<div style="display:flex;align-items:center;gap:8px;margin:3px 12px;font-size:12px">{}</div>'
)
_PATCH = '<span style="width:38px;height:10px;border-radius:3px;flex:none;background:{}"></span>{}'


def legend_html(look: RobotLook) -> str:
    """The legend of a robot, with what it has.

    Args:
        look: of the robot.
    """
    kinds = {one.kind for one in look.robot.actuators}
    rows = [(_plain(TARGET), "target"), (_plain(EFFECTOR), "effector")]
    if ActuatorKind.CABLE in kinds:
        rows.append((_gradient(SLACK, MIDDLE, TIGHT), "cable: slack to its largest tension"))
    if kinds & set(LINES[1:]):
        rows.append((_gradient(SLACK, MIDDLE, TIGHT), "transmission: no effort to its largest"))
    if any(one.flexibility for one in look.robot.actuators):
        rows.append((_plain(SPRING), "spring between winch and cable"))
    if ActuatorKind.CHAMBER in kinds:
        lowest = min(
            one.effort[0] for one in look.robot.actuators if one.kind is ActuatorKind.CHAMBER
        )
        if lowest < 0.0:
            rows.append((_gradient(VACUUM, NO_PRESSURE, PRESSURE), "chamber: vacuum to pressure"))
        else:
            rows.append((_gradient(NO_PRESSURE, PRESSURE), "chamber: none to largest pressure"))
    if ActuatorKind.FORCE in kinds:
        rows.append((_plain(FORCE), "force of an actuator"))
    if kinds & {ActuatorKind.DRIVE, ActuatorKind.SLIDE}:
        rows.append((_plain(AXIS), "axis of a drive, its angle or travel"))
    rows += [(_plain(CONTACT), "contact force"), (_plain(WAYPOINT), "waypoint")]
    if any(look.robot.gravity):
        rows.append((_plain(GRAVITY), "gravity"))
    if look.ghost is not None:
        rows.append((_plain(GHOST), "model that decides"))
    return "".join(_ROW.format(_PATCH.format(colour, text)) for colour, text in rows)


def _plain(colour: Colour) -> str:
    return "rgb({},{},{})".format(*colour)


def _gradient(*colours: Colour) -> str:
    return f"linear-gradient(90deg,{','.join(_plain(one) for one in colours)})"
