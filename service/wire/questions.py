"""Questions to a node over Zenoh."""

from __future__ import annotations

import time

import zenoh

from tauten.service.link import Keys, NetworkError, await_token
from tauten.service.process import StopFlag
from tauten.service.wire.description import RobotDescription, read_description

_PATIENCE = 5.0  # s for an answer


def wait_for(session: zenoh.Session, token: str, stop: StopFlag) -> bool:
    """Wait until a liveliness token is declared; False after a request to stop."""
    return await_token(session, token, lambda: stop.requested) and not stop.requested


def ask_description(session: zenoh.Session, keys: Keys) -> RobotDescription:
    """How a node describes the robot it serves.

    Raises:
        NetworkError: the node does not answer, or not with a description of this version.
    """
    end = time.monotonic() + _PATIENCE
    while time.monotonic() < end:
        found = _answer(session, keys)
        if found is not None:
            return found
    raise NetworkError(f"the node of {keys.robot!r} does not describe itself: see its log")


def check_node(session: zenoh.Session, own: RobotDescription) -> None:
    """Check that the node of a robot, where it answers, has its effectors and its actuators.

    Targets and measurements have no names of effectors: those of the first one of a file are for the first
    one of the node, also where the file has changed since the node was started.

    Raises:
        NetworkError: the node serves a robot with others, or with other limits.
    """
    try:
        served = _answer(session, Keys(own.name))
    except NetworkError:  # of another version: it cannot be compared
        return
    if served is None:
        return
    for what, theirs, ours in (
        ("effectors", _effectors(served), _effectors(own)),
        ("actuators", _actuators(served), _actuators(own)),
    ):
        if theirs != ours:
            raise NetworkError(
                f"the node of {own.name!r} has the {what} {'; '.join(theirs)}, here are {'; '.join(ours)}: "
                "the robot file has changed since one of the two was started, start both again"
            )


def _answer(session: zenoh.Session, keys: Keys) -> RobotDescription | None:
    """What a node answers within a second; None: nothing.

    Raises:
        NetworkError: not a description of this version.
    """
    wrong: NetworkError | None = None
    for reply in session.get(keys.description, timeout=1.0):
        if reply.ok is None:
            continue
        try:
            return read_description(keys.robot, bytes(reply.ok.payload))
        except NetworkError as error:
            wrong = error
    if wrong is not None:
        raise wrong
    return None


def _effectors(robot: RobotDescription) -> list[str]:
    return [f"{one.name} ({one.kind})" for one in robot.effectors]


def _actuators(robot: RobotDescription) -> list[str]:
    """Name, and limits of position and effort."""
    return [
        f"{one.name} ({one.position[0]:g} to {one.position[1]:g} {one.units['position']}, "
        f"{one.effort[0]:g} to {one.effort[1]:g} {one.units['effort']})"
        for one in robot.actuators
    ]
