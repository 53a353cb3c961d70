"""Draws docs/figures/qpcc.svg, the pieces of two small QPCCs and what the solver does on them.

python docs/scripts/qpcc_figure.py
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import matplotlib

matplotlib.use("svg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap

from tauten.controller.qpcc import (
    Budget,
    Descent,
    DescentPoint,
    Qpcc,
    TimeLimit,
    scale,
    solve_daqp,
    solve_qpcc,
)
from tauten.model.numerics import Array, Bools, solve_lcp

FILE = Path(__file__).resolve().parents[1] / "figures" / "qpcc.svg"
COLOURS = ListedColormap(["#ffffff", "#dbe9f6", "#fde6cf", "#e3dcee"])
NAMES = ("both open", "1 pushes", "2 pushes", "both push")
TARGET = np.array([1.25, 0.85])


def two_cables() -> Qpcc:
    """Two tensions, two contacts; the tip moves with the tensions and is held back by the contacts."""
    tip = np.array([[1.0, -0.1, -0.75, 0.1], [-0.1, 1.0, 0.1, -0.6]])  # (2, 4)
    return Qpcc(
        Q=tip.T @ tip + np.diag([0.02, 0.02, 0.0, 0.0]),
        c=-tip.T @ TARGET,
        lb=np.zeros(2),
        ub=np.full(2, 3.0),
        G=np.zeros((0, 4)),
        g_lo=np.zeros(0),
        g_hi=np.zeros(0),
        M=np.array([[-1.0, -0.35, 1.0, 0.3], [-0.25, -1.0, 0.3, 1.0]]),
        m=np.array([1.0, 1.35]),
        constant=0.5 * float(TARGET @ TARGET),
    )


def one_cable() -> Qpcc:
    """One tension; a first contact turns the tip back, a second one sends it forwards again."""
    tip = np.array([1.0, -1.5, 2.0])
    target = 1.45
    return Qpcc(
        Q=np.outer(tip, tip),
        c=-target * tip,
        lb=np.zeros(1),
        ub=np.array([4.0]),
        G=np.zeros((0, 3)),
        g_lo=np.zeros(0),
        g_hi=np.zeros(0),
        M=np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]]),
        m=np.array([1.0, 1.4]),
        constant=0.5 * target**2,
    )


@dataclass(slots=True)
class Watched(Descent):
    """A descent that records its points."""

    points: list[DescentPoint] = field(default_factory=list)

    def solve_new_piece(self, piece: Bools) -> DescentPoint | None:
        """As the descent does."""
        point = Descent.solve_new_piece(self, piece)
        if point is not None:
            self.points.append(point)
        return point


def forces(problem: Qpcc, a: Array) -> tuple[Array, int, float]:
    """Contact forces at tensions a, number of the piece, objective."""
    n_a = len(a)
    q = problem.m + problem.M[:, :n_a] @ a
    beta = solve_lcp(problem.M[:, n_a:].copy(), q).lam
    pushes = beta > 0.0
    return beta, int(pushes[0]) + 2 * int(pushes[1]), problem.objective(a, beta)


def path(problem: Qpcc, start: Array) -> list[tuple[Array, float]]:
    """Tensions and objectives of the start and of each piece's optimum."""
    n_a = len(start)
    _, scaled, units = scale(problem)
    descent = Watched(scaled, solve_daqp, Budget(100, TimeLimit()))
    beta, _, value = forces(problem, start)
    descent.run(beta > 0.0)
    found = [
        (
            point.z[:n_a] * units.column[:n_a],
            point.residuals.objective * units.cost + problem.constant,
        )
        for point in descent.points
    ]
    return [(start, value), *found]


def draw_plane(axes: Axes) -> None:
    """Pieces, level lines of the objective and the way of the active set in the plane of tensions."""
    problem = two_cables()
    x, y = np.linspace(0.0, 3.0, 301), np.linspace(0.0, 2.6, 261)
    cells = [[forces(problem, np.array([u, v])) for u in x] for v in y]
    pieces = np.array([[cell[1] for cell in row] for row in cells])
    values = np.array([[cell[2] for cell in row] for row in cells])
    axes.pcolormesh(x, y, pieces, cmap=COLOURS, vmin=0, vmax=3, shading="nearest", rasterized=True)
    axes.contour(x, y, pieces, levels=[0.5, 1.5, 2.5], colors="#888888", linewidths=0.8)
    levels = values.min() + np.linspace(0.02, 1.0, 14) ** 2
    axes.contour(x, y, values, levels=levels, colors="#5b7a99", linewidths=0.6)
    for number, name in enumerate(NAMES):
        rows, columns = np.nonzero(pieces == number)
        axes.text(*((0.1, 0.08), (2.35, 0.08), (0.1, 2.45), (2.35, 2.45))[number], name, fontsize=9)
        assert len(rows) and len(columns), f"the example has no piece where {name}"
    for start, marker in (((0.1, 0.35), "-o"), ((0.12, 2.1), "--s")):
        points = np.array([a for a, _ in path(problem, np.array(start))])
        axes.plot(*points.T, marker, color="#b03030", markersize=4, linewidth=1.3)
        for number, point in enumerate(points[:-1]):
            axes.annotate(
                str(number), point, xytext=(6, -11), textcoords="offset points", color="#b03030"
            )
    axes.set(xlabel="tension 1", ylabel="tension 2", title="Two cables, two contact modes")


def draw_line(axes: Axes) -> None:
    """The objective over one tension: kinks, a local optimum, the global one."""
    problem = one_cable()
    a = np.linspace(0.0, 4.0, 401)
    cells = [forces(problem, np.array([value])) for value in a]
    pieces, values = np.array([cell[1] for cell in cells]), np.array([cell[2] for cell in cells])
    axes.pcolormesh(
        a, [-0.05, 1.15], np.vstack([pieces, pieces]), cmap=COLOURS, vmin=0, vmax=3,
        shading="nearest", rasterized=True,
    )  # fmt: skip
    axes.plot(a, values, color="#5b7a99")
    local = path(problem, np.array([0.2]))
    best = solve_qpcc(problem)
    axes.plot(
        [point[0] for point, _ in local], [value for _, value in local], "-o",
        color="#b03030", markersize=4, linewidth=1.3,
    )  # fmt: skip
    axes.plot(best.lam_a[0], best.objective, "*", color="#207030", markersize=12)
    axes.annotate(
        "active set", (local[-1][0][0], local[-1][1]), xytext=(-62, -4), color="#b03030",
        textcoords="offset points",
    )  # fmt: skip
    for place, number in ((0.05, 0), (1.02, 1), (3.3, 3)):
        axes.text(place, 1.05, NAMES[number], fontsize=9)
    axes.annotate(
        "second start", (best.lam_a[0], best.objective), xytext=(-130, -5), color="#207030",
        textcoords="offset points",
    )  # fmt: skip
    axes.set(xlabel="tension", ylabel="objective", ylim=(-0.05, 1.1), xlim=(0.0, 4.0))
    axes.set_title("One cable, two contact modes")


def main() -> None:
    """Write the figure."""
    plt.rcParams["svg.hashsalt"] = "tauten"  # the same file every time
    figure, axes = plt.subplots(1, 2, figsize=(10.0, 4.3), layout="constrained")
    draw_plane(axes[0])
    draw_line(axes[1])
    figure.savefig(FILE, metadata={"Date": None}, dpi=110)


if __name__ == "__main__":
    main()
