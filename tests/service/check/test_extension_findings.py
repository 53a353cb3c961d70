"""`tauten check` compares the derivatives that extensions give with differences of their values."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from types import ModuleType
from typing import Any

import pytest
from support.robots.my_package import installed, tables
from support.robots.small_bodies import small_body

from tauten.model import Robot
from tauten.service.check.extension_findings import extension_findings

FOUND = {key: one for table in tables() for key, one in table.items()}
MUSCLE = {**FOUND["transmissions"][0], "points": [[0.0, 0.01, 0.018], [0.1, 0.01, 0.018]]}
SPREAD = {
    **FOUND["effectors"][0],
    "points": [[0.02, 0.01, 0.01], [0.1, 0.01, 0.01], [0.06, 0.01, 0.018]],
}


@pytest.fixture
def package(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ModuleType]:
    """docs/extend.md as an installed package."""
    with installed(tmp_path_factory.mktemp("package")) as module:
        yield module


def extended() -> Robot:
    """A beam with the muscle, the effector and the obstacle of the page."""
    return small_body(
        "linear",
        transmissions=[MUSCLE],
        effectors=[SPREAD],
        obstacles=FOUND["obstacles"],
        contacts=FOUND["contacts"],
    )


def test_the_extensions_of_the_page_are_fine(package: ModuleType) -> None:
    (finding,) = extension_findings(extended())
    assert finding.level == "fine"
    for name in (
        "gradient of muscle",
        "curvature of muscle",
        "gradient of grasp",
        "normals of hoop",
    ):
        assert name in finding.found


def test_robots_without_extensions_have_no_such_line() -> None:
    assert not list(extension_findings(small_body("linear")))


WRONG: dict[str, tuple[str, str, Callable[[Any], Any], str]] = {
    "gradient of muscle is 200 %": (
        "McKibben", "at", lambda one: replace(one, gradient=-one.gradient), "wrong",
    ),
    "curvature of muscle is 50 %": (
        "McKibben", "at", lambda one: replace(one, curvature=0.5 * one.curvature), "wrong",
    ),
    "gradient of grasp is 4.": (
        "Spread", "at", lambda one: replace(one, gradient=1.05 * one.gradient), "doubtful",
    ),
    "normals of hoop is": ("Ring", "closest", lambda one: (one[0], -one[1]), "wrong"),
}  # fmt: skip


@pytest.mark.parametrize("said", WRONG)
def test_a_wrong_derivative_is_named(
    said: str, package: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a gradient of the wrong sign nothing was said, and `tauten view` did not get ready in 90 s."""
    name, method, change, level = WRONG[said]
    own = getattr(package, name)
    usual = getattr(own, method)
    monkeypatch.setattr(own, method, lambda self, y: change(usual(self, y)))
    findings = list(extension_findings(extended()))
    assert [said in one.found for one in findings].count(True) == 1
    assert next(one.level for one in findings if said in one.found) == level
