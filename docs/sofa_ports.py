"""Draws the curves of the robot files in `coming_from/sofa` over those that SOFA computed.

    python docs/sofa_ports.py [DATA] [--figure FILE] [--page FILE] [--results FILE]

DATA is a folder with the meshes and the curves of SOFA, by default `../shared/data/sofa_robots`. Curves are
those of trunk, gripper finger, diamond, tripod, and of the finger on a plate. Elements are ours; those of the
diamond's curve are SOFA's 'large' ones, those of all others take the same rotation as ours.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import meshio
import numpy as np
from matplotlib.figure import Figure

from tauten.model import Simulator, load_robot
from tauten.model.constraints import ConstrainedRobot
from tauten.model.numerics import Array
from tauten.model.tetra import TetRobot
from tauten.service.process import one_blas_thread
from tauten.service.tables import Numbers, Page

DOCS = Path(__file__).resolve().parent
FILES = DOCS / "coming_from" / "sofa"
SETTLED = 2e-6  # mm; rows of SOFA that moved more in their last step are no equilibria
MM = 1e-3
PLATE = ((-150.0, 40.0, -40.0), (50.0, 60.0, 60.0))  # corners [mm]
Robot = TetRobot | ConstrainedRobot


@dataclass(frozen=True, slots=True)
class Source:
    """Where the mesh of a robot is in the data.

    Attributes:
        file: the file of the mesh, or the model that has its nodes.
        mesh: name that the robot file has for it.
        surface: name that the robot file has for the surface of its chamber; "": it has no chamber.
        moved: (3,) what the scene moves the mesh by, after a turn by 90° about x [mm]; None: it does not.
    """

    file: str
    mesh: str
    surface: str = ""
    moved: tuple[float, float, float] | None = None


SOURCES = {
    "accordion": Source("accordion_model.npz", "Springy.vtk", "Springy_Cavity.stl"),
    "diamond": Source("diamond.vtu", "diamond.vtu"),
    "finger": Source("../softrobots_finger.vtk", "finger.vtk"),
    "gripper_finger": Source("gripperfinger_model.npz", "pneunetCutCoarse.vtk", "pneunetCavityCut.stl"),
    "pneunets": Source("pneunets_model.npz", "PneuNets.vtk", "PneuNets_Cavity.stl"),
    "tripod": Source("tripod_low_model.npz", "tripod_low.vtu", moved=(0.0, 30.0, 0.0)),
    "trunk": Source("trunk.vtk", "trunk.vtk"),
}  # fmt: skip


def port(data: Path, folder: Path, name: str) -> Robot:
    """The robot of a file of `coming_from/sofa`.

    Args:
        data: with the meshes.
        folder: where the file is copied to, beside its mesh.
        name: of the robot.
    """
    source = SOURCES[name]
    path = shutil.copy(FILES / f"{name}.toml", folder)
    if source.file.endswith(".npz"):
        write_meshes(np.load(data / source.file), folder, source)
    else:
        shutil.copy(data / source.file, folder / source.mesh)
    if name == "finger":
        write_plate(folder / "plate.vtu")
    robot = load_robot(path)
    assert isinstance(robot, Robot)
    return robot


def write_meshes(model: Any, folder: Path, source: Source) -> None:
    """Write the mesh of a model as SOFA loads it, and the surface of its chamber."""
    nodes: Array = model["nodes"]
    if source.moved is not None:
        x, y, z = (nodes - source.moved).T
        nodes = np.stack([x, z, -y], axis=1)  # turned back about x
    cells = [("tetra", model["tets"].astype(np.int64))]
    meshio.write_points_cells(folder / source.mesh, nodes, cells)
    if source.surface:
        triangles = [("triangle", model["cavity_triangles"].astype(np.int64))]
        meshio.write_points_cells(folder / source.surface, model["cavity_nodes"], triangles)


def write_plate(path: Path) -> None:
    """Write a box of six tetrahedra, the plate that the finger presses onto."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    tets = [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]]
    meshio.write_points_cells(
        path, np.choose(corners, np.array(PLATE)), [("tetra", np.array(tets))]
    )


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


def settled(
    robot: Robot, commands: list[tuple[Array, Array]], contact: str = "none"
) -> tuple[Array, Array, Array]:
    """Tips (s, 3) [mm], efforts (s, n_a) and positions (s, n_a) under pairs of positions and efforts."""
    simulator, found = Simulator(robot, contact=contact), []
    for pull, tension in commands:
        if not simulator.settle(pull, tension, tolerance=1e-9).converged:
            raise RuntimeError(f"{robot.name}: no equilibrium at {pull}, {tension}")
        found.append((simulator.effector[0] / MM, simulator.tension, simulator.pull))
    tip, effort, position = (np.array(part) for part in zip(*found, strict=True))
    return tip, effort, position


def trunk(data: Path, robot: Robot, every: int) -> Curve:
    """Three cables, of which one is slack at times; SOFA leaves the others out."""
    rows, wound = read_rows(data / "trunk_combo_fpolar.csv")[::every], ("L0", "L1", "S1")
    places = [robot.actuators.names.index(name) for name in wound]
    pull, tension = np.full((len(rows), robot.n_a), np.nan), np.zeros((len(rows), robot.n_a))
    pull[:, places] = MM * columns(rows, *(f"imposed_{name}" for name in wound))
    tension[:, places] = np.nan
    tip, effort, _ = settled(robot, list(zip(pull, tension, strict=True)))
    sofa = columns(rows, *(f"tension_{name}" for name in wound))
    x = rows["state"]
    return Curve("trunk", "state", x, tip, tips(rows), effort[:, places] / MM, sofa)


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
    tension = MM * columns(rows, *(f"tension{i}" for i in range(4)))
    none = np.full(4, np.nan)
    tip, _, pull = settled(robot, [(none, row) for row in tension])
    sofa = columns(rows, *(f"L0L_{i}" for i in range(4)))
    return Curve("diamond", "target", rows["target"], tip, tips(rows), pull / MM, sofa)


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
    pulls = [(np.array([MM * pull]), none) for pull in rows["imposed"]]
    tip, tension, _ = settled(robot, pulls, "full")
    sofa = rows["tension"][:, None]
    return Curve("finger", "cable [mm]", rows["imposed"], tip, tips(rows), tension / MM, sofa)


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


@dataclass(frozen=True, slots=True)
class Difference:
    """What a setting changes in one state.

    Attributes:
        setting: of the robot file, as SOFA has it.
        robot: name of the file.
        state: in words.
        tip: distance of the tips with and without it [mm].
        effort: largest difference of efforts and positions, relative to the largest with it.
    """

    setting: str
    robot: str
    state: str
    tip: float
    effort: float


@dataclass(frozen=True, slots=True)
class Change:
    """A setting and the state in which it is left out.

    Attributes:
        setting: in words.
        robot: name of the file.
        state: in words.
        without: texts of the file that stand for the setting, and what replaces them.
        pull: positions by name of the actuator.
        tension: efforts by name of the actuator; cables without either are slack.
        both: texts of the file that are replaced with and without the setting.
    """

    setting: str
    robot: str
    state: str
    without: tuple[tuple[str, str], ...]
    pull: dict[str, float]
    tension: dict[str, float]
    both: tuple[tuple[str, str], ...] = ()


FALL = (("gravity = [0.0, 0.0, 0.0]", "gravity = [0.0, -9.81, 0.0]"),)
CHANGES = (
    Change(
        'extrapolate_from = "centre"', "trunk", "cable L0 at 15 mm",
        (('extrapolate_from = "centre"\n', ""),), {"L0": 0.015}, {},
    ),
    Change(
        'mass = "nodes"', "trunk", "gravity along −y, cable L0 at 10 mm",
        (('mass = "nodes"\n', ""),), {"L0": 0.010}, {}, FALL,
    ),
    Change(
        "own_surface = true", "pneunets", "3 kPa",
        (("own_surface = true\n", ""), ("max_outside = 1e-5\n", "")), {}, {"air": 3e3},
    ),
    Change(
        "own_surface = true", "gripper_finger", "60 kPa",
        (("own_surface = true\n", ""),), {}, {"air": 6e4},
    ),
    Change(
        "contact.distance = 1e-3", "finger", "cable at 25 mm",
        (("distance = 1e-3 ", "distance = 0.0 "),), {"tendon": 0.025}, {},
    ),
    Change(
        'points = "vertices"', "finger", "cable at 25 mm",
        (('points = "vertices"\n', ""),), {"tendon": 0.025}, {},
    ),
)  # fmt: skip


def difference(data: Path, change: Change) -> Difference:
    """How far a robot in a state is from the one without a setting.

    Args:
        data: with the meshes.
        change: the setting.
    """
    found = []
    for replaced in (change.both, (*change.both, *change.without)):
        with tempfile.TemporaryDirectory() as folder:
            port(data, Path(folder), change.robot)
            path = Path(folder) / f"{change.robot}.toml"
            text = path.read_text(encoding="utf-8")
            for old, new in replaced:
                if old not in text:
                    raise ValueError(f"{path.name}: {old!r} is not in it")
                text = text.replace(old, new)
            path.write_text(text, encoding="utf-8")
            robot = load_robot(path)
        pull, tension = np.full(robot.n_a, np.nan), np.zeros(robot.n_a)
        for name, value in change.pull.items():
            place = robot.actuators.names.index(name)
            pull[place], tension[place] = value, np.nan
        for name, value in change.tension.items():
            tension[robot.actuators.names.index(name)] = value
        found.append(settled(robot, [(pull, tension)], "full"))  # type: ignore[arg-type]
    (tip, *efforts), (other, *others) = found
    given = (
        1 if change.pull else 0
    )  # efforts where positions are given, positions where efforts are
    effort = efforts[1 - given], others[1 - given]
    return Difference(
        change.setting,
        change.robot,
        change.state,
        float(np.linalg.norm(tip - other)),
        float(np.abs(effort[0] - effort[1]).max() / np.abs(effort[0]).max()),
    )


def difference_table(found: list[Difference], curves: list[Curve]) -> Numbers:
    """The differences of settings, and of elements, which no setting takes away."""
    rows = [
        (f"`{one.setting}`", one.robot, one.state, f"{one.tip:.2g}", f"{100.0 * one.effort:.2g}")
        for one in found
    ]
    rows += [
        ("none: `method='large'`", curve.robot, "17 states", f"{curve.tip_error:.2g}",
         f"{100.0 * curve.effort_error:.2g}")
        for curve in curves if curve.robot == "diamond"
    ]  # fmt: skip
    head = ("setting", "robot", "state", "tip [mm]", "effort or position [%]")
    return Numbers("", head, tuple(rows), text_columns=3)


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
    about = "Written by `python docs/sofa_ports.py`."
    Page("sofa differences", about, (difference_table(changes, curves),)).put_into(given.page)
    results["differences"] = [asdict(one) for one in changes]
    given.results.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    draw(curves, given.figure)


if __name__ == "__main__":
    main()
