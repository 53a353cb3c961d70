"""Every way through `solve_friction_inverse` taken once, as `warm_solver` does for the QPCC."""

from __future__ import annotations

import numpy as np

from tauten.controller.friction.exact import WIDE, smoothed_at
from tauten.controller.friction.problem import FrictionInverse, inverse_contacts
from tauten.controller.friction.solve import FrictionSettings, solve_friction_inverse
from tauten.controller.qpcc import Qpcc


def warm_search() -> None:
    """Compile or load all kernels of a search, those for contact that nothing touches yet too."""
    problem = stuck_block()
    contacts = inverse_contacts(problem)
    smoothed_at(contacts, np.zeros(1), np.zeros(len(contacts.q)), WIDE)
    for warm in (False, True):
        solve_friction_inverse(problem, np.zeros(1), settings=FrictionSettings(warm=warm))


def stuck_block() -> FrictionInverse:
    """A block of unit compliance on a floor, which one effort pushes along x, to a target beyond its limit.

    It sticks at first, and the search goes all its ways.
    """
    along = np.array([1.0, 0.0, 1.0, 0.0])
    program = Qpcc(
        Q=np.outer(along, along), c=-along, lb=np.zeros(1), ub=np.full(1, 1.5),
        G=along[None], g_lo=np.full(1, -5.0), g_hi=np.full(1, 5.0),
        M=np.array([[0.0, 1.0, 0.0, 0.0], [1.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]),
        m=np.array([-2.0, 0.0, 0.0]), constant=0.5,
    )  # fmt: skip
    return FrictionInverse(program, np.array([0.5]))
