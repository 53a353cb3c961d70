"""Robot files: what may be said, and one clear sentence for everything else."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest
from support.robots.bodies import beam_config, box_mesh

from tauten.model.load import build_robot, load_robot
from tauten.model.schema import RobotConfig, RobotFileError

SIZE = (0.1, 0.02, 0.02)

GOOD = """
name = "beam"
[mesh]
file = "beam.vtu"
length_unit = "mm"
[material]
young_modulus = 1e6
poisson_ratio = 0.3
density = 1000.0
[[fixed]]
lower = [0.0, 0.0, 0.0]
upper = [0.0, 0.02, 0.02]
[[cables]]
name = "tendon"
points = [[0.01, 0.01, 0.002], [0.09, 0.01, 0.002]]
max_tension = 10.0
max_pull = 0.02
max_rate = 0.05
[[effectors]]
name = "tip"
point = [0.1, 0.01, 0.01]
[[surfaces]]
name = "top"
box = { lower = [0.05, 0.0, 0.019], upper = [0.1, 0.02, 0.021] }
normal = [0.0, 0.0, 1.0]
[[surfaces]]
name = "bottom"
box = { lower = [0.05, 0.0, -0.001], upper = [0.1, 0.02, 0.001] }
[[contacts]]
candidates = "top"
against = "bottom"
points = 7
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    mesh = box_mesh(SIZE, (8, 2, 2))
    meshio.write(tmp_path / "beam.vtu", meshio.Mesh(1e3 * mesh.nodes, [("tetra", mesh.tets)]))
    return tmp_path


def load(folder: Path, text: str):  # type: ignore[no-untyped-def]
    path = folder / "beam.toml"
    path.write_text(text)
    return load_robot(path)


def test_a_good_file_loads_in_si(folder: Path) -> None:
    robot = load(folder, GOOD)
    assert (robot.n_a, robot.layout.n_e, robot.n_c) == (1, 3, 7)
    assert robot.n == 3 * (len(robot.body.mesh.nodes) - 9)
    assert robot.actuator_set.paths.rest_length == pytest.approx([0.08])
    assert robot.effector(robot.rest()) == pytest.approx(np.array([[0.1, 0.01, 0.01]]))
    assert robot.body.tetrahedra.mass.sum() / 3 == pytest.approx(1000.0 * 0.1 * 0.02**2, rel=0.1)
    assert robot.actuators.names == ("tendon",)


def test_a_file_of_an_editor_on_windows_loads(folder: Path) -> None:
    """With a byte order mark and its ends of lines; another encoding is named."""
    path = folder / "beam.toml"
    path.write_text(GOOD.replace("\n", "\r\n"), encoding="utf-8-sig")
    assert load_robot(path).name == "beam"
    path.write_text(GOOD, encoding="utf-16")
    with pytest.raises(RobotFileError, match=r"beam.toml: cannot be read .*; save it as UTF-8"):
        load_robot(path)


CHANGES = {
    r"beam.toml: not TOML": ("name =", "name"),
    r"beam.toml: material.poisson_ratio: .*less than 0.5, found 0.5": ("0.3", "0.5"),
    r"beam.toml: material.young_modulus: allowed is .* at most 1e\+12 Pa, found 1.0": ("1e6", "1.0"),
    r"beam.toml: material: needs to be a table, \[material\] with single": ("[material]", "[[material]]"),
    r"beam.toml: cables: needs to be a list of tables, \[\[cables\]\]": ("[[cables]]", "[cables]"),
    r"beam.toml: gravity: needs to be a list, found 9.81$": ("[mesh]", "gravity = 9.81\n[mesh]"),
    r"beam.toml: name: allowed are a letter, then letters, digits and _, found 'my robot'": (
        'name = "beam"',
        'name = "my robot"',
    ),
    r"beam.toml: effectors.0.weight: .*greater than or equal to 0, found -1$": (
        "[0.1, 0.01, 0.01]",
        "[0.1, 0.01, 0.01]\nweight = -1",
    ),
    r"beam.toml: effectors.0.weight.1: .*greater than or equal to 0, found -1$": (
        "[0.1, 0.01, 0.01]",
        "[0.1, 0.01, 0.01]\nweight = [0, -1, 0]",
    ),
    r"beam.toml: effectors.0.point: List should have at most 3 items, not 4, found": (
        "[0.1, 0.01, 0.01]",
        "[0.1, 0.01, 0.01, 1]",
    ),
    r"beam.toml: servic: unknown field, allowed are .*, model, service$": (
        GOOD,
        GOOD + "[servic]\nrate = 1",
    ),
    r"beam.toml: material.density: .*, found nan": ("1000.0", "nan"),
    r"beam.toml: mesh.length_unit: .*'m', 'cm' or 'mm', found 'inch'": ('"mm"', '"inch"'),
    r"beam.toml: surprise: unknown field, allowed are name, frame, ": ("[mesh]", "surprise = 1\n[mesh]"),
    r"beam.toml: cables.0.max_tension: .*greater than 0, found -1.0": ("10.0", "-1.0"),
    r"beam.toml: cables.0: a cable needs a pull_point or a second point": (
        ", [0.09, 0.01, 0.002]",
        "",
    ),
    r"beam.toml: cables.0.points: points 0 and 1 coincide": ("0.09, 0.01, 0.002", "0.01, 0.01, 0.002"),
    r"beam.toml: cables.0.points: point 1 at \[0.09, 0.01, 0.2\] m lies 0.18 m": (
        "0.09, 0.01, 0.002",
        "0.09, 0.01, 0.2",
    ),
    r"beam.toml: effectors.0.point: point 0 .* outside the mesh, .* set max_outside": (
        "[0.1, 0.01, 0.01]",
        "[1, 0, 0]",
    ),
    r"beam.toml: fixed.1: no node in .* the mesh spans": (
        "upper = [0.0, 0.02, 0.02]",
        "upper = [0.0, 0.0, -0.0]\n[[fixed]]\nlower=[5,5,5]\nupper=[6,6,6]",
    ),
    r"beam.toml: fixed: needs three nodes not on a line": ("[0.0, 0.02, 0.02]", "[0.0, 0.02, 0.0]"),
    r"beam.toml: fixed: holds every node": ("upper = [0.0, 0.02, 0.02]", "upper = [1, 1, 1]"),
    r"beam.toml: fixed.0: lower .* must not exceed upper": ("upper = [0.0, 0", "upper = [-1.0, 0"),
    r"beam.toml: surfaces.top: no boundary triangle has its centre in": (
        "0.05, 0.0, 0.019",
        "0.05, 0.0, 0.0209",
    ),
    r"beam.toml: contacts.0: surface 'side' is not defined, known are bottom, top": (
        '"bottom"\npoints',
        '"side"\npoints',
    ),
    r"beam.toml: contacts.1: it is 'top on bottom' as contacts.0 is; write one table for both": (
        "points = 7",
        'points = 7\n[[contacts]]\ncandidates = "top"\nagainst = "bottom"',
    ),
    r"beam.toml: surfaces: name 'top' is used twice": ('name = "bottom"', 'name = "top"'),
    r"controller.rate: allowed is at least 0.01 and at most 10000 Hz, found 1e-300": (
        GOOD,
        GOOD + "[controller]\nrate = 1e-300",
    ),
    r"cables.0.max_rate: allowed is more than 0 and at most 1000 m/s, found 1e\+300": (
        "max_rate = 0.05",
        "max_rate = 1e300",
    ),
    r"gravity.2: allowed is at least -1000 and at most 1000 m/s²": (
        "[mesh]",
        "gravity = [0.0, 0.0, 1e300]\n[mesh]",
    ),
    r"surfaces.0.normal: a direction needs a component of at least 1e-06": (
        "normal = [0.0, 0.0, 1.0]",
        "normal = [0.0, 0.0, 0.0]",
    ),
    r"beam.vtu: the body is 100 m long, .* check mesh.length_unit; in a unit": ('length_unit = "mm"', ""),
    r"beam.toml: mesh.file: no such file .*missing.vtu": ("beam.vtu", "missing.vtu"),
}  # fmt: skip


@pytest.mark.parametrize("message", CHANGES)
def test_bad_files_name_file_field_found_and_allowed(folder: Path, message: str) -> None:
    old, new = CHANGES[message]
    assert old in GOOD
    with pytest.raises(ValueError, match=message) as caught:
        load(folder, GOOD.replace(old, new, 1))
    assert "\n" not in str(caught.value)


def test_tables_of_other_layers_are_theirs(folder: Path) -> None:
    """The model reads the rate; a table that no layer reads is an error."""
    others = "[controller]\nrate = 80.0\nqp_solver = 3\n[service]\nrelease_time = 1e300\n[model]\nx = 1\n"
    robot = load(folder, GOOD + others)
    assert (robot.integration.rate, robot.h) == (80.0, 1 / 80.0)
    with pytest.raises(RobotFileError, match=r"beam.toml: sevrice: unknown field, allowed are "):
        load(folder, GOOD + others.replace("service", "sevrice"))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"rate": -50.0}, "load_robot: rate: Input should be greater than 0, found -50.0"),
        ({"rate": np.nan}, "load_robot: rate: Input should be a finite number, found nan"),
        ({"refinements": -1}, "load_robot: refinements: .* greater than or equal to 0, found -1"),
        ({"refinements": 40}, "load_robot: refinements: .* less than or equal to 4, found 40"),
        ({"young_scale": np.nan}, "load_robot: young_scale: .* finite number, found nan"),
        ({"young_scale": -1.0}, "load_robot: young_scale: allowed is at least 1e-06 and at most"),
        (
            {"young_scale": 1e-5},
            "scaled by 1e-05: material.young_modulus: allowed is at least 100 .*, found 10.0",
        ),
        ({"factorisation": "magic"}, "load_robot: factorisation: .*, found 'magic'"),
    ],
)
def test_arguments_are_validated_as_the_file_is(
    folder: Path, changes: dict[str, object], message: str
) -> None:
    (folder / "beam.toml").write_text(GOOD)
    with pytest.raises(RobotFileError, match=f"beam.toml: {message}"):
        load_robot(folder / "beam.toml", **changes)  # type: ignore[arg-type]


def test_a_folder_is_refused_with_its_robot_file(tmp_path: Path) -> None:
    (tmp_path / "part").mkdir()
    (tmp_path / "part" / "part.toml").write_text("")  # as `tauten new part` does
    with pytest.raises(
        RobotFileError, match=r"part: is a folder; its robot file is .*/part\.toml$"
    ):
        load_robot(tmp_path / "part")


def test_unknown_robots_are_refused_with_the_shipped_ones() -> None:
    with pytest.raises(RobotFileError, match=r"no robot 'hand': .* one of .*finger"):
        load_robot("hand")
    for name in ("../robots/finger", "a" * 5000, "\0"):
        with pytest.raises(RobotFileError, match=r"no robot .{1,50}: give a path"):
            load_robot(name)
    with pytest.raises(
        RobotFileError, match=r"nowhere.toml: cannot be read \(No such file or directory\)"
    ):
        load_robot("nowhere.toml")


def test_a_part_without_a_file_is_refused_in_the_file_that_names_it(tmp_path: Path) -> None:
    file = tmp_path / "pair.toml"
    file.write_text('name = "pair"\n[[parts]]\nname = "left"\nrobot = "arm.toml"\n', "utf-8")
    with pytest.raises(RobotFileError, match=r"pair.toml: parts: robot: no such file 'arm.toml'$"):
        load_robot(file)


def test_digest_follows_contact_physics_and_nothing_else() -> None:
    mesh = box_mesh(SIZE, (4, 2, 2))

    def digest(**changes: object) -> str:
        return build_robot(
            RobotConfig.model_validate(beam_config(SIZE, **changes)), mesh, "b"
        ).digest

    stiffer = {"young_modulus": 2e6, "poisson_ratio": 0.3, "density": 1000.0}
    assert digest() == digest(gravity=[0.0, 0.0, -1.0], controller={"rate": 200.0})
    assert digest() != digest(material=stiffer)


def test_our_finger_is_the_papers(shipped_finger) -> None:  # type: ignore[no-untyped-def]
    finger = shipped_finger
    assert finger.n_c == 495 and finger.n_a == 1
    assert 800 <= len(finger.body.mesh.nodes) <= 3500
    assert np.ptp(finger.body.mesh.nodes, axis=0) == pytest.approx([0.015, 0.015, 0.1])


def test_our_finger_is_made_by_its_script(tmp_path: Path, shipped_finger) -> None:  # type: ignore[no-untyped-def]
    from benchmarks.robots.make_finger import FingerShape, make_finger

    nodes, tets = make_finger(FingerShape())
    mesh = shipped_finger.body.mesh
    assert np.allclose(mesh.nodes, nodes) and np.array_equal(mesh.tets, tets)


def test_the_file_of_a_part_is_no_robot_by_itself() -> None:
    """`tauten check examples/claw.toml` said "effectors: Field required", and no more."""
    file = Path(__file__).parents[3] / "examples" / "claw.toml"
    with pytest.raises(RobotFileError, match=r"a robot needs an effector: .* in parts") as refused:
        load_robot(file)
    assert str(refused.value).startswith(str(file))
