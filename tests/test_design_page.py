"""docs/design.md: every function on a target's way is named and exists; the layout is the import table."""

from __future__ import annotations

import importlib
import re
import sys
from pathlib import Path
from types import FrameType

import numpy as np
import pytest
from support.robots.bodies import beam_robot, box_mesh
from test_architecture import ORDER

from tauten.controller import Controller
from tauten.service.node import ControlLoop, Signals

PAGE = (Path(__file__).parents[1] / "docs" / "design.md").read_text(encoding="utf-8")
NAME = re.compile(r"`((?:model|reduction|controller|service)(?:\.\w+)+)`")
PACKAGES = ("model", "reduction", "controller", "service")


def section(title: str) -> str:
    """The text below a heading of the page."""
    return PAGE.split(f"\n## {title}\n", maxsplit=1)[1].split("\n## ", maxsplit=1)[0]


WALK = NAME.findall(section("A target's way"))


def resolved(name: str) -> object:
    """What a dotted name below `tauten` stands for."""
    parts = name.split(".")
    for end in range(len(parts), 0, -1):
        module = "tauten." + ".".join(parts[:end])
        try:
            found: object = importlib.import_module(module)
        except ModuleNotFoundError as error:
            if error.name is None or not module.startswith(error.name):
                raise
            continue
        for part in parts[end:]:
            found = getattr(found, part)
        return found
    raise ModuleNotFoundError(name)


@pytest.mark.parametrize("name", sorted(set(WALK)))
def test_every_name_on_the_way_exists(name: str) -> None:
    assert callable(resolved(name))


def test_the_way_passes_node_inputs_controller_step_and_solver() -> None:
    passed = {getattr(resolved(name), "__module__", "").removeprefix("tauten.") for name in WALK}
    assert {"service.node.node", "service.node.inputs", "service.node.outputs"} <= passed
    assert {"service.node.loop", "controller.controller", "controller.step"} <= passed
    assert any(module.startswith("controller.qpcc") for module in passed)


def test_what_a_tick_calls_in_public_is_on_the_way() -> None:
    """In the folders that a target passes; the inside of the solver is on its own page."""
    robot = beam_robot(box_mesh((0.1, 0.02, 0.02), (6, 2, 2)), (0.1, 0.02, 0.02))
    loop = ControlLoop(Controller(robot))
    goal = loop.controller.effector + np.array([0.0, 0.0, -0.01])
    loop.tick(goal, Signals(target=True))
    loop.prepare()
    called: set[str] = set()

    def note(frame: FrameType, event: str, argument: object) -> None:
        module = frame.f_globals.get("__name__", "")
        caller = frame.f_back
        if event == "call" and caller is not None and module in STEP_MODULES:
            called.add(f"{module}.{frame.f_code.co_qualname}".removeprefix("tauten."))

    sys.setprofile(note)
    try:
        loop.tick(goal, Signals(target=True))
        loop.prepare()
    finally:
        sys.setprofile(None)
    functions = {function_name(resolved(name)) for name in WALK}
    public = {name for name in called if not re.search(r"\._|<", name)}
    assert len(public) > 8
    assert public - SMALL <= functions


STEP_MODULES = {
    "tauten.service.node.loop",
    "tauten.service.node.limiter",
    "tauten.controller.actuation",
    "tauten.controller.controller",
    "tauten.controller.step",
    "tauten.controller.planning.inverse",
    "tauten.model.step.enrichment",
    "tauten.model.step.condensed_step",
}
# Conversions and look-ups that change nothing.
SMALL = {
    "controller.actuation.Actuation.copy",
    "controller.actuation.Actuation.with_values",
    "controller.controller.Controller.actuation",
    "controller.controller.Controller.effector",
    "model.step.condensed_step.CondensedStep.n_contacts",
    "model.step.condensed_step.CondensedStep.split",
    "model.step.condensed_step.CondensedStep.friction",
    "model.step.condensed_step.CondensedStep.frictional",
    "model.step.condensed_step.unit_rows",
    "model.step.enrichment.PredictedStep.delta",
}


def function_name(found: object) -> str:
    """Module and qualified name of a function or class, without `tauten`."""
    module, name = getattr(found, "__module__", ""), getattr(found, "__qualname__", "")
    return f"{module}.{name}".removeprefix("tauten.")


def test_the_layout_is_that_of_the_import_table() -> None:
    folders = re.findall(r"^\| `([\w/]+)` \|", section("Layout"), flags=re.MULTILINE)
    assert tuple(folder.replace("/", ".") for folder in folders) == ORDER


def test_classes_of_the_glossary_exist() -> None:
    classes = set(re.findall(r"`([A-Z]\w+)(?:\.\w+)?`", section("Glossary")))
    assert len(classes) > 15
    sources = "\n".join(
        path.read_text(encoding="utf-8")
        for package in PACKAGES
        for path in (Path(__file__).parents[1] / package).rglob("*.py")
    )
    missing = {name for name in classes if f"\nclass {name}" not in sources}
    assert not missing
