"""Record the inverse problems of robots that touch themselves: python -m tests.reference.qpcc.record

The finger with its one cable and the same finger with three follow paths that close its notches; targets
circle, jump, leave the reach and come back. A sample of the problems is kept. Takes some minutes.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.qpcc import Recorded, save_recorded
from tauten.controller import Controller, decide, hold, prepare
from tauten.model import Command, Robot, Simulator, load_robot
from tauten.model.numerics import Array
from tauten.reduction import ContactBasis, Provenance, factorise

HERE = Path(__file__).parent
ROBOTS = HERE.parents[2] / "model" / "robots"
KEPT = 100  # problems a file
MOST_MODES = 40

# Two cables at the notches' side and one opposite: the finger can bend both ways and sideways.
CABLE = """
[[cables]]
name = "cable{index}"
pull_point = [{x}, {y}, 0.005]
points = [[{x}, {y}, -0.003], [{x}, {y}, -0.03], [{x}, {y}, -0.06], [{x}, {y}, -0.096]]
max_tension = 20.0
max_pull = 0.030
max_rate = 0.040
"""
THREE = [(0.011, 0.004), (0.011, 0.011), (0.0025, 0.0075)]


def three_cables(folder: Path) -> Robot:
    """The finger with three single cables instead of the one that goes out and back."""
    text = (ROBOTS / "finger.toml").read_text(encoding="utf-8")
    head, rest = text.split("[[cables]]", maxsplit=1)
    tail = rest[rest.index("[[effectors]]") :]
    cables = "".join(CABLE.format(index=i, x=x, y=y) for i, (x, y) in enumerate(THREE))
    head = head.replace('"finger.vtu"', f'"{ROBOTS / "finger.vtu"}"')
    path = folder / "three.toml"
    path.write_text(head + cables + tail, encoding="utf-8")
    return load_robot(path)


def make_basis(robot: Robot, k: int) -> ContactBasis:
    """Modes of the forces met while the notches close."""
    simulator = Simulator(robot, contact="full")
    columns = []
    for position in np.linspace(0.008, 0.036, 29):
        simulator.settle(position=[position])
        columns.append(simulator.smooth_contact_forces())
    found = factorise(np.array(columns).T, k)
    nowhere = Provenance(
        robot.name,
        robot.digest,
        "",
        "",
        len(columns),
        "",
        "hals",
        k,
        0,
        found.error,
        0.0,
        0.0,
        (),
        "",
        (),
    )
    return ContactBasis(found.Psi, nowhere)


def targets(robot: Robot, rng: np.random.Generator, steps: int) -> Iterator[Array]:
    """Smooth closing paths with sideways noise, jumps every 40 steps, some out of reach."""
    tip = robot.effector(robot.rest())[0]
    bent = tip + np.array([0.06, 0.0, 0.04])
    jump = np.zeros(3)
    for i in range(steps):
        if i % 40 == 0:
            jump = rng.normal(size=3) * 0.01 * rng.integers(0, 3)
        share = 0.5 - 0.5 * np.cos(2.0 * np.pi * i / 150)
        yield tip + share * (bent - tip) + jump


def record(
    robot: Robot, contact: ContactBasis, rng: np.random.Generator, steps: int, name: str
) -> None:
    """One file.

    Args:
        robot: what follows the targets.
        contact: basis of its contact forces.
        rng: source of the targets and of the sample.
        steps: length of the path.
        name: of the file, without its ending.
    """
    controller = Controller(robot, contact)
    robot, settings, position = controller.robot, controller.settings, controller.position
    state, forces, found = controller.state, controller.forces, []
    for target in targets(robot, rng, steps):
        prepared = prepare(
            controller.horizon, contact, state, forces, position, settings.enrichment
        )
        decision = decide(robot, prepared, target, position, settings)
        assert decision.plan is not None
        compliance, start = decision.plan.predicted.step.compliance, decision.plan.start
        if 0 < len(start.piece) <= MOST_MODES:
            found.append(
                Recorded(
                    compliance.W, compliance.delta_free, target, robot.limits, position, robot.h,
                    settings.epsilon, start,
                )
            )  # fmt: skip
        if not decision.status.usable:
            held = Command.of(position, None)
            decision = hold(robot, prepared, held, position, settings.enrichment)
        position, step = decision.position, decision.predicted.step
        state = robot.advance(step.state, step.system.v + decision.predicted.dv, step.system.h)
        forces = decision.predicted.step.split(decision.predicted.lam, contact.k)
    kept = sorted(rng.choice(len(found), size=min(KEPT, len(found)), replace=False))
    save_recorded(HERE / f"{name}.npz", [found[i] for i in kept])
    print(name, steps, "steps,", len(found), "with contact,", len(kept), "kept")


def main() -> None:
    """All files."""
    rng = np.random.default_rng(4)
    finger = load_robot("finger")
    few, many = make_basis(finger, 5), make_basis(finger, 20)
    with TemporaryDirectory() as folder:
        three = three_cables(Path(folder))
        record(finger, few, rng, 450, "finger_5")
        record(finger, many, rng, 300, "finger_20")
        record(three, few, rng, 300, "three_cables_5")
        record(three, many, rng, 300, "three_cables_20")


if __name__ == "__main__":
    main()
