"""The closed-loop benchmark on robots of the gallery: a step, as modelled and with a stiffer body."""

from __future__ import annotations

from functools import cache

import pytest

from benchmarks.control import CASES, CaseRunner, Outcome, make_cases, planned
from tauten.model import load_robot
from tauten.service.setup import load_setup

pytestmark = [pytest.mark.slow]
ROBOTS = ("trunk", "pneumatic_finger", "tripod")
# The finger rests 1.2 s after its step in open loop.
SECONDS = {"trunk": 2.0, "pneumatic_finger": 3.2, "tripod": 2.0}


@cache
def outcomes(name: str) -> dict[tuple[str, bool], Outcome]:
    """Outcomes of the step and of the step with a stiffer robot, in open and closed loop."""
    setup = load_setup(name, model="full")
    cases = make_cases(setup.robot, SECONDS[name], 0, lambda: None)
    assert tuple(case.name for case in cases) == CASES
    runner = CaseRunner(setup)
    groups = {group.name: group for group in planned(cases)}
    return {
        (group, closed): runner.run(groups[group], "reduced", closed)[0]
        for group in ("step", "stiffness-1.2")
        for closed in (False, True)
    }


@pytest.mark.parametrize("name", ROBOTS)
def test_a_step_is_followed(name: str) -> None:
    size = 1e3 * load_robot(name).size
    for closed in (False, True):
        outcome = outcomes(name)["step", closed]
        assert outcome.unusable == 0
        assert outcome.end_mm < 0.003 * size
        assert outcome.settling_s is not None


@pytest.mark.parametrize("name", ROBOTS)
def test_the_closed_loop_corrects_a_stiffer_body(name: str) -> None:
    found = outcomes(name)
    assert found["stiffness-1.2", False].unusable == found["stiffness-1.2", True].unusable == 0
    ends = [found["stiffness-1.2", closed].end_mm for closed in (False, True)]
    assert ends[1] < 0.5 * ends[0]
