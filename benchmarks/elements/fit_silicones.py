"""Fits the constants of `silicones` to the tensile tests of the Soft Robotics Materials Database.

    python -m benchmarks.elements.fit_silicones FOLDER

FOLDER is `Tensile-Tests-Data` of a copy of github.com/LucMarechal/Soft-Robotics-Materials-Database.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from scipy.optimize import nnls

from tauten.model.materials import SILICONES
from tauten.model.numerics import Array

LARGEST_STRAIN = 1.0


def read_test(path: Path) -> tuple[Array, Array]:
    """Engineering strain (m,) and engineering stress (m,) [Pa] of a tensile test."""
    rows = []
    for line in path.read_text(encoding="latin-1").splitlines():
        try:
            row = [float(field) for field in line.split(";")[:5]]
        except ValueError:
            continue  # the description above the table
        if len(row) == 5:
            rows.append(row)
    table = np.array(rows)
    return table[:, 3], 1e6 * table[:, 4]


def uniaxial_basis(strain: Array) -> Array:
    """Engineering stress of incompressible Yeoh for unit constants c₁₀, c₂₀, c₃₀: (m, 3)."""
    stretch = 1.0 + strain
    y = stretch**2 + 2.0 / stretch - 3.0
    neo_hookean = 2.0 * (stretch - stretch**-2)
    return neo_hookean[:, None] * np.stack([np.ones_like(y), 2.0 * y, 3.0 * y * y], axis=1)


def main() -> None:
    """Print the constants of every silicone and how well they fit."""
    folder = Path(sys.argv[1])
    for item in SILICONES:
        strain, stress = read_test(folder / f"{item.test}.csv")
        near = strain <= LARGEST_STRAIN
        basis = uniaxial_basis(strain[near])
        constants, _ = nnls(basis, stress[near])
        error = np.sqrt(np.mean((basis @ constants - stress[near]) ** 2))
        print(
            f"{item.name}: c10 {constants[0]:.0f}, c20 {constants[1]:.0f}, c30 {constants[2]:.0f} Pa; "
            f"RMS error {error:.0f} of {stress[near].max():.0f} Pa"
        )


if __name__ == "__main__":
    main()
