"""The meshes that `tauten new` compared, as a table."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tauten.service.new import Trial
from tauten.service.tables.numbers import Numbers


def trial_table(trials: Sequence[Trial], chosen: int) -> Numbers:
    """Sizes, tensions and tips of the meshes of a part, half way of the guessed pull.

    Args:
        trials: coarse to fine.
        chosen: index of the mesh that was taken.
    """
    rows = tuple(
        (
            "taken" if index == chosen else "",
            f"{1e3 * trial.size:.3g}",
            f"{trial.nodes:,}",
            f"{trial.effort:.3g}",
            f"{1e3 * float(np.linalg.norm(trial.tip)):.2f}",
            "unknown" if np.isnan(trial.error) else f"{100.0 * trial.error:.1f}",
        )
        for index, trial in enumerate(trials)
    )
    columns = (
        "",
        "size [mm]",
        "nodes",
        "tension [N]",
        "tip moves [mm]",
        "error, estimated [%]",
    )
    return Numbers("meshes, half way of the guessed pull", columns, rows)
