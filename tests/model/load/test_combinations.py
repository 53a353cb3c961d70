"""Options of robot files that do not go together: those of the table in docs/robot-file.md, and no others."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, product
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from support.robots.combinations import AXES, BODIES, robot_with, write_networks
from support.robots.my_package import installed

from tauten.model import Robot
from tauten.model.schema import RobotFileError
from tauten.reduction.state import StateBasisError

PAGE = Path(__file__).resolve().parents[3] / "docs" / "robot-file.md"
OPTIONS = {"body": tuple(BODIES), **{axis: tuple(options) for axis, options in AXES.items()}}
AXIS_OF = {name: axis for axis, options in OPTIONS.items() for name in options}
MOST = 15  # combinations that are refused


@pytest.fixture(scope="module", autouse=True)
def package(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ModuleType]:
    """The package of docs/extend.md, whose functions some options name."""
    with installed(tmp_path_factory.mktemp("site")) as module:
        yield module


def rows_of_the_page() -> list[list[str]]:
    """The cells of the table of the page, without its head."""
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    rows = [line.strip("|").split("|") for line in lines if line.startswith("|")]
    return [[cell.strip() for cell in row] for row in rows[2:]]


def options_of_the_page() -> dict[str, tuple[str, ...]]:
    """The options of each axis in the list of the page."""
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    items = [line.removeprefix("- ").split(": ") for line in lines if line.startswith("- ")]
    return {axis: tuple(names.split(", ")) for axis, names in items}


def refused_by_the_page() -> set[frozenset[str]]:
    """Pairs of options in the table; a cell with several stands for each of them."""
    cells = [[cell.split(", ") for cell in row[:2]] for row in rows_of_the_page()]
    return {frozenset(pair) for one, other in cells for pair in product(one, other)}


def take_a_step(robot: Robot) -> None:
    """Rows and a linearised step of the robot at rest, whose numbers are finite."""
    state, effort = robot.rest(), np.ones(robot.n_a)
    rows, system = robot.rows(state), robot.linearise(state, effort)
    for part in (rows.effectors, rows.actuators, rows.contacts.rows):
        H = part.dense()
        assert H.shape == (len(part.delta), robot.n)
        assert np.isfinite(H).all() and np.isfinite(part.delta).all()
        assert np.isfinite(system.solve(np.ascontiguousarray(H.T))).all()
    assert np.isfinite(system.v).all()


def test_the_table_names_options_and_is_short() -> None:
    assert options_of_the_page() == OPTIONS
    rows = rows_of_the_page()
    assert 0 < len(rows) <= MOST
    for pair in refused_by_the_page():
        assert pair <= AXIS_OF.keys()
        assert len({AXIS_OF[name] for name in pair}) == 2


@pytest.mark.long
@pytest.mark.parametrize("axes", list(combinations(OPTIONS, 2)), ids=" and ".join)
def test_just_these_pairs_are_refused(axes: tuple[str, str], tmp_path: Path) -> None:
    """Every other pair makes a robot that takes a step."""
    write_networks(tmp_path)
    found, said = set(), {}
    pairs = list(product(*(OPTIONS[axis] for axis in axes)))
    for pair in pairs:
        try:
            robot = robot_with(list(zip(axes, pair, strict=True)), tmp_path)
        except (RobotFileError, StateBasisError) as error:
            found.add(frozenset(pair))
            said[pair] = str(error)
        else:
            take_a_step(robot)
    known = refused_by_the_page() & {frozenset(pair) for pair in pairs}
    assert found == known, "\n".join(f"{pair}: {text}" for pair, text in said.items())
