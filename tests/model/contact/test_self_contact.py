"""Contact of a surface with itself: pairs are found, what material joins is left out."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.processes import ROBOT
from support.robots.bodies import box_mesh

from tauten.model import Robot, RobotFileError, Simulator, load_robot
from tauten.model.contact import neighbours_at_rest
from tauten.model.numerics import Array, Ints
from tauten.model.tetra import NodalBody

LENGTH, SLIT = 0.06, 0.001  # m

HAIRPIN = """\
name = "hairpin"
gravity = [0.0, 0.0, 0.0]
mesh = { file = "hairpin.vtu" }
material = { young_modulus = 1e6, poisson_ratio = 0.3, density = 1000.0 }
fixed = [{ lower = [0.0, 0.0, 0.0], upper = [1.0, 1.0, 0.0] }]

[[contacts]]
against = "itself"

[[cables]]
name = "closing"
pull_point = [0.055, 0.004, -0.01]
points = [[0.055, 0.004, 0.0], [0.055, 0.004, 0.0085]]
max_tension = 30.0
max_pull = 0.02
max_rate = 0.05

[[effectors]]
name = "tip"
point = [0.06, 0.004, 0.01]
"""


def hairpin() -> tuple[Array, Ints]:
    """Two leaves of 4.5 mm on each other, joined at x = 0 to 12 mm, with a slit of 1 mm between them."""
    mesh = box_mesh((LENGTH, 0.008, 0.010), (20, 2, 5))
    centre = mesh.nodes[mesh.tets].mean(axis=1)
    kept = (centre[:, 0] < 0.012) | (np.abs(centre[:, 2] - 0.005) > 0.001)
    z = np.interp(mesh.nodes[:, 2], [0.0, 0.004, 0.006, 0.01], [0.0, 0.0045, 0.0055, 0.01])
    mesh.nodes[:, 2] = z
    used, tets = np.unique(mesh.tets[kept], return_inverse=True)
    return mesh.nodes[used], tets.reshape(-1, 4)


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    folder = tmp_path_factory.mktemp("hairpin")
    nodes, tets = hairpin()
    meshio.Mesh(nodes, {"tetra": tets}).write(folder / "hairpin.vtu")
    (folder / "hairpin.toml").write_text(HAIRPIN)
    return load_robot(folder / "hairpin.toml")


def test_defaults_come_from_the_mesh(robot: Robot[NodalBody]) -> None:
    (pair,) = robot.contacts.pairs
    assert pair.name == "skin on itself"
    edges = (
        robot.body.mesh.nodes[pair.triangles][:, [1, 2, 0]] - robot.body.mesh.nodes[pair.triangles]
    )
    edge = np.linalg.norm(edges, axis=2).mean()
    assert robot.contacts.alarm_distance == pytest.approx(0.5 * edge, rel=0.05)
    area = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1).sum()
    assert robot.n_c == pytest.approx(area / edge**2, rel=0.1)


def test_the_default_range_is_that_of_the_finer_surface_and_the_distance(tmp_path: Path) -> None:
    """Half of the smaller mean edge, so that no candidate looks farther than its surface is resolved."""
    two = """\
[contact]
distance = 2e-4

[[surfaces]]
name = "end"
box = { lower = [0.04, -1.0, -1.0], upper = [1.0, 1.0, 1.0] }

[[contacts]]
candidates = "end"
against = "itself"

[[contacts]]
"""
    nodes, tets = hairpin()
    nodes[:, 0] *= nodes[:, 0] / LENGTH  # coarser towards the end
    meshio.Mesh(nodes, {"tetra": tets}).write(tmp_path / "hairpin.vtu")
    file = tmp_path / "hairpin.toml"
    file.write_text(HAIRPIN.replace("[[contacts]]\n", two), encoding="utf-8")
    robot = load_robot(file)
    lengths = []
    for pair in robot.contacts.pairs:
        corners = nodes[pair.triangles]
        lengths.append(np.linalg.norm(corners[:, [1, 2, 0]] - corners, axis=2).mean())
    assert max(lengths) > 1.1 * min(lengths)
    assert robot.contacts.alarm_distance == pytest.approx(0.5 * min(lengths) + 2e-4, rel=0.05)


def test_at_rest_only_the_slit_is_in_range(robot: Robot[NodalBody]) -> None:
    """Not the other side of a leaf, 4 mm away through material, nor what is beside a candidate."""
    found = robot.contacts.detect(robot.body.mesh.nodes)
    points = robot.contacts.positions(robot.body.mesh.nodes)[found.slots]
    # on the flat sides of the leaves a few points beside the slit see the edge of the other leaf
    beside = np.abs(points[:, 2] - 0.005) - 0.5 * SLIT  # from the slit into the leaves
    np.testing.assert_allclose(found.gap, SLIT + beside, atol=1e-9)
    assert (beside < 1e-9).mean() > 0.9
    assert points[:, 0].max() > 0.95 * LENGTH  # up to the mouth
    assert 0.012 < points[:, 0].min() < 0.025  # and not the root, where the leaves are joined
    assert len(found) > 20


def test_bent_it_neither_pushes_itself_nor_passes_through_itself(robot: Robot[NodalBody]) -> None:
    """Closing the slit: without contact the leaves overlap, with contact they do not."""
    position = np.array([0.002])
    through, beside = Simulator(robot, contact="none"), Simulator(robot, contact="full")
    assert through.settle(position=position).converged
    assert beside.settle(position=position).converged
    assert through.gaps.min() < -5e-4
    assert beside.gaps.min() > -1e-6
    assert beside.smooth_contact_forces().sum() > 0.1
    # in a bend without touching nothing pushes
    assert beside.settle(position=np.array([0.0005])).converged
    assert beside.smooth_contact_forces().max() == 0.0


def test_neighbours_are_the_same_in_every_pose(robot: Robot[NodalBody]) -> None:
    """In a mesh of cells many triangles are in the plane of a candidate."""
    nodes = robot.body.mesh.nodes
    (pair,) = robot.contacts.pairs
    alarm = robot.contacts.alarm_distance
    of_candidates = pair.nodes, pair.weights
    for along in (4.0 * alarm, 2.0 * LENGTH / 20):
        found = [
            neighbours_at_rest(
                nodes @ turn.as_matrix().T + place,
                pair.triangles,
                *of_candidates,
                along,
                4.0 * alarm,
            )
            for turn, place in (
                (Rotation.identity(), np.zeros(3)),
                (Rotation.from_rotvec([0.3, -0.5, 0.8]), np.array([0.1, -0.2, 0.3])),
                (Rotation.from_rotvec([2.0, 0.1, -0.4]), np.array([10.0, 0.0, -3.0])),
            )
        ]
        np.testing.assert_array_equal(found[1], found[0])
        np.testing.assert_array_equal(found[2], found[0])


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ('candidates = "notch"\nagainst = "itself"', "contacts.0: surface 'notch' is not defined"),
        (
            'against = "skin_of_it"',
            'contacts.0: candidates are missing; only against = "itself" or an obstacle goes without them, '
            "found 'skin_of_it', obstacles are none",
        ),
        (
            'candidates = "a"\nagainst = "b"\nneighbour_distance = 1e-3',
            'contacts.0: neighbour_distance is used with against = "itself" only',
        ),
        (
            'against = "itself"\n[[regions]]\nname = "itself"\nkind = "skin"',
            "no surface, region or obstacle may have the name 'itself'",
        ),
    ],
)
def test_bad_tables_are_a_sentence(beam_file: Path, table: str, message: str) -> None:
    file = beam_file.parent / "bad.toml"
    file.write_text(f"{ROBOT}\n[[contacts]]\n{table}\n")
    with pytest.raises(RobotFileError, match=message):
        load_robot(file)
