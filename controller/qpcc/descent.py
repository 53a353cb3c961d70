"""From piece to piece: solve one, read its multipliers, flip the pairs that gain, repeat."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from tauten.controller.qpcc.piece import PieceReduction, recover, reduce_piece
from tauten.controller.qpcc.qp import (
    ENDLESS,
    FINEST,
    Backend,
    Qp,
    QpAnswer,
    solve_daqp,
    solve_redundant,
)
from tauten.controller.qpcc.residuals import (
    ACTIVE,
    EITHER,
    EXACT,
    OPEN,
    PUSHES,
    Residuals,
    best_multipliers,
    residuals,
)
from tauten.controller.qpcc.scaling import Scaled
from tauten.controller.qpcc.time_limit import TimeLimit
from tauten.model.numerics import Array, Bools, Ints

NOISE = 1e-11  # of an objective, relative to its terms
MOST_BRANCHES = 64  # nonnegative least squares problems per degenerate point


@dataclass(frozen=True, slots=True)
class DescentPoint:
    """A feasible point, as a rule the optimum of a piece.

    Attributes:
        piece: (k,) which modes push.
        z: (n,) scaled variables.
        alpha: (n_a,) multipliers of the bounds.
        dual: (2k + p,) multipliers of the rows.
        residuals: objective and residuals.
        settled: no piece that touches the point leads down.
    """

    piece: Bools
    z: Array
    alpha: Array
    dual: Array
    residuals: Residuals
    settled: bool = False

    @property
    def feasible(self) -> bool:
        """Within the limits and complementary; not when there is a NaN."""
        return self.residuals.primal <= EXACT and self.residuals.complementarity <= EXACT

    @property
    def stationary(self) -> bool:
        """Strongly stationary, or B-stationary because no piece around leads down."""
        no_gain = self.settled or self.residuals.largest_gain <= ACTIVE
        return self.residuals.stationarity <= EXACT and no_gain

    def beats(self, other: DescentPoint) -> bool:
        """Lower by more than round-off, or as low and stationary where the other is not."""
        mine, others = self.residuals, other.residuals
        margin = NOISE * (mine.terms + others.terms)
        if mine.objective < others.objective - margin:
            return True
        as_low = mine.objective <= others.objective + margin
        return as_low and self.stationary and not other.stationary


@dataclass(slots=True)
class Budget:
    """QPs or linear systems, and time, that a solve may take in all of its phases together.

    Attributes:
        pivots: QPs or systems at most.
        time: for all of it.
        spent: QPs or systems solved.
        reserved: systems for which time is left when the budget is used up.
        pace: longest time that a system has taken [s].
    """

    pivots: int
    time: TimeLimit
    spent: int = 0
    reserved: int = 0
    pace: float = 0.0

    @property
    def exhausted(self) -> bool:
        """Whether QPs or time are used up, but for what is reserved."""
        return self.spent >= self.pivots or not self.allows(0)

    def allows(self, systems: int) -> bool:
        """Whether there is time for some systems and for those that are reserved."""
        return self.time.allows((systems + self.reserved) * self.pace)

    def at_once(self, least: int) -> int:
        """Systems that may be solved until the next look at the clock; at least some."""
        return least if self.time.limited else max(least, self.pivots - self.spent)

    def count(self, systems: int, begin: float) -> None:
        """Count systems that have been solved since a value of the clock."""
        self.spent += systems
        if systems > 0:
            self.pace = max(self.pace, (self.time.clock() - begin) / systems)

    def spend(self) -> bool:
        """Count a QP; False when it must not be solved any more."""
        if self.exhausted:
            return False
        self.spent += 1
        return True


@dataclass(slots=True)
class Descent:
    """Descents from one or more pieces, no piece solved twice.

    Attributes:
        problem: scaled.
        backend: of the piece's QPs.
        budget: of the whole solve.
        best: best point so far.
        tried: pieces solved, as bytes.
    """

    problem: Scaled
    backend: Backend
    budget: Budget
    best: DescentPoint | None = None
    tried: set[bytes] = field(default_factory=set)

    def has_point(self) -> bool:
        """Whether a feasible point has been found."""
        return self.best is not None

    def run(self, piece: Bools) -> DescentPoint | None:
        """Descend from a piece to a stationary point; None when the piece is empty or was tried."""
        current = self.solve_new_piece(piece)
        while current is not None and not current.stationary:
            following = self.improve(current) or self.settle(current)
            if following is None:
                break
            current = following
        return current

    def solve_new_piece(self, piece: Bools) -> DescentPoint | None:
        """Solve a piece unless it was solved before or the budget is spent."""
        key = piece.tobytes()
        if key in self.tried or not self.budget.spend():
            return None
        self.tried.add(key)
        point = solve_piece(self.problem, piece, self.backend)
        if point is not None:
            self.keep(point)
        return point

    def keep_point(self, z: Array, piece: Bools) -> None:
        """Clip a point to its bounds, which round-off may violate; keep it if feasible and the best."""
        n_a, rows = len(self.problem.lb), len(self.problem.r)
        z = np.concatenate(
            [np.clip(z[:n_a], self.problem.lb, self.problem.ub), np.maximum(z[n_a:], 0.0)]
        )
        alpha, dual = np.zeros(n_a), np.zeros(rows)
        point = DescentPoint(piece, z, alpha, dual, residuals(self.problem, z, alpha, dual))
        if point.feasible:
            self.keep(point)

    def keep(self, point: DescentPoint) -> None:
        """Keep a point if it is the best so far."""
        if self.best is None or point.beats(self.best):
            self.best = point

    def improve(self, current: DescentPoint) -> DescentPoint | None:
        """A better or stationary neighbour: all pairs that gain flipped, else one by one, largest first."""
        gain = current.residuals.gain
        wrong = np.flatnonzero(gain > ACTIVE)
        wrong = wrong[np.argsort(-gain[wrong], kind="stable")]
        flips: list[Ints] = [wrong, *wrong[:, None]] if len(wrong) > 1 else [wrong]
        return self.first_better(current, flipped(current.piece, flips))

    def settle(self, current: DescentPoint) -> DescentPoint | None:
        """Decide a degenerate point, of which multipliers are not unique: a better one, or itself settled.

        A tree over the pairs of which both sides are zero, each node the nearest point to zero of the
        gradient plus all multipliers of right signs. What is left over is a direction of descent within
        β >= 0 and w >= 0; where it is complementary it leads into a piece, else a pair branches. Steps 70 to
        73 of the recorded finger_20 end at such points.
        """
        k = len(current.piece)
        stack: list[Ints] = [np.full(k, EITHER)]
        closed = True  # whether all leaves were without descent
        for count in range(MOST_BRANCHES):
            sides = stack.pop()
            alpha, dual, direction, both = best_multipliers(self.problem, current.z, sides)
            found = residuals(self.problem, current.z, alpha, dual)
            if count == 0:
                strong = DescentPoint(current.piece, current.z, alpha, dual, found)
                if strong.stationary:
                    self.keep(strong)
                    return strong
            if found.stationarity > EXACT:
                pair, piece = self.follow(current.piece, direction, both & (sides == EITHER))
                for side in () if pair is None else (PUSHES, OPEN):
                    stack.append(np.where(np.arange(k) == pair, side, sides))
                if pair is None:
                    better = self.first_better(
                        current, [np.where(sides == EITHER, piece, sides > 0)]
                    )
                    if better is not None:
                        return better
                    closed = closed and found.stationarity <= 1e3 * EXACT
            if not stack or self.budget.exhausted:
                break
        point = replace(current, settled=closed and not stack)
        if not point.stationary:
            return None
        self.keep(point)
        return point

    def follow(self, piece: Bools, direction: Array, both: Bools) -> tuple[int | None, Bools]:
        """The pair that a direction (n,) opens on both sides, None without one, and where it leads.

        Args:
            piece: (k,) the piece of the current point.
            direction: (n,) of descent, scaled.
            both: (k,) undecided pairs of which both sides are zero.
        """
        k = len(piece)
        beta = direction[len(direction) - k :]
        w = self.problem.R[k : 2 * k] @ direction
        crossed = np.where(both, np.minimum(beta, w), 0.0)
        pair = int(np.argmax(crossed)) if k else 0
        into = np.where(both, beta > w, piece)
        if k == 0 or crossed[pair] <= EXACT * np.abs(direction).max():
            return None, into
        return pair, into

    def first_better(self, current: DescentPoint, pieces: Iterable[Bools]) -> DescentPoint | None:
        """The first of some pieces whose optimum is better, or as good and stationary."""
        for piece in pieces:
            point = self.solve_new_piece(piece)
            if point is not None and point.beats(current):
                return point
        return None


def solve_piece(problem: Scaled, piece: Bools, backend: Backend) -> DescentPoint | None:
    """Optimum of one piece; None when it is empty or could not be solved.

    Args:
        problem: scaled.
        piece: (k,) the modes that push.
        backend: solves the QP of the piece.
    """
    possible, H, f, A, lower, upper, reduction = reduce_piece(problem, piece)
    if not possible:
        return None
    qp = Qp(H, f, A, lower, upper)
    point = point_of(problem, piece, reduction, backend(qp))
    if backend is not solve_daqp:
        return point
    for again in (partial(solve_daqp, settings=FINEST), solve_redundant):
        if point is not None and point.residuals.stationarity <= EXACT:
            break
        other = point_of(problem, piece, reduction, again(qp))
        if other is not None and (point is None or other.residuals.stationarity <= EXACT):
            point = other
    return point


def point_of(
    problem: Scaled, piece: Bools, reduction: PieceReduction, answer: QpAnswer
) -> DescentPoint | None:
    """The point of a piece that answers its QP; None without a feasible one.

    Args:
        problem: scaled.
        piece: (k,) the modes that push.
        reduction: of the piece to the QP.
        answer: to the QP.
    """
    if answer.infeasible or not np.abs(answer.y).max(initial=0.0) < ENDLESS:
        return None
    point = DescentPoint(piece, *recover(problem, piece, reduction, answer.y, answer.multipliers))
    return point if point.feasible else None


def flipped(piece: Bools, flips: Iterable[Ints]) -> Iterator[Bools]:
    """The piece with some pairs flipped, for each choice of pairs."""
    for flip in flips:
        other = piece.copy()
        other[flip] = ~other[flip]
        yield other
