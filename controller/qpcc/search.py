"""The second phase: branch and bound over the pieces, best bound first, until time or nodes run out.

A node fixes some modes to push or to be open and relaxes the others to β >= 0, w >= 0: a convex QP
whose value bounds all pieces below. Adding ρ β'w >= 0, which is zero in every piece, to the objective
lifts the bounds; ρ is as large as convexity allows. Every node's point suggests a piece, from which the
descent of the first phase runs.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from tauten.controller.qpcc.descent import NOISE, Descent, Point
from tauten.controller.qpcc.lcp_start import feasible_start
from tauten.controller.qpcc.qp import UNBOUNDED, Qp, RepeatedQp
from tauten.controller.qpcc.qp_bound import lower_bound
from tauten.controller.qpcc.scaling import Scaled
from tauten.model.numerics import Array

CROSSED = 1e-10  # a pair whose smaller side is below this needs no branching
REACHED = 1e-7  # relative, how far a piece's optimum may lie above its relaxation
Choice = NDArray[np.int8]  # (k,) 1 pushes, -1 open, 0 undecided
Node = tuple[float, int, float, Choice]  # rank, a number that breaks ties, bound, choice


@dataclass(frozen=True, slots=True)
class Budget:
    """When to stop.

    Attributes:
        seconds: of wall time.
        nodes: relaxations solved.
        gap: relative gap between objective and bound that is as good as none.
        any_point: stop at the first feasible point.
    """

    seconds: float = np.inf
    nodes: int = 1_000_000
    gap: float = 1e-6
    any_point: bool = False


@dataclass(frozen=True, slots=True)
class Proof:
    """What a search has shown.

    Attributes:
        bound: no point but the best one has a lower scaled objective, constant excluded; +inf: there
            is no other.
        nodes: relaxations solved.
    """

    bound: float
    nodes: int


def branch_and_bound(descent: Descent, offset: float, budget: Budget) -> Proof:
    """Improve `descent.best` until it is shown to be the global optimum or the budget is spent.

    Args:
        descent: where points are kept.
        offset: the problem's constant in scaled units, to which the gap is relative.
        budget: when to stop.
    """
    proof = explore(Tree(descent.problem), descent, offset, budget)
    best = descent.best
    if best is not None and proof.bound >= close_enough(descent, best, offset, budget.gap):
        descent.best = replace(best, settled=True)
        if proof.bound >= close_enough(descent, best, offset, 0.0):
            proof = replace(proof, bound=np.inf)
    return proof


def explore(tree: Tree, descent: Descent, offset: float, budget: Budget) -> Proof:
    """Until nothing below the best point is left or the budget is spent.

    The lowest bound comes first; the deepest node, where any point will do.
    """
    if not tree.usable:
        return Proof(-np.inf, 0)
    end = perf_counter() + budget.seconds
    heap: list[Node] = [(-np.inf, 0, -np.inf, np.zeros(tree.k, dtype=np.int8))]
    nodes, lost = 0, np.inf  # lost: lowest value of a node whose piece could not be solved
    while heap:
        if (
            finished(descent, offset, budget, heap[0])
            or nodes >= budget.nodes
            or perf_counter() > end
        ):
            return Proof(-np.inf if budget.any_point else min(heap[0][2], lost), nodes)
        _, _, bound, choice = heapq.heappop(heap)
        nodes += 1
        value, z = tree.relax(choice)
        if value == np.inf:
            continue
        undecided, piece = try_node(tree, descent, choice, z)
        if undecided is None and not reached(descent.best, value):
            undecided = tree.any_undecided(choice)
            lost = min(lost, value) if undecided is None else lost
        if undecided is not None:
            bound = max(value, bound)
            rank = -float(np.count_nonzero(choice)) if budget.any_point else bound
            for number, side in enumerate((1, -1) if piece[undecided] else (-1, 1)):
                child = choice.copy()
                child[undecided] = side
                heapq.heappush(heap, (rank, 2 * nodes + number, bound, child))
    return Proof(lost, nodes)


def finished(descent: Descent, offset: float, budget: Budget, first: Node) -> bool:
    """Whether what was asked for is there: a point, or none that could be lower."""
    best = descent.best
    if best is None:
        return False
    return budget.any_point or first[2] >= close_enough(descent, best, offset, budget.gap)


def try_node(
    tree: Tree, descent: Descent, choice: Choice, z: Array
) -> tuple[int | None, NDArray[np.bool_]]:
    """Descend from what the point of a relaxation suggests; what `Tree.look` says of it."""
    undecided, piece = tree.look(choice, z)
    descent.run(piece)
    if descent.best is None:  # the contact forces at these tensions are complementary
        n_a = len(descent.problem.lb)
        found, complementary, _ = feasible_start(descent.problem, z[:n_a], piece)
        if found:
            descent.run(complementary)
    return undecided, piece


def close_enough(descent: Descent, best: Point, offset: float, gap: float) -> float:
    """The bound from which on a point counts as the global optimum."""
    value = best.worth.objective
    slope = min(float(np.abs(descent.problem.c).max(initial=0.0)), 1e100)
    # curvatures are one or less: slope² is what objectives are differences of, also around z = 0
    return float(value - gap * abs(value + offset) - NOISE * (best.worth.terms + slope**2))


def reached(best: Point | None, value: float) -> bool:
    """Whether there is a point as low as a relaxation's value."""
    if best is None:
        return False
    return best.worth.objective <= value + REACHED * (abs(value) + best.worth.terms)


class Tree:
    """The relaxations of a problem; only limits change from node to node.

    Attributes:
        k: modes.
    """

    def __init__(self, problem: Scaled) -> None:
        n_a, n = len(problem.lb), len(problem.c)
        self.k = k = n - n_a
        self._R, self._r, self._n_a = problem.R[k : 2 * k], problem.r[k : 2 * k], n_a
        H, f = lifted_objective(problem, k)
        rows = problem.R[k:]
        zero, free = np.zeros(k), np.full(k, UNBOUNDED)
        limits = slice(2 * k, None)
        lower = np.concatenate([problem.lb, zero, -self._r, problem.lo[limits]])
        self._upper = np.concatenate([problem.ub, free, free, problem.hi[limits]])
        self._qp = Qp(H, f, np.ascontiguousarray(rows), lower, self._upper)
        self._solver = RepeatedQp(self._qp)

    @property
    def usable(self) -> bool:
        """Whether the QP library takes the problem."""
        return self._solver.usable

    def relax(self, choice: Choice) -> tuple[float, Array]:
        """The lower bound of a node's pieces, +inf when they are empty, and where it is taken."""
        upper, n_a, k = self._upper.copy(), self._n_a, self.k
        upper[n_a : n_a + k][choice < 0] = 0.0
        upper[n_a + k : n_a + 2 * k][choice > 0] = -self._r[choice > 0]
        answer = self._solver.solve(upper)
        if answer.infeasible:
            return np.inf, answer.y
        return lower_bound(self._qp, upper, answer.y, answer.multipliers), answer.y

    def any_undecided(self, choice: Choice) -> int | None:
        """A mode that is still free."""
        free = np.flatnonzero(choice == 0)
        return int(free[0]) if len(free) else None

    def look(self, choice: Choice, z: Array) -> tuple[int | None, NDArray[np.bool_]]:
        """The most ambiguous undecided mode, None without any, and the piece that z suggests."""
        beta, w = z[self._n_a :], self._R @ z + self._r
        piece = np.where(choice == 0, beta > w, choice > 0)
        ambiguity = np.where(choice == 0, np.minimum(beta, w), 0.0)
        undecided = int(np.argmax(ambiguity)) if self.k else 0
        if self.k == 0 or ambiguity[undecided] <= CROSSED:
            return None, piece
        return undecided, piece


def lifted_objective(problem: Scaled, k: int) -> tuple[Array, Array]:
    """Hessian and gradient of the objective + ρ β'(Mz + m), with the largest ρ = 2⁻ⁱ that is convex."""
    n = len(problem.c)
    product, linear = np.zeros((n, n)), np.zeros(n)
    product[n - k :] = problem.R[k : 2 * k]
    product += product.T
    linear[n - k :] = problem.r[k : 2 * k]
    for rho in 2.0 ** -np.arange(0.0, 24.0):
        if convex(problem.Q + rho * product):
            return problem.Q + rho * product, problem.c + rho * linear
    return problem.Q, problem.c


def convex(H: Array) -> bool:
    """Whether a matrix is positive semidefinite up to round-off."""
    try:
        np.linalg.cholesky(H + 1e-13 * np.max(np.diag(H), initial=0.0) * np.eye(len(H)))
    except np.linalg.LinAlgError:
        return False
    return True
