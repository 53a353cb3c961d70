"""Draws the curves of the robot files in `coming_from/sofa` over those that SOFA computed.

    python docs/scripts/sofa_ports.py [DATA] [--figure FILE] [--page FILE] [--results FILE]

DATA is a folder with the meshes and the curves of SOFA, by default `../shared/data/sofa_robots`. Curves are
those of trunk, gripper finger, diamond, tripod, and of the finger on a plate. Elements are ours; those of the
diamond's curve are SOFA's 'large' ones, those of all others take the same rotation as ours.
"""

from __future__ import annotations

import argparse
import json
import os
import tempfile
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from sofa_differences import CHANGES, difference, difference_table
from sofa_robots import MM, port, settled

from tauten.model import Robot, one_blas_thread
from tauten.model.numerics import Array
from tauten.service.tables import Page

DOCS = Path(__file__).resolve().parents[1]
SETTLED = 2e-6  # mm; rows of SOFA that moved more in their last step are no equilibria


@dataclass(frozen=True, slots=True)
class Curve:
    """A robot's tip in states of SOFA.

    Attributes:
        robot: name of its file.
        command: what is on the axis.
        x: (s,) commands.
        tip: (s, 3) of the robot file [mm].
        sofa: (s, 3) of SOFA [mm].
        effort: (s, e) tensions [mN], torques [mN mm] or changes of volume [mm³] of the robot file.
        sofa_effort: (s, e) the same of SOFA.
    """

    robot: str
    command: str
    x: Array
    tip: Array
    sofa: Array
    effort: Array
    sofa_effort: Array

    @property
    def tip_error(self) -> float:
        """Largest distance of the tips [mm]."""
        return float(np.linalg.norm(self.tip - self.sofa, axis=1).max())

    @property
    def effort_error(self) -> float:
        """Largest difference of efforts relative to the largest one."""
        return float(np.abs(self.effort - self.sofa_effort).max() / np.abs(self.sofa_effort).max())


def read_rows(file: Path) -> Any:
    """The settled rows of a curve."""
    rows = np.genfromtxt(file, delimiter=",", names=True)
    return rows[rows["last_max_dx"] < SETTLED]


def columns(rows: Any, *names: str) -> Array:
    """Some columns of a curve: (s, names)."""
    return np.stack([rows[name] for name in names], axis=1)


def tips(rows: Any, name: str = "tip") -> Array:
    """The columns NAME_x, NAME_y and NAME_z: (s, 3) [mm]."""
    return columns(rows, *(f"{name}_{axis}" for axis in "xyz"))


def trunk(data: Path, robot: Robot, every: int) -> Curve:
    """Three cables, of which one is slack at times; SOFA leaves the others out."""
    rows, wound = read_rows(data / "trunk_combo_fpolar.csv")[::every], ("L0", "L1", "S1")
    places = [robot.actuators.names.index(name) for name in wound]
    position, effort = np.full((len(rows), robot.n_a), np.nan), np.zeros((len(rows), robot.n_a))
    position[:, places] = MM * columns(rows, *(f"imposed_{name}" for name in wound))
    effort[:, places] = np.nan
    tip, lam, _ = settled(robot, list(zip(position, effort, strict=True)))
    sofa = columns(rows, *(f"tension_{name}" for name in wound))
    x = rows["state"]
    return Curve("trunk", "state", x, tip, tips(rows), lam[:, places] / MM, sofa)


def gripper_finger(data: Path, robot: Robot, every: int) -> Curve:
    """Pressures to 100 kPa; what stands for the effort is the change of volume."""
    rows = read_rows(data / "gripperfinger_fpolar.csv")[::every]
    none = np.full(1, np.nan)
    pressures = [(none, np.array([1e3 * kilo])) for kilo in rows["pressure_kPa"]]
    tip, _, volume = settled(robot, pressures)
    sofa = rows["volume_growth"][:, None]
    x = rows["pressure_kPa"]
    return Curve("gripper_finger", "pressure [kPa]", x, tip, tips(rows), volume / MM**3, sofa)


def diamond(data: Path, robot: Robot, every: int) -> Curve:
    """The tensions of SOFA's inverse along a circle; what stands for the effort is the shortening [mm]."""
    rows = read_rows(data / "diamond_large_settled.csv")[::every]
    effort = MM * columns(rows, *(f"tension{i}" for i in range(4)))
    none = np.full(4, np.nan)
    tip, _, position = settled(robot, [(none, row) for row in effort])
    sofa = columns(rows, *(f"L0L_{i}" for i in range(4)))
    return Curve("diamond", "target", rows["target"], tip, tips(rows), position / MM, sofa)


def tripod(data: Path, robot: Robot, every: int) -> Curve:
    """Angles of three servos, and the torques of the body on the arms."""
    rows = np.genfromtxt(data / "tripod_low_fpolar.csv", delimiter=",", names=True)[::every]
    torques = np.genfromtxt(data / "tripod_low_fpolar_torque.csv", delimiter=",", names=True)[
        ::every
    ]
    angles = np.radians(columns(rows, *(f"angle{i}_deg" for i in (1, 2, 3))))
    none = np.full(3, np.nan)
    tip, torque, _ = settled(robot, [(row, none) for row in angles])
    sofa = -columns(torques, "torque1_mNmm", "torque2", "torque3")
    x = np.arange(len(rows)).astype(float)
    return Curve("tripod", "state", x, tip, tips(rows, "centre"), 1e6 * torque, sofa)


def finger(data: Path, robot: Robot, every: int) -> Curve:
    """One cable; from 14.5 mm on with two or three nodes on the plate, without friction."""
    rows = read_rows(data / "plate_mu0_fpolar.csv")[::every]
    none = np.full(1, np.nan)
    positions = [(np.array([MM * position]), none) for position in rows["imposed"]]
    tip, effort, _ = settled(robot, positions, "full")
    sofa = rows["tension"][:, None]
    return Curve("finger", "cable [mm]", rows["imposed"], tip, tips(rows), effort / MM, sofa)


CURVES: dict[str, Callable[[Path, Robot, int], Curve]] = {
    "trunk": trunk,
    "gripper_finger": gripper_finger,
    "diamond": diamond,
    "tripod": tripod,
    "finger": finger,
}


def computed(data: Path, name: str, every: int = 1) -> Curve:
    """The curve of a robot file beside that of SOFA, in every so many states."""
    with tempfile.TemporaryDirectory() as folder:
        return CURVES[name](data, port(data, Path(folder), name), every)


def draw(curves: list[Curve], path: Path) -> None:
    """Draw the motion of every tip, SOFA's as lines and the robot file's as points.

    Args:
        curves: of the robots.
        path: of the figure.
    """
    figure = Figure(figsize=(14.0, 3.4), layout="constrained")
    for axes, curve in zip(figure.subplots(1, len(curves)), curves, strict=True):
        for i, axis in enumerate("xyz"):
            start = curve.sofa[0, i]
            axes.plot(curve.x, curve.sofa[:, i] - start, "-", color=f"C{i}", label=f"{axis}, SOFA")
            axes.plot(curve.x, curve.tip[:, i] - start, ".", color=f"C{i}", label=f"{axis}, tauten")
        axes.set(title=f"{curve.robot}: {curve.tip_error:.1g} mm", xlabel=curve.command)
    figure.axes[0].set_ylabel("motion of the tip [mm]")
    figure.axes[0].legend(fontsize=7)
    figure.savefig(path, dpi=120)


def main() -> None:
    """Compute the curves, print their distances and draw them."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    root = Path(os.environ.get("TAUTEN_REFERENCE_DATA", DOCS.parents[1] / "shared" / "data"))
    parser.add_argument("data", nargs="?", type=Path, default=root / "sofa_robots")
    parser.add_argument("--figure", type=Path, default=DOCS / "figures" / "sofa-ports.png")
    parser.add_argument("--page", type=Path, default=DOCS / "tutorials" / "from_sofa.md")
    parser.add_argument("--results", type=Path, default=DOCS / "results" / "sofa-ports.json")
    given = parser.parse_args()
    with one_blas_thread():
        curves = [computed(given.data, name) for name in CURVES]
        changes = [difference(given.data, change) for change in CHANGES]
    results: dict[str, Any] = {}
    for curve in curves:
        print(
            f"{curve.robot}: {len(curve.x)} states, tip {curve.tip_error:.1e} mm, "
            f"effort {curve.effort_error:.1e} of the largest"
        )
        numbers = {name: np.asarray(value).tolist() for name, value in asdict(curve).items()}
        results[curve.robot] = {
            "tip_error_mm": curve.tip_error, "effort_error": curve.effort_error, **numbers,
        }  # fmt: skip
    about = "Written by `python docs/scripts/sofa_ports.py`."
    Page("sofa differences", about, (difference_table(changes, curves),)).put_into(given.page)
    results["differences"] = [asdict(one) for one in changes]
    given.results.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    draw(curves, given.figure)


if __name__ == "__main__":
    main()
