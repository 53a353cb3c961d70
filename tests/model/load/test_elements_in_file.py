"""Elements and materials in robot files: what old files mean, what new ones make, what is refused."""

from __future__ import annotations

import copy
import pickle
from dataclasses import replace
from pathlib import Path

import meshio
import numpy as np
import pytest
from support.robots.bodies import beam_config, box_mesh

from tauten.model import Robot, Simulator, State
from tauten.model.load import build_robot, load_robot
from tauten.model.materials import find_silicone, yeoh
from tauten.model.mesh import MeshError, QuadraticMesh, quadratic_mesh, read_quadratic_mesh
from tauten.model.numerics import Array, Ints
from tauten.model.schema import RobotConfig, RobotFileError
from tauten.model.tetra import NodalBody

SIZE = (0.1, 0.02, 0.02)
MESH = box_mesh(SIZE, (10, 2, 2))
RUBBER = {"young_modulus": 1e6, "poisson_ratio": 0.45, "density": 1000.0}


def settings_of(
    element: str = "linear", material: object = None, **changes: object
) -> dict[str, object]:
    settings = beam_config(SIZE, **{"material": material or RUBBER, **changes})
    settings["mesh"] = {"file": "beam.vtu", "element": element}
    return settings


def beam(element: str = "linear", material: object = None, **changes: object) -> Robot[NodalBody]:
    settings = settings_of(element, material, **changes)
    return build_robot(RobotConfig.model_validate(settings), MESH, "beam.toml")


def test_the_default_is_linear_corotational() -> None:
    robot = beam()
    assert robot.body.tetrahedra.elements.is_plain
    assert robot.digest == beam(material={**RUBBER, "law": "corotational"}).digest
    assert robot.body.n_elements == len(MESH.tets)


@pytest.mark.parametrize("element", ["linear", "quadratic", "smoothed"])
@pytest.mark.parametrize("law", ["corotational", "stable-neo-hookean", "neo-hookean"])
def test_forces_are_the_derivative_of_the_potential(element: str, law: str) -> None:
    robot = beam(element, {**RUBBER, "law": law}, gravity=[0.0, 0.0, -9.81])
    rest, rng = robot.rest(), np.random.default_rng(0)
    q = rest.q + 5e-4 * rng.standard_normal(robot.n)
    d, step = rng.standard_normal(robot.n), 1e-7
    slope = (
        robot.potential(State(q + step * d, rest.v)) - robot.potential(State(q - step * d, rest.v))
    ) / (2.0 * step)
    force, _ = robot.forces(State(q, rest.v))
    assert -force @ d == pytest.approx(slope, rel=1e-6)
    assert robot.potential(rest) == pytest.approx(0.0, abs=1e-15)


def bending_tension(robot: Robot[NodalBody]) -> float:
    simulator = Simulator(robot, contact="none")
    report = simulator.settle(position=[0.004])
    assert report.converged
    return float(simulator.effort[0])


def test_elements_that_do_not_lock_are_softer_and_agree() -> None:
    effort = {
        element: bending_tension(beam(element)) for element in ("linear", "quadratic", "smoothed")
    }
    assert effort["smoothed"] == pytest.approx(effort["quadratic"], rel=0.15)
    assert effort["linear"] > 1.5 * effort["quadratic"]


def test_robots_of_other_elements_step_fork_and_pickle() -> None:
    robot = beam("smoothed", {"silicone": "dragon-skin-30"})
    again = pickle.loads(pickle.dumps(robot.fork()))
    for one in (robot, again):
        simulator = Simulator(one)
        for _ in range(5):
            simulator.step(position=[0.001])
        assert np.isfinite(simulator.state.q).all()
    assert again.digest == robot.digest != beam("smoothed").digest != beam().digest


def test_a_settled_simulator_goes_into_another_process() -> None:
    """`multiprocessing` with spawned processes pickles what it hands over."""
    simulator = Simulator(beam())
    simulator.settle(position=[0.001])
    copies = pickle.loads(pickle.dumps(simulator)), copy.deepcopy(simulator)
    for one in (simulator, *copies):
        assert one.settle(position=[0.002]).converged
        assert one.tip == pytest.approx(simulator.tip, abs=1e-9)


def test_silicone_gives_what_is_not_said() -> None:
    silicone = {"silicone": "ecoflex-00-30"}
    assert not beam(material=silicone).body.tetrahedra.elements.is_plain
    config = RobotConfig.model_validate(settings_of(material=silicone))
    assert config.material is not None
    assert config.material.poisson_ratio == 0.49
    assert config.material.density == 1070.0
    assert config.material.young_modulus == pytest.approx(4.0 * 7504.0 * 1.49)
    other = {**silicone, "poisson_ratio": 0.45, "density": 1050.0}
    changed = RobotConfig.model_validate(settings_of(material=other)).material
    assert changed is not None
    assert changed.density == 1050.0
    assert RobotConfig.model_validate(config.model_dump()) == config


def test_young_modulus_scales_a_law() -> None:
    soft = beam("quadratic", {"silicone": "dragon-skin-10"})
    item = find_silicone("dragon-skin-10")
    twice = 2.0 * yeoh(item.c10, item.c20, 0.0, item.poisson_ratio).young_modulus
    stiff = beam("quadratic", {"silicone": "dragon-skin-10", "young_modulus": twice})
    state = soft.rest()
    bent = replace(state, q=state.q + 1e-3 * np.random.default_rng(1).standard_normal(soft.n))
    assert stiff.potential(bent) == pytest.approx(2.0 * soft.potential(bent))


def test_young_scale_scales_every_region(tmp_path: Path) -> None:
    write(tmp_path / "beam.vtu", MESH.nodes, ("tetra", MESH.tets))
    path = tmp_path / "beam.toml"
    region = REGION.replace("[1.0, 1.0, 1.0]", "[0.05, 0.0, 0.0]") + 'silicone = "dragon-skin-30"\n'
    material = 'silicone = "ecoflex-00-50"'
    path.write_text(FILE.format(mesh="", material=material, more=region), encoding="utf-8")
    soft, stiff = load_robot(path), load_robot(path, young_scale=3.0)
    assert isinstance(soft.body, NodalBody)
    assert isinstance(stiff.body, NodalBody)
    state = soft.rest()
    bent = replace(state, q=state.q + 1e-4 * np.random.default_rng(2).standard_normal(soft.n))
    energy, tripled = (robot.potential(bent) for robot in (soft, stiff))
    work = soft.body.tetrahedra.load @ (bent.q - state.q)
    assert tripled + work == pytest.approx(3.0 * (energy + work))


@pytest.mark.parametrize("element", ["linear", "quadratic", "smoothed"])
def test_a_stiff_region(element: str) -> None:
    """A bar of two halves, one ten times as stiff, stretches like two springs in series."""
    region = {"lower": [0.05, 0.0, 0.0], "upper": [0.1, 0.02, 0.02]}
    base = {"young_modulus": 1e5, "poisson_ratio": 0.0, "density": 1000.0}
    stiff = {**base, "young_modulus": 1e6, "density": 2000.0, "region": region}
    robot = beam(element, base, materials=[stiff])
    middle, end, share = 0.05, 0.1, 1e-3
    x = robot.body.mesh.nodes
    stretch = np.where(
        x[:, 0] < middle, share * x[:, 0], share * middle + 0.1 * share * (x[:, 0] - middle)
    )
    moved = x + np.stack([stretch, 0.0 * stretch, 0.0 * stretch], axis=1)
    state = State(moved[robot.body.pattern.dof >= 0].ravel(), robot.rest().v)
    force = robot.forces(state)[0].reshape(-1, 3)
    free = x[robot.body.pattern.dof >= 0]
    at_end = free[:, 0] > end - 1e-9
    assert force[at_end, 0].sum() == pytest.approx(-1e5 * share * 0.02**2, rel=1e-3)
    assert np.abs(force[~at_end]).max() < 1e-3 * np.abs(force[at_end]).max()
    mass = robot.body.tetrahedra.mass.reshape(-1, 3)[:, 0]
    halves = [(free[:, 0] > low) & (free[:, 0] < low + 0.039) for low in (0.0055, 0.0555)]
    assert mass[halves[1]].sum() == pytest.approx(2.0 * mass[halves[0]].sum())


# --- files of quadratic tetrahedra -----------------------------------------------------------------


def write(path: Path, nodes: Array, *cells: tuple[str, Ints]) -> Path:
    gmsh = "gmsh" if path.suffix == ".msh" else None
    meshio.write(path, meshio.Mesh(nodes, list(cells)), file_format=gmsh)
    return path


def test_quadratic_files_are_read(tmp_path: Path) -> None:
    mesh = quadratic_mesh(MESH)
    for name in ("beam.vtu", "beam.msh", "beam.inp"):
        read = read_quadratic_mesh(write(tmp_path / name, mesh.nodes, ("tetra10", mesh.tets)))
        assert isinstance(read, QuadraticMesh)
        assert np.allclose(read.nodes, mesh.nodes)
        assert np.array_equal(read.tets, mesh.tets)
    linear = read_quadratic_mesh(write(tmp_path / "linear.vtu", MESH.nodes, ("tetra", MESH.tets)))
    assert np.array_equal(linear.tets, mesh.tets)


def test_quadratic_files_of_the_other_orientation(tmp_path: Path) -> None:
    mesh = quadratic_mesh(MESH)
    turned = mesh.tets[:, [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]]
    read = read_quadratic_mesh(write(tmp_path / "m.vtu", mesh.nodes, ("tetra10", turned)))
    assert np.array_equal(read.tets, mesh.tets)


def test_half_of_a_quadratic_mesh(tmp_path: Path) -> None:
    mesh = quadratic_mesh(MESH)
    mixed = write(
        tmp_path / "mixed.vtu", mesh.nodes, ("tetra", MESH.tets[:40]), ("tetra10", mesh.tets[40:])
    )
    with pytest.raises(MeshError, match="40 linear beside 200 quadratic tetrahedra; write all"):
        read_quadratic_mesh(mixed)
    tets = mesh.tets.copy()
    nodes = np.concatenate([mesh.nodes, mesh.nodes[tets[0, 4:5]]])
    tets[0, 4] = len(nodes) - 1
    with pytest.raises(MeshError, match="1 edges have two mid-edge nodes, the first joins nodes"):
        read_quadratic_mesh(write(tmp_path / "double.vtu", nodes, ("tetra10", tets)))


FILE = """
name = "beam"
[mesh]
file = "beam.vtu"
{mesh}
[material]
{material}
[[fixed]]
lower = [0.0, 0.0, 0.0]
upper = [0.0, 0.02, 0.02]
[[cables]]
name = "tendon"
points = [[0.01, 0.01, 0.002], [0.1, 0.01, 0.002]]
max_tension = 10.0
max_pull = 0.01
max_rate = 0.1
[[effectors]]
name = "tip"
point = [0.1, 0.01, 0.01]
{more}
"""
GOOD = "young_modulus = 1e6\npoisson_ratio = 0.45\ndensity = 1000.0\n"
REGION = (
    "[[materials]]\n" + GOOD + "region = { lower = [1.0, 1.0, 1.0], upper = [2.0, 2.0, 2.0] }\n"
)
BAD = {
    r"material\.poisson_ratio: .* less than 0\.5, found 0\.5": ("", GOOD.replace("0.45", "0.5"), ""),
    r"mesh\.element: Input should be 'linear', 'quadratic' or 'smoothed', found 'cubic'": (
        'element = "cubic"', GOOD, "",
    ),
    r"material\.law: Input should be .*, found 'ogden'": ("", GOOD + 'law = "ogden"', ""),
    r"material: silicone is 'ecoflex', known are ecoflex-00-30, ecoflex-00-50": (
        "", 'silicone = "ecoflex"', "",
    ),
    r"material: law is 'neo-hookean', silicones have the law 'yeoh'": (
        "", 'silicone = "ecoflex-00-30"\nlaw = "neo-hookean"', "",
    ),
    r"material: the law 'yeoh' needs c10": ("", GOOD + 'law = "yeoh"', ""),
    r"material: c01 is no constant of the law 'yeoh', which takes c10, c20, c30": (
        "", GOOD + 'law = "yeoh"\nc10 = 1e5\nc01 = 1e4', "",
    ),
    r"material: c10 is no constant of the law 'corotational', which takes young_modulus and": (
        "", GOOD + "c10 = 1e5", "",
    ),
    r"material: c10 100000, c20 -100000, c30 0 Pa: .* softens without limit": (
        "", GOOD + 'law = "yeoh"\nc10 = 1e5\nc20 = -1e5', "",
    ),
    r"materials\.0\.region: no tetrahedron has its centre in \(1\.0, 1\.0, 1\.0\) to": ("", GOOD, REGION),
}  # fmt: skip


@pytest.mark.parametrize("message", BAD)
def test_bad_files_are_one_sentence(tmp_path: Path, message: str) -> None:
    mesh, material, more = BAD[message]
    write(tmp_path / "beam.vtu", MESH.nodes, ("tetra", MESH.tets))
    path = tmp_path / "beam.toml"
    path.write_text(FILE.format(mesh=mesh, material=material, more=more), encoding="utf-8")
    with pytest.raises(RobotFileError, match=message) as caught:
        load_robot(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_quadratic_file_for_linear_elements(tmp_path: Path) -> None:
    mesh = quadratic_mesh(MESH)
    write(tmp_path / "beam.vtu", mesh.nodes, ("tetra10", mesh.tets))
    path = tmp_path / "beam.toml"
    for element in ("linear", "smoothed"):
        text = FILE.format(mesh=f'element = "{element}"', material=GOOD, more="")
        path.write_text(text, encoding="utf-8")
        with pytest.raises(
            MeshError, match=r'holds quadratic tetrahedra; set mesh\.element = "quadratic"'
        ):
            load_robot(path)
    path.write_text(
        FILE.format(mesh='element = "quadratic"', material=GOOD, more=""), encoding="utf-8"
    )
    assert load_robot(path).body.n_elements == len(MESH.tets)
    assert load_robot(path, refinements=1).body.n_elements == 8 * len(MESH.tets)


def test_smoothed_elements_where_every_domain_of_a_size_is_held() -> None:
    """A held block of 27 cells has nodes inside, around which domains are larger than any of the beam's."""
    settings = settings_of("smoothed")
    beam_mesh = {"name": "beam", "mesh": settings.pop("mesh"), "fixed": settings.pop("fixed")}
    block = {
        "name": "block", "mesh": {"file": "block.vtu", "element": "smoothed"},
        "fixed": [{"kind": "all"}], "position": [0.2, 0.0, 0.0],
    }  # fmt: skip
    config = RobotConfig.model_validate({**settings, "bodies": [beam_mesh, block]})
    meshes = [box_mesh(SIZE, (4, 1, 1)), box_mesh((0.02, 0.02, 0.02), (3, 3, 3))]
    alone = settings_of("smoothed")
    robot = build_robot(config, meshes, "beam.toml")
    beside = build_robot(RobotConfig.model_validate(alone), meshes[0], "beam.toml")
    assert max(slot.shape[1] for slot in robot.body.tetrahedra.elements.slots) > max(
        slot.shape[1] for slot in beside.body.tetrahedra.elements.slots
    )
    assert bending_tension(robot) == pytest.approx(bending_tension(beside), rel=1e-9)


@pytest.mark.parametrize("element", ["linear", "quadratic", "smoothed"])
def test_a_region_of_the_same_material_changes_no_force(element: str) -> None:
    """Also where its density is another one, as of a silicone with a filler."""
    half = {"lower": [0.0, 0.0, 0.0], "upper": [0.05, 0.02, 0.02]}
    one = beam(element)
    other = beam(element, materials=[{**RUBBER, "region": half, "density": 1500.0}])
    rest = one.rest()
    moved = State(rest.q + 5e-4 * np.random.default_rng(0).standard_normal(one.n), np.zeros(one.n))
    for found, expected in zip(other.forces(moved), one.forces(moved), strict=True):
        np.testing.assert_array_equal(found, expected)
    assert other.body.moving_mass > 1.2 * one.body.moving_mass
