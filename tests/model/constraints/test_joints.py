"""Beams among bodies, pins and hinges between rigid bodies: derivatives by finite differences."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from support.robots.bodies import CABLE
from support.robots.joined import RUBBER, joined, joined_config, push, rod
from support.robots.small_bodies import moved

from tauten.model import Robot, State
from tauten.model.constraints import ConstrainedBody
from tauten.model.load import beam_network
from tauten.model.numerics import Array
from tauten.model.schema import RobotFileError

BOX = ((0.02, 0.02, 0.02), (1, 1, 1))


def node(x: float, y: float = 0.01, z: float = 0.01, body: str = "rod") -> dict[str, object]:
    """The node of a beam near a place."""
    return {"body": body, "kind": "sphere", "centre": [x, y, z], "radius": 1e-6}


def everything() -> Robot[ConstrainedBody]:
    """A rod that a servo turns, pinned in a soft box, glued to a rigid one; two more on a hinge and a pin."""
    whole = [{"kind": "all", "body": name} for name in ("soft", "first", "second", "third")]
    line = [[-0.02, 0.01, 0.01], [0.04, 0.01, 0.01]]
    axis = {"axis": [0.0, 1.0, 0.3], "tilt_stiffness": 0.1}
    return joined(
        [
            rod("rod", line, elements=6),
            {"name": "soft"},
            {"name": "first", "rigid": True, "position": [0.04, 0.0, 0.0]},
            {"name": "second", "rigid": True, "position": [0.06, 0.0, 0.0]},
            {"name": "third", "rigid": True, "position": [0.08, 0.0, 0.0]},
        ],
        {"soft": BOX, "first": BOX, "second": BOX, "third": BOX},
        gravity=[0.0, 0.0, -9.81],
        attachments=[
            {"kind": "pin", "region": node(0.01), "to": whole[0]},
            {"kind": "pin", "region": node(0.02), "to": whole[0]},
            {"kind": "glue", "region": node(0.04), "to": whole[1]},
            {"kind": "hinge", "region": whole[2], "to": whole[1], "through": [0.06, 0.01, 0.0], **axis},
            {"kind": "pin", "region": whole[3], "to": whole[2], "through": [0.08, 0.01, 0.01]},
            {
                "kind": "glue", "region": {"body": "soft", "lower": [0, 0, 0], "upper": [0, 0.02, 0.02]},
                "to": {"body": "rod", "kind": "all"}, "max_distance": 0.1,
            },
        ],
        drives=[{
            "name": "servo", "region": node(-0.02), "axis": [1.0, 0.5, 0.0], "through": [-0.02, 0.01, 0.01],
            "max_angle": 3.0, "max_torque": 100.0, "max_rate": 100.0,
        }],
        cables=[{**CABLE, "points": [[-0.02, 0.01, 0.012], [0.05, 0.01, 0.015], [0.09, 0.01, 0.01]],
                 "max_outside": 0.01}],
        forces=[push("push", [0.1, 0.01, 0.0], [1.0, 2.0, 3.0])],
        effectors=[
            {"name": "end", "kind": "distance", "point": [0.1, 0.01, 0.0], "other": [0.05, 0.01, 0.0]},
            {"name": "middle", "point": [0.03, 0.01, 0.01]},
        ],
    )  # fmt: skip


@pytest.fixture(scope="module")
def robot() -> Robot[ConstrainedBody]:
    return everything()


@pytest.fixture(scope="module")
def state(robot: Robot[ConstrainedBody]) -> State:
    """Far from rest: rotations of a few tenths, everything else moved by millimetres."""
    rng = np.random.default_rng(1)
    scale = np.full(robot.n, 2e-3)
    first = 3 * len(robot.body.coordinates.free)
    scale[first + robot.body.frames.rotations[:, None] + np.arange(3)] = 0.1
    scale[first + robot.body.frames.drives] = 0.3
    return moved(robot, robot.rest(), scale * rng.standard_normal(robot.n))


@pytest.fixture(scope="module")
def direction(robot: Robot[ConstrainedBody]) -> Array:
    return np.random.default_rng(2).standard_normal(robot.n)


def derivative(robot: Robot[ConstrainedBody], state: State, value: object, d: Array) -> Array:
    step = 1e-6
    ahead, behind = (value(moved(robot, state, sign * step * d)) for sign in (1.0, -1.0))  # type: ignore[operator]
    return np.asarray((ahead - behind) / (2.0 * step))


def test_frames_of_each_kind(robot: Robot[ConstrainedBody]) -> None:
    """Free nodes of the beam and two bodies are rigid regions, three parts are pinned, one drive."""
    frames = robot.body.frames
    assert (frames.n_rigid, frames.n_pinned, frames.n_drives) == (4, 4, 1)
    assert robot.displacement(robot.rest(), np.ones(robot.n)) > 1.0


def test_velocities_of_nodes(robot: Robot[ConstrainedBody], state: State, direction: Array) -> None:
    found = derivative(robot, state, lambda at: robot.body.placed(at)[0], direction)
    T = robot.body.coordinates.matrix(robot.body.placed(state)[1].T)
    assert np.abs((T @ direction)[: len(found)] - found).max() < 1e-7 * np.abs(found).max()


def test_beams_are_drawn_around_their_axis(robot: Robot[ConstrainedBody], state: State) -> None:
    """The outline of a rod of 2 mm, a millimetre from the line between its nodes, which it moves with."""
    points, triangles = robot.points(robot.rest()), robot.triangles
    drawn = np.unique(triangles)
    assert drawn.max() == len(points) - 1
    outline = points[robot.n_nodes :]
    radius = np.linalg.norm(outline[:, 1:] - 0.01, axis=1)
    assert radius == pytest.approx(np.full(len(outline), 1e-3))
    beams = robot.body.joints
    assert beams is not None
    # no corner beside a node is part of the surface
    corners = (beams.nodes[:, None] + np.arange(4)).ravel()
    assert not np.isin(drawn, corners).any()
    at = robot.points(state)
    nodes = robot.body.nodes(state)[beams.nodes]
    away = np.linalg.norm(at[robot.n_nodes :, None] - nodes, axis=2).min(axis=1)
    assert away == pytest.approx(np.full(len(outline), 1e-3))


def test_rest_is_where_the_bodies_are(robot: Robot[ConstrainedBody]) -> None:
    assert np.abs(robot.body.nodes(robot.rest()) - robot.body.mesh.nodes).max() < 1e-15


@pytest.mark.parametrize("kind", ["effectors", "actuators"])
def test_rows(robot: Robot[ConstrainedBody], state: State, direction: Array, kind: str) -> None:
    rows = getattr(robot.rows(state), kind)
    found = derivative(robot, state, lambda at: getattr(robot.rows(at), kind).delta, direction)
    assert len(found) > 0
    assert np.abs(rows.H @ direction - found).max() < 1e-6 * np.abs(found).max()


def test_forces_are_the_derivative_of_the_potential(
    robot: Robot[ConstrainedBody], state: State, direction: Array
) -> None:
    slope = derivative(robot, state, robot.potential, direction)
    force, _ = robot.forces(state)
    assert -force @ direction == pytest.approx(float(slope), rel=1e-6)


def test_the_tangent_is_the_derivative_of_the_forces(
    robot: Robot[ConstrainedBody], state: State, direction: Array
) -> None:
    """Its symmetric part; half of the cross product with the moment on a rotation is what it lacks."""
    _, values = robot.forces(state, np.zeros(robot.n_a), exact=True)
    K = sp.csc_array(
        (values, robot.body.pattern.indices, robot.body.pattern.indptr), shape=(robot.n,) * 2
    )
    assert np.abs(K - K.T).max() < 1e-9 * np.abs(K).max()
    found = -derivative(robot, state, lambda at: robot.forces(at)[0], direction)
    moment = robot.forces(state)[0]
    lacking = np.zeros(robot.n)
    for first in 3 * len(robot.body.coordinates.free) + robot.body.frames.rotations:
        three = slice(first, first + 3)
        lacking[three] = 0.5 * np.cross(moment[three], direction[three])
    assert np.abs(lacking).max() > 0.0
    assert np.abs(K @ direction + lacking - found).max() < 1e-6 * np.abs(found).max()


def test_the_semidefinite_tangent_has_no_negative_direction(
    robot: Robot[ConstrainedBody], state: State
) -> None:
    _, values = robot.forces(state)
    K = sp.csc_array(
        (values, robot.body.pattern.indices, robot.body.pattern.indptr), shape=(robot.n,) * 2
    )
    lowest = np.linalg.eigvalsh(K.toarray())
    assert lowest[0] > -1e-9 * lowest[-1]


RIGID = [
    rod("rod", [[0.0, 0.01, 0.01], [0.02, 0.01, 0.01]], elements=2),
    {"name": "box", "rigid": True},
]
SOFT = [RIGID[0], {"name": "box", "fixed": [{"kind": "all"}]}]
BOXES = {"box": BOX}
ALL = {"kind": "all", "body": "box"}
ROD = {"kind": "all", "body": "rod"}


@pytest.mark.parametrize(
    ("bodies", "attachment", "sentence"),
    [
        (
            [{**RIGID[0], "mesh": {"file": "box.vtu"}}], None,
            "bodies.0: a body has a mesh or a beam, this one has both",
        ),
        (
            [{"name": "rod"}], None, "bodies.0: a body has a mesh or a beam, this one has neither",
        ),
        (
            [{**RIGID[0], "rigid": True}], None,
            "bodies.0: rigid: a beam deforms and has one material, leave it out",
        ),
        (
            [{**RIGID[0], "beam": {**RIGID[0]["beam"], "profile": "wire"}}], None,
            "bodies.0.beam.profile: 'wire' is not one of profiles, which has rod",
        ),
        (
            [{**RIGID[0], "beam": {**RIGID[0]["beam"], "up": [1.0, 0.0, 0.0]}}], None,
            "bodies.0.beam: beams.0: up [1.0, 0.0, 0.0] lies along the beam",
        ),
        (RIGID[:1], None, "fixed: needs three nodes not on a line to hold the robot"),
        (
            SOFT, {"kind": "glue", "region": node(0.01), "to": ALL},
            "attachments.0: a node of a beam is glued to what is rigid; at a soft body exchange region and "
            'to, or let kind = "pin" hold its position',
        ),
        (
            SOFT, {"kind": "pin", "region": ROD, "to": ALL},
            "bodies.rod: its pins lie on a line, about which it turns freely; fix or glue one of its nodes, "
            "or glue something to it",
        ),
        (
            RIGID, {"kind": "pin", "region": ALL, "to": ROD},
            "attachments.0.through: needed by the pin of a rigid body: the point that it turns about",
        ),
        (
            [{**RIGID[0], "fixed": [node(0.0)]}, {"name": "box"}],
            {"kind": "pin", "region": ALL, "to": ROD},
            "attachments.0.region: a pin holds nodes of a beam or a rigid body, found neither",
        ),
        (
            [{**RIGID[0], "fixed": [node(0.0)]}, RIGID[1]],
            {"kind": "pin", "region": node(0.0), "to": ALL},
            "attachments.0.region: 1 of its 1 nodes of beams are fixed, move with a frame or are attached "
            "already; take them out of one of the two",
        ),
        (
            [{**RIGID[0], "fixed": [node(0.0)]}, RIGID[1]],
            {
                "kind": "hinge", "region": ALL, "to": ROD, "axis": [0, 1, 0], "through": [0.02, 0.01, 0.01],
                "radius": 0.1,
            },
            "attachments.0.radius: a rigid body turns about its axis, leave it out",
        ),
        (
            SOFT, {"kind": "glue", "region": ALL, "to": ROD, "tilt_stiffness": -1.0},
            "attachments.0.tilt_stiffness: allowed is at least 1e-06 and at most 1e+09 N m/rad, found -1.0",
        ),
    ],
)  # fmt: skip
def test_files_that_make_no_sense(
    bodies: list[dict[str, object]], attachment: dict[str, object] | None, sentence: str
) -> None:
    attachments = [] if attachment is None else [attachment]
    with pytest.raises(RobotFileError) as caught:
        joined(
            bodies,
            BOXES,
            attachments=attachments,
            forces=[push("push", [0.0, 0.0, 0.0], [0, 0, 1])],
        )
    assert sentence in str(caught.value)


def test_a_viscous_beam_is_refused() -> None:
    """Its material may be that of the whole file."""
    viscous = {**RUBBER, "viscosity": {"shear_viscosity": 10.0}}
    held = {key: value for key, value in RIGID[0].items() if key != "material"}
    with pytest.raises(RobotFileError, match=r"bodies\.0\.material: a beam is elastic"):
        joined([{**held, "fixed": [node(0.0)]}], material=viscous)


def test_parts_that_follow_each_other_are_refused() -> None:
    """A rigid box is pinned to a beam whose node is pinned to the box."""
    pins = [
        {"kind": "pin", "region": node(0.02), "to": ALL},
        {
            "kind": "pin",
            "region": ALL,
            "to": node(0.02) | {"radius": 0.003},
            "through": [0.02, 0.01, 0.01],
        },
    ]
    bodies = [{**RIGID[0], "fixed": [node(0.0)]}, RIGID[1]]
    with pytest.raises(RobotFileError, match="it follows parts that follow it"):
        joined(bodies, BOXES, attachments=pins, forces=[push("push", [0, 0, 0], [0, 0, 1])])


def test_refinement_halves_the_beams() -> None:
    config = joined_config([{**RIGID[0], "fixed": [node(0.0)]}])
    counts = [len(beam_network(config, config.bodies[0], refinements=k).nodes) for k in range(3)]
    assert counts == [3, 5, 9]
