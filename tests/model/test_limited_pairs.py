"""What limits of contact forces count: sums over a pair, from where they are named and from where kept."""

from __future__ import annotations

import numpy as np
import pytest

from tauten.model import ForceLimits, Grasp
from tauten.model.contact import ForceBounds
from tauten.model.contacts import ContactForces, Contacts
from tauten.model.step.force_limits import LimitedPairs


def two_pushing(times: float = 1.0) -> ContactForces:
    """A pair that presses with 3 N and is rubbed with (0.4, 0.2) N, times a factor, beside another pair."""
    normal = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    force = times * np.array([[0.3, 0.0, 2.0], [0.1, 0.2, 1.0], [50.0, 9.0, 0.0]])
    found = Contacts(
        3, np.arange(3), np.array([0, 0, 1]), np.zeros(3), np.zeros((3, 3)), normal, np.full(3, 0.5)
    )
    return ContactForces(found, force, np.zeros(3, np.bool_), np.zeros(3))


SLIP = 0.5 * 3.0 - float(np.hypot(0.4, 0.2))  # N, the distance to slip of `two_pushing`


@pytest.mark.parametrize(
    ("within", "beyond", "name"),
    [
        (ForceBounds(largest=3.0 / 1.04), ForceBounds(largest=3.0 / 1.06), "largest force"),
        (ForceBounds(least=3.0 / 0.96), ForceBounds(least=3.0 / 0.94), "smallest force"),
        (ForceBounds(margin=SLIP / 0.96), ForceBounds(margin=SLIP / 0.94), "smallest distance to slip"),
    ],
)  # fmt: skip
def test_a_limit_is_named_from_a_twentieth_beyond_it(
    within: ForceBounds, beyond: ForceBounds, name: str
) -> None:
    for bounds, expected in ((within, ()), (beyond, (f"{name} of pads",))):
        limits = ForceLimits((LimitedPairs("pads", np.array([0]), 0.5, bounds),), np.zeros((3, 0)))
        grasp = Grasp.at_start(limits).after(two_pushing())
        assert grasp.kept == (True,)
        assert grasp.exceeded(two_pushing()) == expected


def test_what_is_brushed_with_less_than_a_tenth_is_no_grasp() -> None:
    """A distance to slip of 1 N needs 2 N at a coefficient of friction of 0.5."""
    bounds = ForceBounds(margin=1.0)
    limits = ForceLimits((LimitedPairs("pads", np.array([0]), 0.5, bounds),), np.zeros((3, 0)))
    for normal, kept in ((0.19, False), (0.21, True)):
        grasp = Grasp.at_start(limits).after(two_pushing(normal / 3.0))
        assert grasp.kept == (kept,)
