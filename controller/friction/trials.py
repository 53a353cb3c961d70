"""What a search for efforts tries, one after another, and where it was cut."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tauten.controller.friction.path import FAST, SLOW, Pace, PathEnd
from tauten.controller.friction.search import EffortSearch
from tauten.model.numerics import Array


@dataclass(frozen=True, slots=True)
class PathTrial:
    """One way to look for a lower point.

    Attributes:
        share: κ at the start of the path.
        nested: whether the smoothed law is solved at each width.
        from_hold: whether the path starts from holding; else from the best point.
        fallback: whether it is left out where something has been gained.
        pace: of a path that is not nested.
    """

    share: float
    nested: bool = False
    from_hold: bool = False
    fallback: bool = False
    pace: Pace = SLOW


# other starts find other minima; the second and the fourth go on from the best point so far
SLOPED = (
    PathTrial(1.0, from_hold=True),
    PathTrial(0.3),
    PathTrial(1.0, from_hold=True, pace=FAST),
    PathTrial(1.0, pace=FAST),
)
# where nothing that the efforts do at first changes the objective
FLAT = (
    PathTrial(1.0, nested=True, from_hold=True),
    PathTrial(0.3),
    PathTrial(3.0, nested=True, from_hold=True, fallback=True),
    PathTrial(0.3, nested=True, from_hold=True, fallback=True),
)
WARM = (PathTrial(0.3, from_hold=True, pace=FAST),)
# where contact is looked for in a control loop: paths that are not nested find it more often and sooner
SEEK = (
    PathTrial(3.0, from_hold=True, pace=FAST),
    PathTrial(0.3, from_hold=True, fallback=True),
    PathTrial(1.0, from_hold=True, fallback=True),
    PathTrial(10.0, from_hold=True, fallback=True),
)


@dataclass(frozen=True, slots=True)
class CutSearch:
    """Where a search was cut.

    Attributes:
        flat: whether descent from holding was out of sight.
        trial: number of the trial of those that are made then.
        path: where its path was cut, or its end where no lower point was found from there in time; forces are
            on the rows (s + 3 k,) of the problem. None: it has not begun.
    """

    flat: bool
    trial: int
    path: PathEnd | None

    def with_forces(self, r: Array) -> CutSearch:
        """The same with the forces of its path on other rows."""
        if self.path is None:
            return self
        return replace(self, path=replace(self.path, state=self.path.state._replace(r=r)))

    def on_all_rows(self, search: EffortSearch) -> CutSearch:
        """The same with forces on three rows of each contact."""
        if self.path is None:
            return self
        r = np.zeros(len(search.contacts.q))
        r[search.place] = self.path.state.r
        return self.with_forces(r)


# Where descent is out of sight: nothing is tried again.
ALL_TRIED = CutSearch(True, len(FLAT), None)
