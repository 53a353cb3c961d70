"""`tauten new` tries what it writes: parts that sag, with small holes, tapered, hollow."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.robots.bodies import box_mesh

from tauten.controller import Controller
from tauten.model import ActuatorKind, Simulator, load_robot
from tauten.model.mesh import TetMesh
from tauten.model.points import attach
from tauten.service.check import CheckSettings, Finding, RobotCheck, check_robot
from tauten.service.check.control_findings import step_time
from tauten.service.check.findings import Level
from tauten.service.new import Made, NewRobot, Trial, make_new_robot, mesher, meshing, read_part
from tauten.service.new.choice import chosen_trial, compared, finer_than, verdict
from tauten.service.new.guesses import guess_fields
from tauten.service.new.make import write_files
from tauten.service.new.meshing import mesh_part
from tauten.service.new.side_cable import in_mesh
from tauten.service.new.template import Values, chamber_tables, robot_text
from tauten.service.new.trial import HALF, PRESSURE, Reached, inflated
from tauten.service.process import StopFlag
from tauten.service.setup import load_setup

occ = pytest.importorskip("netgen.occ", reason="tauten[mesh] is not installed")
LENGTH = 90.0  # mm


@pytest.fixture(scope="module", autouse=True)
def meshed_here() -> Iterator[None]:
    """The mesher needs no process of its own here: those of `test_new_robot` have one."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(meshing, "_run", lambda arguments, path: mesher.main(arguments))
        yield


def notched() -> Any:
    """A horizontal finger with notches below: its cable belongs there, and its weight bends it so."""
    solid = occ.Box((0, 0, 0), (LENGTH, 16, 18))
    for number in range(5):
        x = 14 + 15 * number
        solid = solid - occ.Box((x, -1, -1), (x + 4, 17, 11))
    return solid


def made_of(solid: Any, folder: Path, **options: Any) -> Made:
    """The robot of a solid."""
    solid.WriteStep(str(folder / "part.step"))
    new = NewRobot("part", read_part(folder / "part.step", "mm", False), **options)
    return make_new_robot(new, folder / "part", StopFlag(), lambda _share, _what="": None)


@pytest.fixture(scope="module")
def sagging(tmp_path_factory: pytest.TempPathFactory) -> Made:
    """The notched finger, of one mesh."""
    return made_of(notched(), tmp_path_factory.mktemp("sagging"), size=8e-3)


@pytest.mark.long
def test_a_part_that_sags_towards_its_cable_decides_from_its_start(sagging: Made) -> None:
    """Half of the guessed pull left the cable slack, and the comparison of meshes divided by no tension."""
    setup = load_setup(sagging.file)
    robot = setup.robot
    simulator = Simulator(robot, "none")
    assert simulator.settle_start().converged
    slack = float(simulator.position[0])
    assert slack > 1.1e-3
    assert robot.limits.position_max[0] == pytest.approx(slack + 9e-3, rel=1e-3)
    assert sagging.usable
    controller = Controller(robot, setup.contact, settings=setup.controller)
    assert controller.settle_start().converged
    start = controller.effector
    assert simulator.settle(position=[slack + 4e-3]).converged
    goal = simulator.effector
    assert np.linalg.norm(goal - start) > 5e-3
    for _ in range(90):
        assert controller.step(goal).status.ok
    assert np.linalg.norm(controller.effector - goal) < 1e-4


@pytest.mark.long
def test_new_and_check_say_the_same_of_a_mesh(sagging: Made) -> None:
    again = check_robot(CheckSettings(str(sagging.file)), StopFlag(), lambda _share, _what="": None)
    same = [
        [item for item in check.findings if item.subject != "control step against period"]
        for check in (sagging.check, again)
    ]
    assert same[0] == same[1]
    assert sagging.check.estimate is not None
    own, *others = sagging.check.estimate.variants
    # loads at which the cable is slack compare nothing; the mesh to compare with is the one farther away
    assert all(
        state.effort[0] > 0.0 for found in sagging.check.estimate.states for state in found.states
    )
    assert own.tip is not None
    assert all(other.tip is not None and other.tip <= own.tip + 1e-3 for other in others)


def reached(tip: float) -> Reached:
    """Where a mesh was moved to, with its tip somewhere along x [m]."""
    return Reached(1.0, np.array([tip, 0.0, 0.0]), 0.1, 1.0, 0.0)


def test_the_mesh_that_is_taken_has_control_steps_in_time() -> None:
    def trial(nodes: int, tip: float, step: float) -> Trial:
        return Trial(1e-3, nodes, reached(tip), step)

    def chosen(*steps: float) -> int:
        tips = (0.03, 0.02, 0.005, 0.0)
        trials = [trial(300 * i, *both) for i, both in enumerate(zip(tips, steps, strict=True), 1)]
        return chosen_trial(compared(trials), 0.1)

    assert chosen(0.01, 0.01, 0.01, 0.01) == 2
    assert chosen(0.01, 0.03, 0.05, 0.2) == 1
    # none is in time: it needs a reduced model, whose steps do not grow with the mesh
    assert chosen(0.05, 0.1, 0.2, 0.3) == 2
    assert chosen(0.05, np.nan, np.nan, np.nan) == 2


@pytest.mark.parametrize(
    ("step", "difference", "level", "said", "unsaid"),
    [
        (0.01, 0.0, "fine", "fit the rate", ("reduce", "--size")),
        (0.01, 0.0, "wrong", "--size 0.7, and then tauten reduce", ()),
        (0.1, 0.0, "fine", "Next: tauten reduce part.toml --states --write", ("--size",)),
        (0.1, 0.0, "wrong", "first tauten new with --size 0.7", ()),
    ],
)
def test_there_is_one_verdict(
    step: float, difference: float, level: Level, said: str, unsaid: tuple[str, ...]
) -> None:
    """A finer mesh and a lower rate were advised side by side."""
    trials = (Trial(1e-3, 300, reached(0.0), step, difference),)
    check = RobotCheck("part", (Finding("error of the mesh", level, "", "refine the mesh"),))
    found = verdict(trials, 0, 0.1, Path("part.toml"), check, True)
    assert found.startswith("Verdict: ") and said in found
    assert "rate =" not in found
    assert not [word for word in unsaid if word in found]


def test_the_mesh_that_is_advised_is_finer_than_all_of_as_many_nodes() -> None:
    """Of a part with small details sizes of 4.3 to 2 mm all gave 6,000 nodes, and 3 mm was advised."""

    def advised(*meshes: tuple[float, int]) -> float:
        trials = [Trial(size, n, reached(0.0), 0.1) for size, n in meshes]
        return finer_than(tuple(trials), trials[0])

    assert advised((4e-3, 5900), (3e-3, 5920), (2e-3, 6160)) < 2e-3
    assert advised((4e-3, 300), (3e-3, 610), (2e-3, 2000)) == 3e-3


def test_no_lower_rate_is_advised_beside_a_finer_mesh(tmp_path: Path) -> None:
    file = tmp_path / "part.toml"
    file.write_text('name = "part"\n')
    both = [step_time(0.1, 0.02, file, False, slower) for slower in (True, False)]
    assert ["controller.rate" in one.advice for one in both] == [True, False]
    assert all(f"tauten reduce {file}" in one.advice for one in both)


@pytest.mark.long
def test_small_holes_do_not_make_the_mesh_large(tmp_path: Path) -> None:
    """A channel of 1.6 mm took a mesh of 300 nodes to 10,000."""
    channel = occ.Cylinder((-1, 8, 3), occ.X, 0.8, LENGTH + 2)
    (notched() - channel).WriteStep(str(tmp_path / "holed.step"))
    part = read_part(tmp_path / "holed.step", "mm", False)
    mesh = mesh_part(part, part.size_for(300))
    assert len(mesh.nodes) < 1500
    assert float(mesh.volumes.sum()) == pytest.approx(part.volume, rel=0.01)


@pytest.mark.long
def test_the_cable_follows_the_side_of_a_tapered_part_to_its_tip(tmp_path: Path) -> None:
    """It ended where the body becomes thinner than its distance from the axis."""
    wires = []
    for share in np.linspace(0.0, 1.0, 7):
        width = 24.0 * (1.0 - 0.6 * share)
        plane = occ.Axes((LENGTH * share, 0, 14.0 * share**2), occ.X, occ.Y)
        wires.append(occ.WorkPlane(plane).RectangleC(width, width).Wire())
    occ.ThruSections(wires).WriteStep(str(tmp_path / "tapered.step"))
    part = read_part(tmp_path / "tapered.step", "mm", False)
    mesh = mesh_part(part, part.size_for(700))
    guess = guess_fields([mesh])
    assert guess.span > 0.85
    assert float(np.ptp(guess.cable[:, 0])) > 0.8 * 0.09
    steps = np.linalg.norm(np.diff(guess.cable, axis=0), axis=1)
    assert steps.max() < 2.5 * np.median(steps)


def test_a_body_with_pointed_ends_is_held_and_has_an_effector() -> None:
    """Of SOFA's branch no three nodes were near its round end, and the file it made was refused."""
    turns = np.linspace(0.0, 2.0 * np.pi, 7)[:-1]
    ring = 0.01 * np.stack([np.cos(turns), np.sin(turns), np.zeros(6)], axis=1)
    ends = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.1]])
    nodes = np.concatenate([ends, ring + np.array([0.0, 0.0, 0.03])])
    tets = np.array([[0, 1, 2 + i, 2 + (i + 1) % 6] for i in range(6)])
    mesh = TetMesh(nodes, tets)
    guess = guess_fields([mesh])
    held = (nodes - guess.held) @ guess.outward > 0.0
    assert np.linalg.matrix_rank(nodes[held] - nodes[held][0]) >= 2 and not held.all()
    attach(mesh, guess.effector[None], "effector", guess.outside)
    for rate in (34.0, 50.0):
        text = robot_text(Values("cone", "cone.stl", 8, 0.01, 3e5, rate), guess, "")
        assert ("a reduced one permits more" in text) == (rate < 50.0)


@pytest.mark.parametrize("angle", [5.0, 37.0, 120.0])
def test_a_part_that_stands_obliquely_is_held_as_upright_ones_are(angle: float) -> None:
    """It was held at three nodes of a corner, and sagged by 60 % of its size."""
    upright = box_mesh((0.09, 0.02, 0.016), (9, 2, 2))
    turn = Rotation.from_rotvec(np.deg2rad(angle) * np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0))
    oblique = TetMesh(turn.apply(upright.nodes) + np.array([0.12, -0.04, 0.3]), upright.tets)
    guess = guess_fields([oblique])
    held = (oblique.nodes - guess.held) @ guess.outward > 0.0
    ends = np.unique(upright.nodes[held][:, 0])
    assert held.sum() == 9 and len(ends) == 1
    assert guess.length == pytest.approx(0.09)
    assert guess.span > 0.8
    written = np.round(guess.effector, 5)  # as in the robot file
    assert in_mesh(oblique, written[None]).all()
    tip = turn.inv().apply(written - np.array([0.12, -0.04, 0.3]))
    np.testing.assert_allclose(tip, [0.09 - ends[0], 0.01, 0.008], atol=4e-5)


@pytest.mark.long
@pytest.mark.parametrize("shape", ["tube", "legs"])
def test_the_effector_is_in_a_body_whose_end_has_its_middle_outside(
    shape: str, tmp_path: Path
) -> None:
    """A gripper's part with legs, of which SOFA has one, was refused: the point lay between them."""
    solid = occ.Cylinder((0, 0, 0), occ.Z, 12, 60) - occ.Cylinder((0, 0, -1), occ.Z, 9, 62)
    if shape == "legs":
        solid = occ.Box((0, 0, 60), (60, 16, 90)) + occ.Box((0, 0, 0), (12, 16, 90))
        solid += occ.Box((46, 0, 0), (60, 16, 90))
    solid.WriteStep(str(tmp_path / "part.step"))
    part = read_part(tmp_path / "part.step", "mm", False)
    mesh = mesh_part(part, 6e-3)
    guess = guess_fields([mesh])
    attach(mesh, guess.effector[None], "effector", guess.outside)
    x, y, z = 1e3 * guess.effector
    assert z == pytest.approx(0.0, abs=1.0)
    if shape == "legs":
        assert (x, y) == (pytest.approx(53.0, abs=0.5), pytest.approx(8.0, abs=0.5))


@pytest.mark.long
def test_a_closed_cavity_becomes_a_chamber(tmp_path: Path) -> None:
    hollow = occ.Box((0, 0, 0), (20, 20, 80)) - occ.Box((9, 4, 8), (16, 16, 72))
    made = made_of(hollow, tmp_path, size=9e-3)
    robot = load_robot(made.file)
    assert robot.actuators.kinds == (ActuatorKind.CHAMBER,)
    assert made.guess.cavities[0].volume == pytest.approx(7e-3 * 12e-3 * 64e-3, rel=0.02)
    assert made.usable
    assert "--no-chambers" in made.notes[0]
    simulator = Simulator(robot, contact="none")
    simulator.settle_start()
    start = simulator.effector[0]
    assert simulator.settle([np.nan], [float(robot.limits.effort_max[0])]).converged
    moved = np.linalg.norm(simulator.effector[0] - start)
    assert 0.05 * 0.08 < moved < 0.3 * 0.08, "as far as a guess goes"
    assert guess_fields([robot.body.mesh], chambers=False).cavities == ()


@pytest.mark.long
def test_chambers_around_an_axis_are_tried_one_at_a_time(tmp_path: Path) -> None:
    """Together they only stretch the part, and its meshes were compared by what their asymmetry did."""
    box = box_mesh((0.02, 0.012, 0.08), (5, 3, 8))
    x, y, z = np.floor(box.nodes[box.tets].mean(axis=1) / (0.004, 0.004, 0.01)).T
    mesh = TetMesh(box.nodes, box.tets[~(((x == 1) | (x == 3)) & (y == 1) & (z > 0) & (z < 7))])
    guess = guess_fields([mesh])
    text = robot_text(
        Values("two", "two.stl", 8, 0.01, 3e5, 50.0), guess, chamber_tables(guess, 1e6, 1.0)
    )
    robot = load_robot(write_files(tmp_path, "two", text, mesh))
    found = inflated(robot, guess, 3e5, "two.stl")
    simulator = Simulator(robot, contact="none")
    simulator.settle_start()
    start = simulator.effector[0]
    volumes, bent = [], []
    for effort in ([found.effort, 0.0], [found.command, 0.0], [found.command, found.command]):
        assert simulator.settle([np.nan] * 2, effort).converged
        volumes.append(float(np.abs(simulator.position).max()))
        bent.append(simulator.effector[0] - start)
    assert abs(bent[0][0]) > 3.0 * abs(bent[0][2]), "one alone bends it"
    assert found.moved == pytest.approx(float(np.linalg.norm(bent[0])), rel=1e-3)
    assert abs(bent[2][0]) < 0.1 * abs(bent[2][2]), "both stretch it"
    assert found.volume == pytest.approx(max(volumes), rel=1e-3)


@pytest.mark.parametrize(("cells", "count"), [([(1, 1, 1)], 1), ([(1, 1, 1), (2, 2, 1)], 0)])
def test_cavities_that_touch_along_an_edge_are_no_chamber(
    cells: list[tuple[int, int, int]], count: int
) -> None:
    """Of one of SOFA's meshes a file was made that its chamber did not load."""
    box = box_mesh((0.04, 0.04, 0.06), (4, 4, 3))
    place = np.floor(box.nodes[box.tets].mean(axis=1) / (0.01, 0.01, 0.02)).astype(int)  # (e, 3)
    hollow = np.array([tuple(one) in cells for one in place.tolist()])
    guess = guess_fields([TetMesh(box.nodes, box.tets[~hollow])])
    assert len(guess.cavities) == count


@pytest.mark.slow
def test_meshes_are_compared_where_all_of_them_get(tmp_path: Path) -> None:
    """At the pressure that the coarsest mesh resists, the finest one bulges and has no equilibrium."""
    thin = occ.Box((0, 0, 0), (16, 16, 80)) - occ.Box((3, 5, 5), (6, 11, 75))
    made = made_of(thin, tmp_path)
    *coarser, finest = made.trials
    effort = finest.reached.effort
    assert effort < HALF * PRESSURE * 0.3e6
    assert all(trial.reached.effort == effort for trial in coarser)
    assert coarser[0].difference > 0.2 > max(trial.difference for trial in coarser[1:])
    simulator = Simulator(load_robot(made.file), contact="none")
    assert simulator.robot.limits.effort_max == pytest.approx(effort / HALF)
