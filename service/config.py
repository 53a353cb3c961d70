"""From names on the command line to a robot with its contact basis and a warm controller."""

from __future__ import annotations

import gc
import hashlib
import platform
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np
from tauten.controller import Controller
from tauten.model import Robot, load_robot
from tauten.model.load import robot_path
from tauten.reduction import ContactBasis
from threadpoolctl import threadpool_limits

NO_BASIS = "none"
_WARM_UP = 12  # control steps; enough for every kernel to be compiled or loaded
_PACKAGES = (
    "tauten",
    "numpy",
    "scipy",
    "numba",
    "eclipse-zenoh",
    "rosbags",
    "mcap",
    "daqp",
    "proxsuite",
    "osqp",
    "pypardiso",
    "cvxopt",
)


@dataclass(frozen=True, slots=True)
class Setup:
    """What a controller is made from.

    Attributes:
        robot: the robot.
        path: its file.
        basis: its contact basis; None: the controller knows no contact.
        basis_name: as asked for.
    """

    robot: Robot
    path: Path
    basis: ContactBasis | None
    basis_name: str

    def basis_digest(self) -> str:
        """SHA-256 of the modes; "" without basis."""
        if self.basis is None:
            return ""
        return hashlib.sha256(np.ascontiguousarray(self.basis.Psi).tobytes()).hexdigest()

    def metadata(self) -> dict[str, str]:
        """What a log says about the run, all as text."""
        robot = self.robot
        return {
            "robot": robot.name,
            "robot_path": str(self.path),
            "robot_digest": robot.digest,
            "robot_file": self.path.read_text(encoding="utf-8"),
            "rate": repr(robot.config.controller.rate),
            "basis": self.basis_name,
            "basis_digest": self.basis_digest(),
            "factorisation": robot.factorisation.name,
            "python": platform.python_version(),
            "machine": f"{platform.system()} {platform.machine()}",
            **{f"version {name}": found for name, found in versions().items()},
        }


def load_setup(robot: str | Path, rate: float | None = None, basis: str | None = None) -> Setup:
    """Load a robot and the contact basis it asks for.

    Args:
        robot: name of a shipped robot or path of a robot file.
        rate: another control rate than the file's [Hz].
        basis: another basis than the file's; "none" for no contact.

    Raises:
        RobotFileError, MeshError, BasisError: what cannot be used, and why.
    """
    path = robot_path(robot)
    loaded = load_robot(path, rate=rate)
    name = basis or loaded.config.controller.basis or NO_BASIS
    if name == NO_BASIS:
        return Setup(loaded, path, None, NO_BASIS)
    beside = path.parent / name
    found = ContactBasis.load(beside if beside.is_file() else name)
    found.check_robot(loaded)
    return Setup(loaded, path, found, name)


def warm_controller(setup: Setup) -> Controller:
    """A controller at rest, with every kernel it needs compiled.

    It first follows a target a tenth of the robot's size away, so that the first real step is as
    fast as the others.
    """
    controller = Controller(setup.robot, setup.basis)
    away = controller.effector + 0.1 * setup.robot.mesh.size / np.sqrt(3.0)
    for _ in range(_WARM_UP):
        controller.step(away)
    controller.reset()
    controller.prepare()
    return controller


@contextmanager
def real_time() -> Iterator[None]:
    """BLAS on one thread and the garbage collector under the loop's control.

    What exists at the start is taken out of the collector's sight; the loop calls `gc.collect` when
    it has time to spare.
    """
    with threadpool_limits(limits=1):
        gc.collect()
        gc.freeze()
        gc.disable()
        try:
            yield
        finally:
            gc.enable()
            gc.unfreeze()


def versions() -> dict[str, str]:
    """Versions of the packages that numbers depend on, of those that are installed."""
    found = {}
    for name in _PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found
