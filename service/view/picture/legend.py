"""What the colours of the picture mean."""

from __future__ import annotations

from tauten.model import ActuatorKind
from tauten.service.frames import RobotLook
from tauten.service.view.picture.actuators import (
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
from tauten.service.view.picture.reach import REACH
from tauten.service.view.picture.scene import (
    CONTACT,
    EFFECTOR,
    GHOST,
    OBJECT,
    SLIDES,
    TARGET,
    WAYPOINT,
)
from tauten.service.view.picture.surroundings import BASE, GRAVITY, OBSTACLE

_ROW = (
    '<div style="display:flex;align-items:center;gap:8px;margin:3px 12px;font-size:12px">{}</div>'
)
_PATCH = '<span style="width:38px;height:10px;border-radius:3px;flex:none;background:{}"></span>{}'


def legend_rows(
    look: RobotLook, reaches: bool = False, operated: bool = False
) -> list[tuple[tuple[Colour, ...], str]]:
    """The colours of what a robot has, one or those of a range, and what they mean.

    There may be the reach of effectors, and waypoints of a robot that is operated.
    """
    kinds = {one.kind for one in look.robot.actuators}
    rows: list[tuple[tuple[Colour, ...], str]] = [((TARGET,), "target"), ((EFFECTOR,), "effector")]
    if ActuatorKind.CABLE in kinds:
        rows.append(((SLACK, MIDDLE, TIGHT), "cable: slack to its largest tension"))
    if kinds & set(LINES[1:]):
        rows.append(((SLACK, MIDDLE, TIGHT), "transmission: no effort to its largest"))
    if any(one.flexibility for one in look.robot.actuators):
        rows.append(((SPRING,), "spring between winch and cable"))
    if ActuatorKind.CHAMBER in kinds:
        lowest = min(
            one.effort[0] for one in look.robot.actuators if one.kind is ActuatorKind.CHAMBER
        )
        if lowest < 0.0:
            rows.append(((VACUUM, NO_PRESSURE, PRESSURE), "chamber: vacuum to pressure"))
        else:
            rows.append(((NO_PRESSURE, PRESSURE), "chamber: none to largest pressure"))
    if ActuatorKind.FORCE in kinds:
        rows.append(((FORCE,), "force of an actuator"))
    if kinds & {ActuatorKind.DRIVE, ActuatorKind.SLIDE}:
        rows.append(((AXIS,), "axis of a drive, its angle or travel"))
    surface = look.robot.surface
    # a simulated robot has contact, whatever the model beside it that decides
    touches = bool(surface.pairs) and (look.ghost is not None or look.robot.basis.name != "none")
    rows += [
        ((colour,), text)
        for colour, text, shown in (
            (CONTACT, "contact force", touches),
            (SLIDES, "contact force that slides", touches and any(surface.friction)),
            (WAYPOINT, "waypoint", operated),
            (BASE, "base, which is held", len(surface.held) > 0),
            (REACH, "reach of the effector", reaches),
            (OBJECT, "object, which no actuator moves", len(surface.objects) > 0),
            (OBSTACLE, "obstacle", len(surface.obstacles) > 0),
            (GRAVITY, "gravity", any(look.robot.gravity)),
            (GHOST, "model that decides", look.ghost is not None),
        )
        if shown
    ]
    return rows


def legend_html(look: RobotLook, reaches: bool = False, operated: bool = False) -> str:
    """The legend of a robot, with what it has."""
    rows = legend_rows(look, reaches, operated)
    return "".join(_ROW.format(_PATCH.format(_css(colours), text)) for colours, text in rows)


def _css(colours: tuple[Colour, ...]) -> str:
    shown = ",".join("rgb({},{},{})".format(*one) for one in colours)
    return f"linear-gradient(90deg,{shown})" if len(colours) > 1 else shown
