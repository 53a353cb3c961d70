"""Regions: what each kind selects on a box whose answer is known, and one sentence where there is none."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import meshio
import numpy as np
import pytest
from pydantic import TypeAdapter
from support.robots.bodies import beam_config, box_mesh

from tauten.model.load import build_robot
from tauten.model.mesh import (
    QuadraticMesh,
    Selector,
    TetMesh,
    checked,
    make_selector,
    read_mesh,
    read_quadratic_mesh,
)
from tauten.model.numerics import Bools
from tauten.model.schema import (
    AnyRegion,
    Region,
    RobotConfig,
    RobotFileError,
    differences,
    validated,
)

SIZE, CELLS = (0.1, 0.02, 0.02), (10, 2, 2)
MESH = box_mesh(SIZE, CELLS)
END = {"kind": "half_space", "point": [0.0951, 0.0, 0.0], "normal": [1.0, 0.0, 0.0]}


def region(**table: object) -> Region:
    return TypeAdapter(AnyRegion).validate_python(table)


def selector(mesh: TetMesh = MESH, folder: Path | None = None, **named: Region) -> Selector:
    return make_selector(mesh, named, str((folder or Path()) / "robot.toml"))


def test_shapes_select_nodes_by_position() -> None:
    x, chosen = MESH.nodes, selector().select_nodes
    assert np.array_equal(chosen(region(**END), "f"), x[:, 0] > 0.0951)
    ball = region(kind="sphere", centre=[0.05, 0.01, 0.01], radius=0.0101)
    assert np.array_equal(
        chosen(ball, "f"), np.linalg.norm(x - [0.05, 0.01, 0.01], axis=1) < 0.0101
    )
    rod = region(kind="cylinder", start=[0.0, 0.01, 0.01], end=[0.05, 0.01, 0.01], radius=0.001)
    assert chosen(rod, "f").sum() == 6
    assert chosen(region(kind="all"), "f").all()
    assert chosen(region(lower=[0.0, 0.0, 0.0], upper=[0.0, 1.0, 1.0]), "f").sum() == 9


def test_skin_and_normal_select_triangles_and_what_is_behind_them() -> None:
    chosen = selector()
    inner = ((MESH.nodes[:, 1:] > 0.001) & (MESH.nodes[:, 1:] < 0.019)).all(axis=1)
    inner &= (MESH.nodes[:, 0] > 0.001) & (MESH.nodes[:, 0] < 0.099)
    assert np.array_equal(chosen.select_nodes(region(kind="skin"), "f"), ~inner)
    top = region(kind="normal", direction=[0.0, 0.0, 2.0], max_angle_deg=10.0)
    triangles = chosen.boundary[chosen.select_triangles(top, "f")]
    assert len(triangles) == 2 * 10 * 2
    assert (MESH.nodes[triangles][:, :, 2] == SIZE[2]).all()
    assert np.array_equal(chosen.select_nodes(top, "f"), np.isclose(MESH.nodes[:, 2], SIZE[2]))
    behind = chosen.select_tets(top, "f")
    assert behind.sum() == len(triangles)
    assert (MESH.nodes[MESH.tets[behind]].max(axis=1)[:, 2] == SIZE[2]).all()


def test_set_operations_on_names_and_tables() -> None:
    chosen = selector(end=region(**END), skin=region(kind="skin"))
    both = chosen.select_nodes(region(kind="intersection", of=["end", "skin"]), "f")
    either = chosen.select_nodes(region(kind="union", of=["end", "skin"]), "f")
    rest = chosen.select_nodes(region(kind="difference", of=["skin", END]), "f")
    end, skin = (chosen.select_nodes(name, "f") for name in ("end", "skin"))
    assert np.array_equal(both, end & skin)
    assert np.array_equal(either, end | skin)
    assert np.array_equal(rest, skin & ~end)


def test_near_stl_selects_the_wall_it_covers(tmp_path: Path) -> None:
    corners = np.array(
        [[0.0, 0.0, 20.0], [100.0, 0.0, 20.0], [100.0, 20.0, 20.0], [0.0, 20.0, 20.0]]
    )
    meshio.write(tmp_path / "top.stl", meshio.Mesh(corners, [("triangle", [[0, 1, 2], [0, 2, 3]])]))
    near = region(kind="near_stl", file="top.stl", length_unit="mm")
    top = region(kind="normal", direction=[0.0, 0.0, 1.0])
    chosen = selector(folder=tmp_path)
    assert np.array_equal(chosen.select_triangles(near, "f"), chosen.select_triangles(top, "f"))
    lost = region(kind="near_stl", file="none.stl")
    with pytest.raises(RobotFileError, match=r"robot.toml: f: .*none.stl: no such mesh file"):
        chosen.select_triangles(lost, "f")


def grouped(path: Path, tets: np.ndarray = MESH.tets) -> Path:
    """The box with its front half as the group "stiff" and its end as the group "tip"."""
    stiff = MESH.nodes[tets[:, :4]].mean(axis=1)[:, 0] < 0.05
    whole = selector()
    end = whole.boundary[whole.select_triangles(region(kind="normal", direction=[1, 0, 0]), "f")]
    tags = [np.where(stiff, 7, 8), np.full(len(end), 3)]
    meshio.write(
        path,
        meshio.Mesh(
            MESH.nodes, [("tetra", tets), ("triangle", end)],
            cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
            field_data={"stiff": np.array([7, 3]), "tip": np.array([3, 2])},
        ),
        **({"file_format": "gmsh22", "binary": False} if path.suffix == ".msh" else {}),
    )  # fmt: skip
    return path


@pytest.mark.long
@pytest.mark.parametrize("refinements", [0, 1, 2])
@pytest.mark.parametrize("read", [read_mesh, read_quadratic_mesh])
def test_physical_groups_survive_refinement(tmp_path: Path, refinements: int, read: object) -> None:
    mesh = read(grouped(tmp_path / "beam.msh"))  # type: ignore[operator]
    for _ in range(refinements):
        mesh = mesh.refine()
    mesh = mesh if isinstance(mesh, TetMesh) else mesh.split()
    chosen = selector(mesh)
    tets = chosen.select_tets(region(kind="group", group="stiff"), "f")
    assert np.array_equal(tets, mesh.nodes[mesh.tets].mean(axis=1)[:, 0] < 0.05)
    tip = chosen.select_triangles(region(kind="group", group="tip"), "f")
    assert np.array_equal(tip, (mesh.nodes[chosen.boundary][:, :, 0] == SIZE[0]).all(axis=1))
    nodes = chosen.select_nodes(region(kind="group", group="tip"), "f")
    assert np.array_equal(nodes, mesh.nodes[:, 0] == SIZE[0])
    behind = chosen.select_tets(region(kind="group", group="tip"), "f")
    assert behind.sum() == tip.sum()


def test_values_of_cell_arrays_are_groups(tmp_path: Path) -> None:
    chosen = selector(read_mesh(grouped(tmp_path / "beam.vtu")))
    stiff = chosen.select_tets(region(kind="group", group="gmsh:physical:7"), "f")
    assert stiff.sum() == len(MESH.tets) // 2


@pytest.mark.parametrize(
    ("table", "sentence"),
    [
        (
            {"kind": "sphere", "centre": [1.0, 0.0, 0.0], "radius": 0.1},
            r"robot.toml: f: no node in the sphere of radius 0.1 m around \(1.0, 0.0, 0.0\), the mesh spans "
            r"\[0.0, 0.0, 0.0\] to \[0.1, 0.02, 0.02\] m",
        ),
        ({"kind": "group", "group": "x"}, "has no group 'x', its groups are none"),
        ({"kind": "difference", "of": ["end", "end"]}, "no node in this difference"),
    ],
)  # fmt: skip
def test_empty_selections_are_one_sentence(table: dict[str, object], sentence: str) -> None:
    with pytest.raises(RobotFileError, match=sentence):
        selector(end=region(**END)).select_nodes(region(**table), "f")


def test_the_span_of_the_mesh_is_that_of_nodes_that_may_be_selected() -> None:
    """Rings beside a beam follow it and are not selected."""
    chosen = selector()
    followers = chosen.nodes[:, 0] > 0.05
    chosen = replace(chosen, followers=followers)
    highest = chosen.nodes[~followers, 0].max()
    with pytest.raises(RobotFileError, match=rf"the mesh spans .* to \[{highest:g}, "):
        chosen.select_nodes(region(kind="sphere", centre=[1.0, 0.0, 0.0], radius=0.1), "f")


def robot_file(**changes: object) -> RobotConfig:
    return validated(RobotConfig, beam_config(SIZE, **changes), "beam.toml")


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"fixed": ["root"]}, "fixed.0: region 'root' is not defined, known are none"),
        ({"regions": [END]}, "regions.0: it needs a name"),
        ({"regions": [{"name": "a", **END}, {"name": "a", **END}]}, "name 'a' is used twice"),
        ({"regions": [{"name": "a", "kind": "sfere"}]}, "regions.0: a region has a kind of box, "),
        ({"regions": [{"name": "a", "kind": "sphere", "radius": 1.0}]}, "regions.0.centre: Field req"),
        (
            {
                "regions": [
                    {"name": "a", "kind": "union", "of": ["b"]},
                    {"name": "b", "kind": "union", "of": ["a", END]},
                ]
            },
            "regions.a: it is made of itself",
        ),
        (
            {
                "regions": [{"name": "top", **END}],
                "surfaces": [{"name": "top", "box": {"lower": [0, 0, 0], "upper": [1, 1, 1]}}],
            },
            "surfaces and regions: name 'top' is used twice",
        ),
    ],
)  # fmt: skip
def test_bad_tables_are_one_sentence(changes: dict[str, object], sentence: str) -> None:
    with pytest.raises(RobotFileError, match=sentence):
        robot_file(**changes)


def test_names_serve_wherever_something_is_selected() -> None:
    """The robot of a file with names is the one of the file with boxes."""
    root = {"lower": [0.0, 0.0, 0.0], "upper": [0.0, 0.02, 0.02]}
    stiff = {"lower": [0.0, 0.0, 0.0], "upper": [0.05, 0.02, 0.02]}
    top = {"box": {"lower": [0.0, 0.0, 0.0], "upper": [0.1, 0.02, 0.02]}, "normal": [0.0, 0.0, 1.0]}
    law = {"young_modulus": 2e6, "poisson_ratio": 0.3, "density": 900.0}
    contacts = [{"candidates": "top", "against": "top", "points": 4}]
    old = robot_file(
        fixed=[root], materials=[{**law, "region": stiff}],
        surfaces=[{"name": "top", **top}], contacts=contacts,
    )  # fmt: skip
    new = robot_file(
        fixed=["root"],
        materials=[{**law, "region": "stiff"}],
        contacts=contacts,
        regions=[
            {"name": "root", **root},
            {"name": "stiff", **stiff},
            {"name": "top", "kind": "normal", "direction": [0.0, 0.0, 1.0]},
        ],
    )
    first, second = (build_robot(config, MESH, "beam.toml") for config in (old, new))
    assert (
        differences(first.digest, second.digest) == "contacts"
    )  # described otherwise, and the same:
    for one, other in zip(first.contacts.pairs, second.contacts.pairs, strict=True):
        np.testing.assert_array_equal(one.nodes, other.nodes)
    masks: list[Bools] = [robot.body.pattern.dof < 0 for robot in (first, second)]
    assert np.array_equal(*masks)


def numbered(folder: Path) -> Path:
    """The box in a file that has a node before all others, which is in no tetrahedron."""
    nodes, path = np.vstack([[9.0, 9.0, 9.0], MESH.nodes]), folder / "box.vtu"
    meshio.write(path, meshio.Mesh(nodes, [("tetra", MESH.tets + 1)]))
    return path


@pytest.mark.parametrize("refinements", [0, 2])
@pytest.mark.parametrize("reader", [read_mesh, read_quadratic_mesh])
def test_numbers_are_those_of_the_file(tmp_path: Path, reader: object, refinements: int) -> None:
    """Those of the end, whose triangles lie in a plane: refined meshes have more nodes in this plane."""
    mesh = reader(numbered(tmp_path))  # type: ignore[operator]
    for _ in range(refinements):
        mesh = mesh.refine()
    whole = mesh.split() if isinstance(mesh, QuadraticMesh) else mesh
    chosen = selector(whole)
    end = np.flatnonzero(np.isclose(MESH.nodes[:, 0], SIZE[0])) + 1
    face = region(kind="nodes", numbers=end.tolist())
    expected = np.isclose(whole.nodes[:, 0], SIZE[0])
    assert np.array_equal(chosen.select_nodes(face, "f"), expected)
    triangles = expected[chosen.boundary].all(axis=1)
    assert np.array_equal(chosen.select_triangles(face, "f"), triangles)
    corners = region(kind="nodes", numbers=(MESH.tets[5] + 1).tolist())
    volume = whole.volumes[chosen.select_tets(corners, "f")].sum()
    assert volume == pytest.approx(MESH.volumes[5], rel=1e-9)


def test_numbers_that_no_node_has_are_said(tmp_path: Path) -> None:
    chosen = selector(read_mesh(numbered(tmp_path)))
    for number in (0, 100):
        with pytest.raises(
            RobotFileError, match=rf"f: node {number} is not in the mesh .* up to 99"
        ):
            chosen.select_nodes(region(kind="nodes", numbers=[5, number]), "f")
    with pytest.raises(RobotFileError, match="no tetrahedron has all of its corners among the 2"):
        chosen.select_tets(region(kind="nodes", numbers=[5, 6]), "f")


def test_numbers_of_one_of_several_bodies_name_it() -> None:
    """The same file twice: without a body the number is of both."""
    settings = beam_config(SIZE)
    body = {"mesh": settings.pop("mesh"), "fixed": settings.pop("fixed")}
    second = {**body, "name": "second", "position": [0.0, 0.1, 0.0]}
    settings["bodies"] = [{**body, "name": "first"}, second]
    ends = {"kind": "nodes", "numbers": [98]}
    tip = {"name": "end", "kind": "centre", "region": {**ends, "body": "second"}}
    mesh = checked(MESH.nodes, MESH.tets, "box")
    robot = build_robot(
        RobotConfig.model_validate({**settings, "effectors": [tip]}), [mesh, mesh], "robot.toml"
    )
    place = robot.rows(robot.rest()).effectors.delta
    np.testing.assert_allclose(place, MESH.nodes[98] + [0.0, 0.1, 0.0], atol=1e-12)
    tip["region"] = ends
    with pytest.raises(RobotFileError, match=r"region: numbers of nodes .*: give the body"):
        build_robot(
            RobotConfig.model_validate({**settings, "effectors": [tip]}), [mesh, mesh], "robot.toml"
        )
