"""Pieces of robot files."""

from __future__ import annotations

from tauten.model.numerics import Array

RATE = "rate = 50.0\n"
# of robots that cables hold
FOLLOWING = "following_horizon = 0.08    # s; over a longer one it buckles at given tensions\n"
# The tables of time steps, control and service of a robot that its reduced model decides for.
REDUCED_TABLES = f"""
[integration]
rayleigh_stiffness = 0.02

[controller]
{RATE}
[model]
order = "reduced"

[service]
target_timeout = 0.5
release_time = 1.0
"""


def point_list(places: Array) -> str:
    """Points (m, 3) [m] as lines of a TOML array, to a hundredth of a millimetre."""
    rows = (", ".join(f"{value + 0.0:.5f}" for value in place.round(5)) for place in places)
    return "\n".join(f"  [{row}]," for row in rows)
