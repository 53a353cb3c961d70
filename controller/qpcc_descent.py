"""The active set over the pieces of a QPCC: solve a piece, read its multipliers, flip, repeat."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from tauten.controller.certificate import judge
from tauten.controller.qp import Backend, Qp
from tauten.controller.qpcc_pieces import recover, reduce_piece
from tauten.controller.qpcc_scaling import Scaled
from tauten.model.arrays import Array, Bools

EXACT = 1e-8  # residuals an optimum may have


@dataclass(frozen=True, slots=True)
class Point:
    """Optimum of a piece.

    Attributes:
        z: (n,) scaled variables.
        piece: (k,) which modes push.
        objective: scaled.
        primal: residual.
        complementarity: residual.
        stationarity: residual of the piece's own optimality.
        wrong: (k,) pairs at zero that the multipliers want flipped.
        alpha: (n_a,) multipliers of the bounds.
        dual: (2k + p,) multipliers of the rows.
    """

    z: Array
    piece: Bools
    objective: float
    primal: float
    complementarity: float
    stationarity: float
    wrong: Bools
    alpha: Array
    dual: Array

    @property
    def feasible(self) -> bool:
        """Within the limits and complementary."""
        return max(self.primal, self.complementarity) <= EXACT

    @property
    def stationary(self) -> bool:
        """Strongly stationary: no multiplier asks for a flip."""
        return self.stationarity <= EXACT and not self.wrong.any()


def solve_piece(problem: Scaled, piece: Bools, backend: Backend) -> Point | None:
    """Optimum of one piece; None when the piece is empty or the back end failed."""
    p = problem
    possible, H, f, A, lower, upper, reduction = reduce_piece(
        p.Q, p.c, p.lb, p.ub, p.R, p.r, p.lo, p.hi, piece
    )
    if not possible:
        return None
    answer = backend(Qp(H, f, A, lower, upper))
    if not answer.solved:
        return None
    z, alpha, dual = recover(
        p.Q, p.c, p.lb, p.ub, p.R, piece, reduction, answer.y, answer.multipliers
    )
    residuals = judge(p.Q, p.c, p.lb, p.ub, p.R, p.r, p.lo, p.hi, z, alpha, dual)
    primal, crossed, stationarity, wrong = residuals
    if not max(primal, crossed) <= EXACT:  # also when NaN
        return None
    return Point(z, piece, p.objective(z), primal, crossed, stationarity, wrong, alpha, dual)


@dataclass(slots=True)
class Descent:
    """One descent: what has been tried, what was best.

    Attributes:
        problem: scaled.
        backend: of the piece's QPs.
        max_pivots: pieces solved at most, over all runs.
        tried: pieces solved, as bytes: none is solved twice.
        best: best point so far.
    """

    problem: Scaled
    backend: Backend
    max_pivots: int
    tried: set[bytes] = field(default_factory=set)
    best: Point | None = None

    @property
    def pivots(self) -> int:
        """Pieces solved."""
        return len(self.tried)

    def run(self, piece: Bools) -> Point | None:
        """Descend from a piece to a stationary point; None when the piece is empty."""
        current = self.visit(piece)
        while current is not None and not current.stationary:
            following = self.improve(current)
            if following is None:
                break
            current = following
        return current

    def visit(self, piece: Bools) -> Point | None:
        """Solve a piece unless it was solved before or the limit is reached."""
        key = piece.tobytes()
        if key in self.tried or self.pivots >= self.max_pivots:
            return None
        self.tried.add(key)
        point = solve_piece(self.problem, piece, self.backend)
        if point is not None and (self.best is None or point.objective < self.best.objective):
            self.best = point
        return point

    def improve(self, current: Point) -> Point | None:
        """A better neighbour: all wrong pairs flipped at once, else one by one."""
        wrong = np.flatnonzero(current.wrong)
        flips = [wrong] if len(wrong) == 1 else [wrong, *wrong[:, None]]
        for flip in flips:
            piece = current.piece.copy()
            piece[flip] = ~piece[flip]
            point = self.visit(piece)
            if point is not None and (point.objective < current.objective or point.stationary):
                return point
        return None
