"""The text of a new robot file: guessed values, and comments that say what to look at."""

from __future__ import annotations

from dataclasses import dataclass

from tauten.model.numerics import Array
from tauten.service.new.guesses import Guess

TEXT = """\
# Robot made by `tauten new {name}` from {part}. All lengths in metres, forces in newtons.
# Lines with GUESS have values that the mesh does not contain. Correct them, then look at the robot:
#     tauten check {name}.toml
#     tauten demo {name}.toml
# Every field of a robot file: docs/reference/robot-file.md, or `tauten schema`.
name = "{name}"
frame = "{name}_base"
gravity = [0.0, 0.0, -9.81]       # GUESS: the direction of gravity in the coordinates of the mesh [m/s²]

[mesh]
file = "{name}.vtu"               # {nodes} nodes, elements of {size_mm:.3g} mm; already in metres
element = "smoothed"              # linear tetrahedra without locking; docs/elements.md compares elements

[material]                        # GUESS: a soft casting silicone; or silicone = "ecoflex-00-50"
young_modulus = {young:.3g}           # [Pa]
poisson_ratio = {poisson:g}
density = {density:g}                  # [kg/m³]

[[fixed]]                         # GUESS: nodes beyond this plane are held; here the larger end of the part
kind = "half_space"
point = {held}
normal = {outward}

{actuators}
[[effectors]]                     # GUESS: the middle of the free end is to reach targets
name = "tip"
point = {effector}
max_outside = {outside:.2g}

[integration]
rayleigh_stiffness = 0.02         # GUESS: damping of the material [s]

[controller]
rate = {rate:g}                       # decisions per second [Hz]{slow}

{contact}"""

CABLE = """\
[[cables]]                        # GUESS: one cable along the side that is farthest from the axis
name = "cable"
pull_point = {pull_point}    # where it leaves the robot, fixed in space
points = [                        # holes that it passes, fixed in the body; the last is where it ends
{points}]
max_pull = {max_pull:.4g}                  # GUESS: a tenth of the length, or what has an equilibrium [m]
max_tension = {max_tension:.3g}               # GUESS: twice what it took to pull so far [N]
max_rate = {max_rate:.4g}                  # GUESS: how fast the winch turns [m/s]
max_outside = {outside:.2g}             # how far outside of the mesh its points may lie [m]
"""

CHAMBER = """\
[[chambers]]                      # a closed cavity of {millilitres:.3g} ml
name = "{name}"
inside = {inside}        # a point in it
max_pressure = {pressure:.4g}             # GUESS: what has an equilibrium and moves the tip [Pa]
max_volume_change = {volume:.4g}          # GUESS: a fifth more than that takes [m³]
max_rate = {rate:.4g}                  # GUESS: how fast it is filled [m³/s]
"""

CONTACT = """\
# Where two faces of the body may touch, name both, uncomment, set controller.basis (docs/contact.md).
# [[surfaces]]
# name = "above"
# box = {{ lower = {lower}, upper = {upper} }}
# normal = [0.0, 0.0, -1.0]
# [[surfaces]]
# name = "below"
# box = {{ lower = {lower}, upper = {upper} }}
# normal = [0.0, 0.0, 1.0]
# [[contacts]]
# candidates = "below"
# against = "above"
# points = 100
"""


@dataclass(frozen=True, slots=True)
class Values:
    """What the text contains beside the guesses.

    Attributes:
        name: of the robot.
        part: name of the file that it was made from; what cannot be printed is shown as "?".
        nodes: of its mesh.
        size: of its elements [m].
        young: Young's modulus [Pa].
        rate: control rate [Hz].
    """

    name: str
    part: str
    nodes: int
    size: float
    young: float
    rate: float


POISSON, DENSITY = 0.45, 1070.0  # of a usual silicone; density [kg/m³]
MOVE_TIME = 2.0  # s, from rest to the largest pull or pressure
RATE = 50.0  # Hz
SLOW = "; the most that the full model has time for, a reduced one permits more"
SPARE = 1.2  # how much more than what was needed a chamber's volume may change


def robot_text(values: Values, guess: Guess, actuators: str) -> str:
    """The text of a robot file."""
    middle = (guess.cable[0] + guess.cable[-1]) / 2.0
    return TEXT.format(
        name=values.name,
        part="".join(c if c.isprintable() else "?" for c in values.part),
        nodes=values.nodes,
        size_mm=1e3 * values.size,
        young=values.young,
        poisson=POISSON,
        density=DENSITY,
        held=numbers(guess.held),
        outward=numbers(guess.outward),
        actuators=actuators,
        outside=guess.outside,
        effector=numbers(guess.effector),
        rate=values.rate,
        slow="" if values.rate == RATE else SLOW,
        contact=CONTACT.format(lower=numbers(middle - guess.outside), upper=numbers(middle)),
    )


def cable_table(guess: Guess, max_pull: float, max_tension: float) -> str:
    """The guessed cable.

    Args:
        guess: the guessed fields.
        max_pull: largest pulled length [m].
        max_tension: [N].
    """
    return CABLE.format(
        pull_point=numbers(guess.pull_point),
        points="".join(f"  {numbers(point)},\n" for point in guess.cable),
        max_pull=max_pull,
        max_tension=max_tension,
        max_rate=max_pull / MOVE_TIME,
        outside=guess.outside,
    )


def chamber_tables(guess: Guess, pressure: float, volume: float) -> str:
    """The guessed chambers, one table each.

    Args:
        guess: the guessed fields.
        pressure: largest one [Pa].
        volume: largest change of the volume of one at that [m³].
    """
    tables = [
        CHAMBER.format(
            name="air" if len(guess.cavities) == 1 else f"air{number}",
            millilitres=1e6 * cavity.volume,
            inside=numbers(cavity.inside),
            pressure=pressure,
            volume=SPARE * volume,
            rate=SPARE * volume / MOVE_TIME,
        )
        for number, cavity in enumerate(guess.cavities, 1)
    ]
    return "\n".join(tables)


def numbers(values: Array) -> str:
    """A TOML array of coordinates (c,) [m], to a hundredth of a millimetre."""
    return "[" + ", ".join(f"{value:.5f}" for value in values.tolist()) + "]"
