"""Contact forces of V-notches that close: a stand-in for a campaign, with its hard properties.

Candidates are finer than the nodes that carry them, so the compliance W is nearly rank-deficient,
forces move over the faces as the notches close, and most candidates never touch.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np
import pytest
from support.robots.thumb import thumb_mesh, thumb_settings

from tauten.model import Robot
from tauten.model.load import build_robot
from tauten.model.numerics import Array, coordinates
from tauten.model.schema import RobotConfig
from tauten.model.tetra import NodalBody
from tauten.reduction.campaign import Design, Snapshots, ramp, run_campaign
from tauten.reduction.contact import (
    ContactBasis,
    ContactProblem,
    ReduceSettings,
    contact_problems,
    make_basis,
)

if sys.platform != "win32":
    import fcntl


def _hats(u: Array, nodes: int) -> Array:
    """Piecewise linear interpolation from evenly spaced nodes on [0, 1]: (len(u), nodes)."""
    at = np.linspace(0.0, 1.0, nodes)
    return np.maximum(0.0, 1.0 - np.abs(u[:, None] - at) / at[1])


def _notch(close_at: float, tilt: float, times: Array) -> Array:
    """min ½ λᵀ W λ + gapᵀ λ, λ ≥ 0 over the times of a closing notch: (63, s)."""
    x, y = np.linspace(0.0, 1.0, 7), np.linspace(0.0, 1.0, 9)
    P = np.kron(_hats(x, 4), _hats(y, 4))  # (63, 16)
    node = np.stack(np.meshgrid(np.linspace(0, 1, 4), np.linspace(0, 1, 4)), axis=-1).reshape(-1, 2)
    distance = np.linalg.norm(node[:, None] - node, axis=-1)
    W = 1e-4 * P @ np.exp(-distance / 0.4) @ P.T
    W += 1e-3 * np.trace(W) / len(W) * np.eye(len(W))
    X, Y = (grid.ravel()[:, None] for grid in np.meshgrid(x, y, indexing="ij"))
    opening = (1.0 - times / close_at) * (0.15 + Y)
    gap = 2e-3 * (opening + 0.3 * tilt * times * (X - 0.5) * Y + 0.4 * times * Y**2)  # (63, s)
    L = np.linalg.cholesky(W)
    return coordinates(L.T, -np.linalg.solve(L, gap))


@pytest.fixture(scope="session")
def forces() -> Array:
    """λ (189, 150) [N] of three notches that close in turn; the first columns are zero."""
    times = np.linspace(0.0, 1.0, 150)
    return np.vstack(
        [_notch(at, tilt, times) for at, tilt in ((0.25, 1.2), (0.4, 0.7), (0.6, 1.0))]
    )


@pytest.fixture(scope="session")
def thumb() -> Robot[NodalBody]:
    """Three blocks and two notches: a robot small enough to run campaigns in seconds."""
    return build_robot(RobotConfig.model_validate(thumb_settings()), thumb_mesh(), "thumb")


@pytest.fixture(scope="session")
def thumb_design(thumb: Robot[NodalBody]) -> Design:
    """From rest to the thumb's largest pull."""
    return ramp(thumb, step=2e-4)


@pytest.fixture(scope="session")
def thumb_folder(
    thumb: Robot[NodalBody], thumb_design: Design, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    """The folder of the campaign of this design, which is complete.

    Processes of the suite share it: the first one makes it, the others wait.
    """
    base = tmp_path_factory.getbasetemp()
    several = "PYTEST_XDIST_WORKER" in os.environ and sys.platform != "win32"
    folder = (base.parent if several else base) / "ramp"
    with folder.with_suffix(".lock").open("a") as lock:
        if sys.platform != "win32":
            fcntl.flock(lock, fcntl.LOCK_EX)
        run_campaign(thumb, thumb_design, folder)
    return folder


@pytest.fixture(scope="session")
def thumb_ramp(thumb: Robot[NodalBody], thumb_design: Design, thumb_folder: Path) -> Snapshots:
    """The equilibria of this campaign."""
    found = run_campaign(thumb, thumb_design, thumb_folder)
    return found.select(found.converged)


@pytest.fixture(scope="session")
def thumb_basis(thumb: Robot[NodalBody], thumb_ramp: Snapshots) -> ContactBasis:
    """Three contact modes of the ramp."""
    return make_basis(thumb, thumb_ramp, ReduceSettings(k=3))[0]


@pytest.fixture(scope="session")
def thumb_problems(thumb: Robot[NodalBody], thumb_ramp: Snapshots) -> tuple[ContactProblem, ...]:
    """The contact problems of all its equilibria with contact."""
    return contact_problems(thumb, thumb_ramp)
