"""`tauten check` of a robot with a body that is a beam."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from support.robots.beam_robots import SPACING, STIFFNESS, tendon_arm

from benchmarks.robots.arm import ArmShape, make_network
from benchmarks.robots.make_manipulator import make_file
from tauten.controller import Controller
from tauten.model import load_robot
from tauten.service.check import CheckSettings, check_robot
from tauten.service.check.actuator_findings import NEAR, buckling_share
from tauten.service.check.body_findings import body_findings
from tauten.service.check.mesh_variants import make_loads
from tauten.service.process import StopFlag

SPINE = """
name = "spine"

[material]
young_modulus = 2e9
poisson_ratio = 0.35
density = 1100.0

[[profiles]]
kind = "tube"
name = "rod"
outer = 2e-3

[[bodies]]
name = "rod"
beam = { points = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]], elements = 4, profile = "rod" }
fixed = [{ kind = "sphere", centre = [0.0, 0.0, 0.0], radius = 1e-6 }]

[[cables]]
name = "tendon"
points = [[0.0, 0.0, 0.008], [0.1, 0.0, 0.008]]
max_outside = 0.01
max_tension = 1.0
max_pull = 0.01
max_rate = 0.1

[[effectors]]
name = "tip"
point = [0.1, 0.0, 0.0]
"""


ARM = """{
  "nodes": [[0.0, 0.0, 0.0], [0.0, 0.0, -0.05], [0.0, 0.0, -0.1]],
  "beams": [
    {"ends": [0, 1], "profile": "rod", "up": [1.0, 0.0, 0.0]},
    {"ends": [1, 2], "profile": "rod", "up": [1.0, 0.0, 0.0]}
  ]
}"""


@pytest.mark.parametrize("tension", [10.0, 300.0])
def test_no_tendon_is_pulled_farther_than_it_may_be(tension: float, tmp_path: Path) -> None:
    """Half of 10 N took it to 76 mm, where the robot never is, and half of 300 N nowhere."""
    text = SPINE.replace(
        'points = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]], elements = 4, profile = "rod"',
        'file = "arm.json"',
    )
    text = text.replace(
        "[[0.0, 0.0, 0.008], [0.1, 0.0, 0.008]]", "[[0.015, 0.0, -0.05], [0.015, 0.0, -0.1]]"
    )
    text = text.replace("[0.1, 0.0, 0.0]", "[0.0, 0.0, -0.1]").replace(
        "max_outside = 0.01", "max_outside = 0.02"
    )
    (tmp_path / "arm.json").write_text(ARM)
    file = tmp_path / "arm.toml"
    file.write_text(text.replace("max_tension = 1.0", f"max_tension = {tension}"))
    loads = make_loads(load_robot(file), (0.25, 0.5), antagonists=True)
    assert [load.position for load in loads] == pytest.approx([0.0025, 0.005])


def test_a_body_that_is_a_beam_is_checked(tmp_path: Path) -> None:
    """Its mass is that of the rod without its clamped node, its sag that of a cantilever under its weight."""
    path = tmp_path / "spine.toml"
    path.write_text(SPINE, encoding="utf-8")
    settings = CheckSettings(str(path), ())
    result = check_robot(settings, StopFlag(), lambda _share, _what: None)
    found = {item.subject: item.found for item in result.findings}
    mass = 1100.0 * np.pi / 4.0 * 2e-3**2 * 0.1 * 7.0 / 8.0
    assert float(found["moving mass"].split()[0]) == pytest.approx(1e3 * mass, rel=1e-3)
    sag = float(found["sag under gravity"].split()[0])
    line = 1100.0 * np.pi / 4.0 * 2e-3**2 * 9.81  # N/m
    bent = line * 0.1**4 / 8.0 / (2e9 * np.pi / 64.0 * 2e-3**4)
    assert sag == pytest.approx(
        1e3 * bent, rel=0.04
    )  # masses on four nodes; corners beyond the end


@pytest.mark.long
@pytest.mark.parametrize(("tension", "level"), [(10.0, "fine"), (40.0, "doubtful")])
def test_tensions_under_which_an_arm_buckles_are_found(
    tension: float, level: str, tmp_path: Path
) -> None:
    """Three tendons along a rod; between two of their points one element buckles under 12 EI / L².

    A target 5 mm below what the arm reaches led decisions there, and the tip away from it by 106 mm, with OK.
    """
    file = tendon_arm(tmp_path, tension)
    settings = CheckSettings(str(file), shares=())
    (finding,) = (
        item
        for item in check_robot(settings, StopFlag(), lambda _share, _what="": None).findings
        if item.subject == "movement of effectors"
    )
    assert finding.level == level, finding
    load = 12.0 * STIFFNESS / SPACING**2  # N
    share = buckling_share(load_robot(file))
    assert share == pytest.approx(min(load / (3.0 * tension), 1.0), abs=NEAR)


@pytest.mark.parametrize(
    ("damping", "level"),
    [("rayleigh_mass = 5.0", "doubtful"), ("rayleigh_stiffness = 0.02", "fine")],
)
def test_light_damping_is_found_and_the_advice_lets_the_tip_settle(
    damping: str, level: str, tmp_path: Path
) -> None:
    """With `substeps = 1` a target 0.4 mm out of reach keeps a model that is damped so lightly swinging."""
    file = tendon_arm(tmp_path, 12.0)
    text = file.read_text(encoding="utf-8") + f"[integration]\n{damping}\n"
    file.write_text(text, encoding="utf-8")
    *_, finding = body_findings(load_robot(file))
    assert finding.level == level, finding
    if level == "fine":
        return
    (advised,) = re.findall(r"rayleigh_stiffness = [0-9.e-]+", finding.advice)
    file.write_text(f"{text}{advised}\n", encoding="utf-8")
    *_, finding = body_findings(load_robot(file))
    assert finding.level == "fine"
    controller, target = Controller.of(str(file)), np.array([0.05, -0.02, 0.3955])
    for _ in range(200):
        assert controller.step(target).status.ok
    assert np.linalg.norm(controller.tip - target) < 4e-4


def small_arm(folder: Path) -> Path:
    """An arm of three joints and three tendons, as a file."""
    shape = ArmShape(length=0.16, sections=1, joints=3)
    (folder / "manipulator.json").write_text(json.dumps(make_network(shape)), encoding="utf-8")
    path = folder / "arm.toml"
    text = make_file(shape, "arm", 36).replace('basis = "arm"', 'basis = "none"')
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.long
def test_beams_are_halved_until_their_limit_is_known(tmp_path: Path) -> None:
    """Helices converge at least with the square of their length."""
    settings = CheckSettings(str(small_arm(tmp_path)), shares=(0.2,), refinements=2)
    result = check_robot(settings, StopFlag(), lambda _share, _what: None)
    subjects = [item.subject for item in result.findings]
    assert subjects == [
        "region fixed.0",
        "moving mass",
        "sag under gravity",
        "natural frequencies",
        "cables against their pulls",
        "rates of actuators",
        "movement of effectors",
        "error of the mesh",
        "first decision",
        "control step against period",
    ]
    assert result.estimate is not None
    names = [item.variant.name for item in result.estimate.variants]
    assert names == ["beam", "beam, refined once", "beam, refined twice"]
    orders = [item.order for item in result.estimate.references if item is not None]
    assert len(orders) == 3
    assert all(order is not None and 1.9 < order < 4.0 for order in orders)
    own, halved, _ = (item.effort for item in result.estimate.variants)
    assert own is not None
    assert halved is not None
    assert 0.0 < halved < 0.3 * own
