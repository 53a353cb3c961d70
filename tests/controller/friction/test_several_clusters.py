"""What decisions of several clusters have in common: a status, and how far contact is looked for."""

from __future__ import annotations

import sys
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.robots.bodies import pressing_finger

from tauten.controller import Controller, Status
from tauten.controller.carried import _sight_of
from tauten.controller.planning import Plan, make_plan

ALARM, SIGHT = 2e-3, 8e-3  # m
NAMES = ("largest force of below on table",)


@pytest.mark.parametrize(
    ("status", "said"),
    [
        (Status.SEEKING_CONTACT, Status.RELAXED),
        (Status.OK, Status.RELAXED),
        (Status.NOT_EXACT, Status.NOT_EXACT),
    ],
)
def test_a_limit_that_has_given_way_is_said_whatever_another_cluster_does(
    monkeypatch: pytest.MonkeyPatch, status: Status, said: Status
) -> None:
    """Of two clusters one has relaxed a limit, and the other one seeks contact: no limit is kept silently."""

    def made(*given: Any) -> Plan:
        return replace(make_plan(*given), status=status, conflict=NAMES)

    monkeypatch.setattr(sys.modules["tauten.controller.step"], "make_plan", made)
    controller = Controller(pressing_finger(0.5))
    found = controller.step(controller.effector_values - [0.0, 0.0, 5e-4])
    assert found.status is said
    assert found.conflict == NAMES


def sight(number: int, now: list[int], then: list[int], gaps: list[float]) -> float:
    """Up to which distance the cluster of a number looks after a plan that brings its effector nearer [m].

    Both clusters have an object that no actuator moves, and two contacts: slots 0 and 1 of the first one, 2
    and 3 of the second one.

    Args:
        number: 0 or 1.
        now: slots that push now.
        then: slots that push in the plan.
        gaps: of the four contacts [m].
    """
    contacts = SimpleNamespace(
        rows_of=lambda slots: np.asarray(slots, dtype=np.int64),
        pair=np.array([0, 0, 1, 1]),
        rows=SimpleNamespace(delta=np.array(gaps)),
    )
    layout = SimpleNamespace(effectors=slice(0, 2), actuators=slice(2, 4))
    far = SimpleNamespace(
        compliance=SimpleNamespace(W=np.zeros((4, 4))), layout=layout, frictional=True
    )
    held = SimpleNamespace(delta=np.zeros(2), step=far)
    rows = np.array(now, dtype=np.int64)
    prepared = SimpleNamespace(
        farther=far, held=held, step=SimpleNamespace(rows=SimpleNamespace(contacts=contacts)),
        clusters=SimpleNamespace(of_pairs=np.array([0, 1])),
        forces=SimpleNamespace(extra=rows, extra_beta=np.ones(len(rows))),
    )  # fmt: skip
    robot = SimpleNamespace(
        part_size=0.1, contacts=SimpleNamespace(alarm_distance=ALARM, loose=np.array([0, 1]))
    )
    nearer = SimpleNamespace(delta=np.array([5e-3, 5e-3]), step=far)
    plan = SimpleNamespace(
        status=Status.OK, pushed=np.array(then, dtype=np.int64), predicted=nearer
    )
    own = np.arange(2) == number
    aim = SimpleNamespace(scale=np.where(own, 1.0, 0.0), target=np.full(2, 1e-2))
    given: Any = robot, prepared, plan, aim
    return _sight_of(*given, SIGHT, False, number)


@pytest.mark.parametrize("number", [0, 1])
def test_a_cluster_looks_on_until_its_own_bodies_touch(number: int) -> None:
    """Another one that has its object in its grasp, or is still far from it, is of no effect."""
    own, other = [2 * number, 2 * number + 1], [2 - 2 * number, 3 - 2 * number]
    near = [1e-3] * 4
    assert sight(number, own[:1], own, near) == 0.0
    assert sight(number, [], own, near) == SIGHT
    assert sight(number, other[:1], own, near) == SIGHT
    far = list(near)
    far[own[1]] = 2.0 * ALARM
    assert sight(number, own[:1], own, far) == SIGHT
    assert sight(number, own[:1], [*own, *other], far) == SIGHT
    far = list(near)
    far[other[1]] = 2.0 * ALARM
    assert sight(number, own[:1], [*own, *other], far) == 0.0
