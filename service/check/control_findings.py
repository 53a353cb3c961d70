"""Whether a robot's controller knows its contacts, and can decide within its period from where it starts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from time import thread_time

from tauten.controller import (
    Controller,
    ControllerSetup,
    Status,
    controller_setup,
    target_beside,
    warm_controller,
)
from tauten.model import MeshError, Robot, RobotFileError
from tauten.model.load import command_name
from tauten.model.schema import read_toml
from tauten.reduction import BasisError
from tauten.reduction.state import StateBasisError
from tauten.service.check.findings import Finding
from tauten.service.check.rate import faster, fits, reducing, step_seconds

DECISION = "first decision"  # subject of a finding
PERIOD = "control step against period"  # subject of another one
CONTACTS = "contacts in decisions"  # and of a third
STEPS = 10  # of which each must be usable
TIMED = 15  # control steps


def control_findings(path: Path, slower: bool = True) -> Iterator[Finding]:
    """Contacts, the first decisions from the settled start, the time of a control step against the period.

    A lower rate may be advised where it is not beside a finer mesh or a higher rate, if `slower`.
    """
    try:
        setup = controller_setup(read_toml(path), path, accept_error=True)
    except (RobotFileError, MeshError, BasisError, StateBasisError) as error:
        yield Finding(DECISION, "wrong", str(error))
        return
    if not (setup.robot.n_a and setup.robot.effector_layout.kinds):
        yield Finding(DECISION, "fine", "not made: no actuators or no effectors")
        return
    yield from unknown_contacts(setup)
    controller = warm_controller(setup)
    yield first_decision(controller)
    seconds = step_seconds(controller, TIMED, thread_time)
    known = path, bool(setup.states), slower, setup.robot
    yield step_time(seconds, controller.period, *known)


def unknown_contacts(setup: ControllerSetup) -> Iterator[Finding]:
    """Contacts of a file that decisions do not know, because it does not say whether they should."""
    if setup.robot.n_c and setup.contact == "none" and setup.controller.basis is None:
        yield Finding(
            CONTACTS,
            "doubtful",
            "the file has contacts and no controller.basis: the simulated robot has them, decisions do not",
            f'controller.basis = "full", or the basis that tauten reduce {command_name(setup.path)} --write '
            'makes; "none" where decisions are to leave them out',
        )


def first_decision(controller: Controller) -> Finding:
    """Decisions of a controller at its start, to which it returns: a target there, then one beside it.

    Wrong where one cannot be used, or where none is OK: `tauten demo` exits with 1 then.
    """
    near = controller.effector_values
    away = target_beside(controller)
    statuses: Counter[str] = Counter()
    advice, unusable = "", False
    for number in range(STEPS):
        left = controller.step(near if 2 * number < STEPS else away)
        statuses[left.status.name] += 1
        if not left.status.ok:
            unusable = unusable or not left.status.usable
            limits = f" ({', '.join(left.conflict)})" if left.conflict else ""
            advice = advice or f"{left.status.value}{limits}"
    controller.reset()
    controller.prepare()
    listed = ", ".join(f"{name} {count}" for name, count in statuses.items())
    found = f"{STEPS} decisions from the start: {listed}"
    if not controller.settled:
        found += "; without an equilibrium it starts undeformed"
    if unusable or Status.OK.name not in statuses:
        return Finding(DECISION, "wrong", found, advice)
    return Finding(DECISION, "doubtful" if advice else "fine", found, advice)


def step_time(
    seconds: float,
    period: float,
    path: Path,
    reduced: bool,
    slower: bool = True,
    robot: Robot | None = None,
) -> Finding:
    """The time of a control step against the period.

    It is processor time: what else the computer does at the moment is no property of the robot. A step that
    takes too long is doubtful and not wrong: another computer may be faster.

    Args:
        seconds: time of a control step.
        period: of the controller [s].
        path: of the robot file.
        reduced: whether the model is reduced.
        slower: whether a lower rate may be advised.
        robot: see `faster`.
    """
    rate = 1.0 / period
    model = "reduced" if reduced else "full"
    found = f"{1e3 * seconds:.1f} ms of {1e3 * period:.3g} ms on this processor, {model} model"
    if fits(rate, seconds):
        return Finding(PERIOD, "fine", found)
    advice = faster(path, seconds, reduced, robot)
    if not slower and not reduced:
        advice = f"{reducing(path)} gives a model whose steps do not grow with the mesh"
    return Finding(PERIOD, "doubtful", found, advice)
