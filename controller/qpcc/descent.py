"""The active set over the pieces of a QPCC: solve a piece, read its multipliers, flip, repeat."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np

from tauten.controller.qpcc.lcp_start import feasible_start
from tauten.controller.qpcc.one_cable import solve_one_cable
from tauten.controller.qpcc.pieces import Reduction, reduce_piece
from tauten.controller.qpcc.qp import Backend, Qp, QpAnswer, nothing, solve_daqp
from tauten.controller.qpcc.qp_polish import polished
from tauten.controller.qpcc.recovery import recover
from tauten.controller.qpcc.residuals import ACTIVE, Residuals, judge, pair_values, row_values
from tauten.controller.qpcc.scaling import Scaled
from tauten.controller.qpcc.strong_stationarity import strong_multipliers
from tauten.model.numerics import Array, Bools, Ints

EXACT = 1e-8  # residuals an optimum may have
POLISHED = 1e-9  # residuals above which a QP's answer is polished
NOISE = 1e-11  # of an objective, relative to its terms
NEARBY = (
    1e-4  # change of tension that shows the pieces around a point, relative to its largest force
)
MOST_DEGENERATE = 6  # pairs at zero of which all combinations are looked at


@dataclass(frozen=True, slots=True)
class Point:
    """A feasible point, as a rule the optimum of a piece.

    Attributes:
        piece: (k,) which modes push.
        z: (n,) scaled variables.
        alpha: (n_a,) multipliers of the bounds.
        dual: (2k + p,) multipliers of the rows.
        worth: objective and residuals.
        settled: every piece that touches the point was seen to be no better.
    """

    piece: Bools
    z: Array
    alpha: Array
    dual: Array
    worth: Residuals
    settled: bool = False

    @property
    def feasible(self) -> bool:
        """Within the limits and complementary; not when there is a NaN."""
        return self.worth.primal <= EXACT and self.worth.complementarity <= EXACT

    @property
    def exact(self) -> bool:
        """Whether there is nothing to polish."""
        return self.feasible and self.worth.stationarity <= POLISHED

    @property
    def stationary(self) -> bool:
        """Strongly stationary, or B-stationary by looking at all pieces around."""
        no_flip = self.settled or self.worth.largest_gain <= ACTIVE
        return self.worth.stationarity <= EXACT and no_flip

    def beats(self, other: Point) -> bool:
        """Lower by more than round-off, or as low and stationary where the other is not."""
        margin = NOISE * (self.worth.terms + other.worth.terms)
        if self.worth.objective < other.worth.objective - margin:
            return True
        as_low = self.worth.objective <= other.worth.objective + margin
        return as_low and self.stationary and not other.stationary


def solve_piece(problem: Scaled, piece: Bools, backend: Backend) -> Point | None:
    """Optimum of one piece; None when it is empty or could not be solved.

    An answer that is not exact is polished; where that fails, daqp is asked. So it is where another
    library sees an empty set: proxqp does at times where there is an interior. With one tension the default
    library is asked only where the piece is not a parabola over an interval.
    """
    if len(problem.lb) == 1 and backend is solve_daqp:
        found, z, alpha, dual, worth = solve_one_cable(problem, piece)
        point = Point(piece, z, alpha, dual, worth)
        if found and point.exact:
            return point
    possible, H, f, A, lower, upper, reduction = reduce_piece(problem, piece)
    if not possible:
        return None
    qp = Qp(H, f, A, lower, upper)
    answer = backend(qp) if len(f) > 0 else nothing(qp, infeasible=False)
    if answer.infeasible and backend is not solve_daqp:
        answer = solve_daqp(qp)
    if answer.infeasible:
        return None
    point = conclude(problem, piece, reduction, answer)
    if not point.exact:
        point = conclude(problem, piece, reduction, polished(qp, answer))
    if not point.exact and backend is not solve_daqp:
        point = conclude(problem, piece, reduction, polished(qp, solve_daqp(qp)))
    return point if point.feasible else None


def conclude(problem: Scaled, piece: Bools, reduction: Reduction, answer: QpAnswer) -> Point:
    """The point that an answer to a piece's QP means."""
    z, alpha, dual, worth = recover(problem, piece, reduction, answer.y, answer.multipliers)
    return Point(piece, z, alpha, dual, worth)


@dataclass(slots=True)
class Descent:
    """Descents from one or more pieces, no piece solved twice.

    Attributes:
        problem: scaled.
        backend: of the piece's QPs.
        max_pivots: pieces solved at most.
        best: best point so far.
        tried: pieces solved, as bytes.
    """

    problem: Scaled
    backend: Backend
    max_pivots: int
    best: Point | None = None
    tried: set[bytes] = field(default_factory=set)

    @property
    def pivots(self) -> int:
        """Pieces solved."""
        return len(self.tried)

    @property
    def exhausted(self) -> bool:
        """Whether the pivot limit is reached."""
        return self.pivots >= self.max_pivots

    def run(self, piece: Bools) -> Point | None:
        """Descend from a piece to a stationary point; None when the piece is empty or was tried."""
        current = self.visit(piece)
        while current is not None and not current.stationary:
            following = self.improve(current) or self.settle(current)
            if following is None:
                break
            current = following
        return current

    def visit(self, piece: Bools) -> Point | None:
        """Solve a piece unless it was solved before or the limit is reached."""
        key = piece.tobytes()
        if key in self.tried or self.exhausted:
            return None
        self.tried.add(key)
        point = solve_piece(self.problem, piece, self.backend)
        if point is not None:
            self.keep(point)
        return point

    def stay(self, z: Array, piece: Bools) -> None:
        """Remember a point that satisfies the complementarity, if it satisfies the limits too."""
        n_a, rows = len(self.problem.lb), len(self.problem.r)
        alpha, dual = np.zeros(n_a), np.zeros(rows)
        point = Point(piece, z, alpha, dual, judge(self.problem, z, alpha, dual))
        if point.feasible:
            self.keep(point)

    def run_or_stay(self, z: Array, piece: Bools) -> None:
        """Descend from a point's piece; where nothing comes of it the point itself is remembered."""
        self.run(piece)
        if self.best is None:
            self.stay(z, piece)

    def keep(self, point: Point) -> None:
        """Remember a point when it is the best so far."""
        if self.best is None or point.beats(self.best):
            self.best = point

    def improve(self, current: Point) -> Point | None:
        """A better or stationary neighbour: all wrong pairs flipped, else one by one, worst first."""
        gain = current.worth.gain
        wrong = np.flatnonzero(gain > ACTIVE)
        wrong = wrong[np.argsort(-gain[wrong], kind="stable")]
        flips: list[Ints] = [wrong, *wrong[:, None]] if len(wrong) > 1 else [wrong]
        return self.first_better(current, flipped(current.piece, flips))

    def settle(self, current: Point) -> Point | None:
        """Decide a degenerate point: other multipliers, pieces to all sides, every piece that touches it."""
        alpha, dual = strong_multipliers(self.problem, current.z)
        worth = judge(self.problem, current.z, alpha, dual)
        point = Point(current.piece, current.z, alpha, dual, worth)
        if point.stationary:
            self.keep(point)
            return point
        better = self.first_better(current, self.pieces_around(current))
        both = self.pairs_at_zero(current)
        if better is not None or self.exhausted or len(both) > MOST_DEGENERATE:
            return better
        sizes = range(1, len(both) + 1)
        flips: list[Ints] = [np.array(some) for size in sizes for some in combinations(both, size)]
        better = self.first_better(current, flipped(current.piece, flips))
        if better is not None or self.exhausted:
            return better
        point = replace(current, settled=True)
        self.keep(point)
        return point if point.stationary else None

    def pieces_around(self, point: Point) -> Iterator[Bools]:
        """Pieces of the contact forces when one tension changes a little."""
        n_a = len(self.problem.lb)
        step = NEARBY * max(np.abs(point.z).max(initial=0.0), NEARBY)
        for move in step * np.vstack([np.eye(n_a), -np.eye(n_a)]):
            a = np.clip(point.z[:n_a] + move, self.problem.lb, self.problem.ub)
            found, piece, _ = feasible_start(self.problem, a, point.piece)
            if found:
                yield piece

    def first_better(self, current: Point, pieces: Iterable[Bools]) -> Point | None:
        """The first of some pieces whose optimum is better, or as good and stationary."""
        for piece in pieces:
            point = self.visit(piece)
            if point is not None and point.beats(current):
                return point
        return None

    def pairs_at_zero(self, point: Point) -> Ints:
        """Pairs of which both sides are zero."""
        values, sizes = row_values(self.problem, point.z)
        beta, w = pair_values(self.problem, point.z, values, sizes)
        pairs: Ints = np.flatnonzero((beta <= ACTIVE) & (w <= ACTIVE))
        return pairs


def flipped(piece: Bools, flips: Iterable[Ints]) -> Iterator[Bools]:
    """The piece with some pairs flipped, for each choice of pairs."""
    for flip in flips:
        other = piece.copy()
        other[flip] = ~other[flip]
        yield other
