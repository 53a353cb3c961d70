"""Recorded inverse problems: the input of every control step, in one compact file.

A file holds the input of `inverse_problem`, not its output, so that a replay goes through the same code as
the robot did; of the symmetric compliance one triangle. Plain arrays, no pickle.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tauten.controller import energy_scale, inverse_problem
from tauten.controller.qpcc import Qpcc, Start
from tauten.model import Limits, row_layout
from tauten.model.numerics import Array


@dataclass(frozen=True, slots=True)
class Recorded:
    """One step of a controller.

    Attributes:
        W: (m, m) compliance of effectors, cables and contacts [m/N].
        delta_free: (m,) their values after a step without forces [m].
        target: (n_e,) [m].
        limits: of the cables.
        position_prev: (n_a,) pulled lengths commanded before [m].
        h: time step [s].
        epsilon: weight of the elastic energy.
        start: tensions before and the modes that pushed.
    """

    W: Array
    delta_free: Array
    target: Array
    limits: Limits
    position_prev: Array
    h: float
    epsilon: float
    start: Start

    @property
    def n_c(self) -> int:
        """Contact rows."""
        return len(self.delta_free) - len(self.target) - len(self.position_prev)

    def problem(self) -> Qpcc:
        """The inverse problem."""
        layout = row_layout(len(self.target), len(self.position_prev))
        weight = self.epsilon * energy_scale(self.W, layout, self.start.piece)
        return inverse_problem(
            self.W, self.delta_free, self.target, self.position_prev, self.limits, self.h, weight
        )


def save_recorded(path: Path, steps: list[Recorded]) -> None:
    """Write steps of one robot, which have the same cables and effectors."""
    first = steps[0]
    sizes = np.array([step.n_c for step in steps])
    triangles = [step.W[np.tril_indices(len(step.W))] for step in steps]
    limits = first.limits
    np.savez_compressed(
        path,
        n_e=len(first.target),
        n_a=len(first.position_prev),
        n_c=sizes,
        W=np.concatenate(triangles),
        delta_free=np.concatenate([step.delta_free for step in steps]),
        target=np.array([step.target for step in steps]),
        limits=np.array(
            [
                limits.effort_min,
                limits.effort_max,
                limits.position_min,
                limits.position_max,
                limits.rate,
            ]
        ),
        position_prev=np.array([step.position_prev for step in steps]),
        h=first.h,
        epsilon=first.epsilon,
        lam_a=np.array([step.start.lam_a for step in steps]),
        piece=np.concatenate([step.start.piece for step in steps]),
    )


def load_recorded(path: Path) -> list[Recorded]:
    """Read a file of `save_recorded`.

    Raises:
        OSError: it cannot be read.
        ValueError: it is not such a file.
    """
    with np.load(path, allow_pickle=False) as data:
        missing = FIELDS - set(data.files)
        if missing:
            raise ValueError(f"{path}: no recorded inverse problems, {sorted(missing)} missing")
        arrays = {name: data[name] for name in FIELDS}
    sizes = arrays["n_c"]
    m = sizes + int(arrays["n_e"]) + int(arrays["n_a"])
    ends = {
        "W": np.cumsum(m * (m + 1) // 2),
        "delta_free": np.cumsum(m),
        "piece": np.cumsum(sizes),
    }
    parts = {name: np.split(arrays[name], end[:-1]) for name, end in ends.items()}
    return [step_of(arrays, parts, i) for i in range(len(sizes))]


FIELDS = {
    "n_e", "n_a", "n_c", "W", "delta_free", "target", "limits", "position_prev", "h", "epsilon",
    "lam_a", "piece",
}  # fmt: skip


def step_of(arrays: dict[str, Any], parts: dict[str, list[Any]], i: int) -> Recorded:
    """Step i of a file.

    Args:
        arrays: of the file, by name.
        parts: arrays W, delta_free and piece, split into steps.
        i: index of the step.
    """
    n_e, n_a, n_c = int(arrays["n_e"]), int(arrays["n_a"]), int(arrays["n_c"][i])
    m = n_e + n_a + n_c
    W = np.zeros((m, m))
    W[np.tril_indices(m)] = parts["W"][i]
    W = np.tril(W) + np.tril(W, -1).T
    return Recorded(
        W=W,
        delta_free=parts["delta_free"][i],
        target=arrays["target"][i],
        limits=Limits(*arrays["limits"]),
        position_prev=arrays["position_prev"][i],
        h=float(arrays["h"]),
        epsilon=float(arrays["epsilon"]),
        start=Start(arrays["lam_a"][i], parts["piece"][i]),
    )
