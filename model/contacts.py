"""Contacts: the candidates within reach of a surface, as rows, pictures, readouts and logs have them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from tauten.model.numerics import Array, Bools, Ints, kernel


@dataclass(frozen=True, slots=True)
class Contacts:
    """Contact candidates within the alarm distance at one state.

    The slot of a candidate in λ_c ∈ R^(n_c) never changes; only candidates in range are here.

    Attributes:
        n_slots: n_c, number of slots in λ_c.
        slots: (m,) slot of each, ascending.
        pair: (m,) its contact pair.
        gap: (m,) signed gap [m], negative where it penetrates.
        point: (m, 3) where the candidate is [m].
        normal: (m, 3) unit direction in which the gap grows when the candidate moves.
        friction: (m,) coefficient of friction.
        surface: (m, 3) velocity of the obstacle at its nearest point [m/s]; None where nothing moves.
    """

    n_slots: int
    slots: Ints
    pair: Ints
    gap: Array
    point: Array
    normal: Array
    friction: Array
    surface: Array | None = field(default=None, kw_only=True)

    @property
    def closing(self) -> Array | None:
        """How fast obstacles alone close each gap: (m,) [m/s]; None where none moves."""
        return None if self.surface is None else np.einsum("mi,mi->m", self.normal, self.surface)

    def __len__(self) -> int:
        return len(self.gap)

    def axes(self, chosen: Ints | None = None) -> Array:
        """The normal and two tangents, unit directions across it and each other, right-handed: (m, 3, 3).

        Continuous where the normal is but for the direction −z (Duff et al., Building an orthonormal basis,
        revisited, 2017). Of some of the contacts (r,), by their places, they are (r, 3, 3).
        """
        return _axes(self.normal if chosen is None else self.normal[chosen])

    def at(self, chosen: Ints) -> Contacts:
        """Some of the contacts (r,), by their places."""
        return Contacts(
            self.n_slots, self.slots[chosen], self.pair[chosen], self.gap[chosen],
            self.point[chosen], self.normal[chosen], self.friction[chosen],
            surface=None if self.surface is None else self.surface[chosen],
        )  # fmt: skip

    def gaps(self) -> Array:
        """Signed gap of every slot, +inf where out of range: (n_c,) [m]."""
        gaps = np.full(self.n_slots, np.inf)
        gaps[self.slots] = self.gap
        return gaps


@dataclass(frozen=True, slots=True)
class ContactForces:
    """The contacts in range in a step with their forces: what drawings, readouts and logs have.

    Attributes:
        contacts: the contacts in range.
        force: (m, 3) on each candidate in the robot's frame, normal and friction together [N].
        sliding: (m,) which push and slide; without friction all that push do.
        margin: (m,) distance to slip μ λ_n − |λ_t| of those that push and stick, 0 of others [N].
    """

    contacts: Contacts
    force: Array
    sliding: Bools
    margin: Array

    def __len__(self) -> int:
        return len(self.force)

    @property
    def normal_force(self) -> Array:
        """Normal part of each force: (m,) [N]."""
        found: Array = np.einsum("mi,mi->m", self.force, self.contacts.normal)
        return found

    @property
    def pushing(self) -> Bools:
        """Which contacts push; the others are open: (m,)."""
        found: Bools = np.any(self.force != 0.0, axis=1)
        return found

    def at_candidates(self) -> Array:
        """Forces on all candidates, zero out of range, where a step has no row: (n_c, 3) [N]."""
        forces = np.zeros((self.contacts.n_slots, 3))
        forces[self.contacts.slots] = self.force
        return forces


def no_contacts(n_slots: int) -> Contacts:
    """No candidate in range, of n_slots."""
    none, nothing, nowhere = np.zeros(0, dtype=np.int64), np.zeros(0), np.zeros((0, 3))
    return Contacts(n_slots, none, none, nothing, nowhere, nowhere, nothing)


@kernel
def _axes(normal: Array) -> Array:
    """`Contacts.axes` of unit normals (m, 3): (m, 3, 3)."""
    found = np.empty((len(normal), 3, 3))
    for k in range(len(normal)):
        x, y, z = normal[k, 0], normal[k, 1], normal[k, 2]
        sign = np.copysign(1.0, z)
        a = -1.0 / (sign + z)
        b = x * y * a
        found[k, 0, 0], found[k, 0, 1], found[k, 0, 2] = x, y, z
        found[k, 1, 0], found[k, 1, 1], found[k, 1, 2] = 1.0 + sign * x * x * a, sign * b, -sign * x
        found[k, 2, 0], found[k, 2, 1], found[k, 2, 2] = b, sign + y * y * a, -y
    return found


def nearest_from_all_sides(gap: Array, pair: Ints, normal: Array, most: int) -> Ints:
    """The nearest contacts of each pair from each of six directions, in turn: places (k,), k at most `most`.

    The nearest of all may lie on one of several fingers, and it takes two of them to hold something.

    Args:
        gap: (m,) of the contacts [m].
        pair: (m,) their contact pairs.
        normal: (m, 3) unit directions.
        most: how many are wanted.
    """
    axis, every = np.abs(normal).argmax(axis=1), np.arange(len(gap))
    side = 6 * pair + 2 * axis + (normal[every, axis] > 0.0)
    order = np.lexsort((gap, side))
    first = np.searchsorted(side[order], side[order])  # of each one's side
    chosen: Ints = order[np.lexsort((gap[order], every - first))[:most]]
    return chosen
