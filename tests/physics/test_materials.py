"""Energy, stress and tangents of every law: derivatives, frames, analytical solutions, inverted elements."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from tauten.model.materials import (
    EXACT,
    NO_TANGENT,
    PROJECTED,
    SILICONES,
    WORK,
    Law,
    MaterialError,
    corotational,
    find_silicone,
    law_arrays,
    mooney_rivlin,
    neo_hookean,
    response,
    stable_neo_hookean,
    yeoh,
)
from tauten.model.numerics import Array, polar_rotations
from tauten.model.schema import SolidMaterialSettings

LAWS = [
    corotational(1e5, 0.45),
    stable_neo_hookean(1e5, 0.45),
    neo_hookean(1e5, 0.45),
    mooney_rivlin(1.2e4, 0.5e4, 0.45),
    yeoh(1.7e4, -200.0, 23.0, 0.45),
]
every_law = pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)


def evaluate(law: Law, F: Array, tangent: int = EXACT) -> tuple[float, Array, Array]:
    (kind,), (constants,) = law_arrays([law])
    R = np.empty((1, 3, 3))
    polar_rotations(F[None].copy(), R)
    P, C = np.empty((3, 3)), np.full((9, 9), np.nan)
    return response(kind, constants, F, R[0], tangent, P, C, np.empty(WORK)), P, C


def gradients(seed: int, count: int = 12) -> list[Array]:
    """Random deformation gradients, the first half proper, the second half inverted."""
    rng = np.random.default_rng(seed)
    stretches = np.sort(rng.uniform(0.5, 1.8, (count, 3)))[:, ::-1]
    stretches[count // 2 :, 2] *= -rng.uniform(0.1, 0.9, count - count // 2)
    frames = Rotation.random(2 * count, random_state=seed).as_matrix()
    return [
        U @ np.diag(s) @ V.T
        for U, s, V in zip(frames[:count], stretches, frames[count:], strict=True)
    ]


@every_law
def test_stress_is_the_derivative_of_the_energy(law: Law) -> None:
    for F in gradients(0):
        _, P, _ = evaluate(law, F)
        for i in range(3):
            for j in range(3):
                step = np.zeros((3, 3))
                step[i, j] = 1e-6
                slope = (evaluate(law, F + step)[0] - evaluate(law, F - step)[0]) / 2e-6
                assert P[i, j] == pytest.approx(slope, abs=1e-7 * np.abs(P).max() + 1e-4)


@every_law
def test_exact_tangent_is_the_derivative_of_the_stress(law: Law) -> None:
    for F in gradients(1):
        _, _, C = evaluate(law, F)
        difference = np.empty((9, 9))
        for m in range(9):
            step = np.zeros(9)
            step[m] = 1e-6
            step = step.reshape(3, 3)
            difference[:, m] = (evaluate(law, F + step)[1] - evaluate(law, F - step)[1]).ravel()
        assert np.allclose(C, difference / 2e-6, atol=2e-7 * np.abs(C).max())


@every_law
def test_projected_tangent_is_the_exact_one_without_negative_eigenvalues(law: Law) -> None:
    changed = 0
    for F in gradients(2):
        exact, projected = evaluate(law, F, EXACT)[2], evaluate(law, F, PROJECTED)[2]
        values, vectors = np.linalg.eigh(exact)
        nearest = vectors @ np.diag(np.maximum(values, 0.0)) @ vectors.T
        assert np.allclose(projected, nearest, atol=1e-12 * np.abs(exact).max())
        changed += bool(values[0] < -1e-9 * values[-1])
    assert changed > 0  # at least the inverted ones are indefinite


@every_law
def test_rest_is_free_of_stress_and_hookes_law_holds_near_it(law: Law) -> None:
    psi, P, C = evaluate(law, np.eye(3))
    lam, mu = law.lame
    scale = law.young_modulus
    assert abs(psi) < 1e-12 * scale
    assert np.abs(P).max() < 1e-12 * scale
    one = np.eye(3)
    hooke = lam * np.einsum("ij,kl->ijkl", one, one) + mu * (
        np.einsum("ik,jl->ijkl", one, one) + np.einsum("il,jk->ijkl", one, one)
    )
    assert np.allclose(C.reshape(3, 3, 3, 3), hooke, atol=1e-11 * (lam + mu))


@every_law
def test_frame_indifferent_and_isotropic(law: Law) -> None:
    Q = Rotation.from_rotvec([0.3, 1.2, -2.0]).as_matrix()
    for F in gradients(3):
        psi, P, _ = evaluate(law, F, NO_TANGENT)
        turned, PQ, _ = evaluate(law, Q @ F, NO_TANGENT)
        assert turned == pytest.approx(psi, rel=1e-11)
        assert np.allclose(PQ, Q @ P, atol=1e-10 * np.abs(P).max())
        assert np.allclose(evaluate(law, F @ Q)[1], P @ Q, atol=1e-10 * np.abs(P).max())


@every_law
def test_an_inverted_element_comes_back(law: Law) -> None:
    """From any flattened or mirrored state the energy falls on the way to the proper one."""
    heights = np.linspace(-0.9, 0.9, 37)
    energies = [evaluate(law, np.diag([1.0, 1.1, height]), NO_TANGENT)[0] for height in heights]
    assert np.all(np.diff(energies) < 0.0)
    assert np.isfinite(evaluate(law, np.zeros((3, 3)))[0])


@every_law
def test_parts_add_up(law: Law) -> None:
    shear, volume = law.parts()
    for F in gradients(4):
        for whole, one, two in zip(
            evaluate(law, F)[1:], evaluate(shear, F)[1:], evaluate(volume, F)[1:], strict=True
        ):
            assert np.allclose(whole, one + two, atol=1e-12 * np.abs(whole).max())
    assert shear.lame[0] == 0.0


def uniaxial(law: Law, stretch: float) -> float:
    """Engineering stress of a bar free at its sides."""

    def side(width: float) -> float:
        return float(evaluate(law, np.diag([stretch, width, width]), NO_TANGENT)[1][1, 1])

    width = brentq(side, 0.2, 2.0, xtol=1e-14)
    return float(evaluate(law, np.diag([stretch, width, width]), NO_TANGENT)[1][0, 0])


def biaxial(law: Law, stretch: float) -> float:
    """Engineering stress of a sheet free at its faces, stretched alike in both directions."""

    def face(height: float) -> float:
        return float(evaluate(law, np.diag([stretch, stretch, height]), NO_TANGENT)[1][2, 2])

    height = brentq(face, 0.01, 3.0, xtol=1e-14)
    return float(evaluate(law, np.diag([stretch, stretch, height]), NO_TANGENT)[1][0, 0])


C10, C01, C20, C30 = 1.7e4, 0.6e4, -200.0, 23.0
INCOMPRESSIBLE = 0.49999


def of_file(**settings: object) -> Law:
    """The law of a table `material` of a robot file."""
    fixed = {"poisson_ratio": INCOMPRESSIBLE, "density": 1000.0}
    return SolidMaterialSettings.model_validate(settings | fixed).elastic_law()


RUBBERS = [
    (neo_hookean(4.0 * C10 * (1.0 + INCOMPRESSIBLE), INCOMPRESSIBLE), (C10, 0.0, 0.0, 0.0)),
    (of_file(law="mooney-rivlin", c10=C10, c01=C01), (C10, 0.0, 0.0, C01)),
    (of_file(law="yeoh", c10=C10, c20=C20, c30=C30), (C10, C20, C30, 0.0)),
]


@pytest.mark.parametrize(("law", "constants"), RUBBERS, ids=lambda item: getattr(item, "name", ""))
@pytest.mark.parametrize("stretch", [0.7, 1.3, 2.0, 3.0])
def test_incompressible_solutions(law: Law, constants: tuple[float, ...], stretch: float) -> None:
    """Uniaxial, equibiaxial and simple shear of incompressible rubber (Rivlin 1948).

    Engineering stress 2 (λ − λ⁻²)(W₁ + W₂/λ) in a bar, 2 (λ − λ⁻⁵)(W₁ + λ² W₂) in a sheet, and the Cauchy
    stress 2 γ (W₁ + W₂) in shear, W₁ = ∂W/∂I₁ and W₂ = ∂W/∂I₂.
    """
    c10, c20, c30, c01 = constants

    def W1(I1: float) -> float:
        y = I1 - 3.0
        return c10 + 2.0 * c20 * y + 3.0 * c30 * y * y

    s = stretch
    bar = 2.0 * (s - s**-2) * (W1(s * s + 2.0 / s) + c01 / s)
    sheet = 2.0 * (s - s**-5) * (W1(2.0 * s * s + s**-4) + s * s * c01)
    assert uniaxial(law, s) == pytest.approx(bar, rel=2e-3)
    assert biaxial(law, s) == pytest.approx(sheet, rel=2e-3)
    gamma = s - 0.5
    F = np.eye(3)
    F[0, 1] = gamma
    cauchy = evaluate(law, F, NO_TANGENT)[1] @ F.T  # J = 1
    assert cauchy[0, 1] == pytest.approx(2.0 * gamma * (W1(3.0 + gamma**2) + c01), rel=1e-9)


def test_stable_neo_hookean_approaches_neo_hookean_shear() -> None:
    """In simple shear J = 1 and I₁ = 3 + γ²: σ₁₂ = μ̂ γ (1 − 1/(I₁ + 1))."""
    law = stable_neo_hookean(3e5, 0.45)
    mu = 4.0 / 3.0 * law.lame[1]
    F = np.eye(3)
    F[0, 1] = 0.8
    cauchy = evaluate(law, F, NO_TANGENT)[1] @ F.T
    assert cauchy[0, 1] == pytest.approx(mu * 0.8 * (1.0 - 1.0 / (4.0 + 0.64)), rel=1e-12)


def test_corotational_bar_is_linear() -> None:
    """P = E ε along a free bar, whatever the stretch: linear elasticity in its own frame."""
    law = corotational(1e5, 0.3)
    for stretch in (0.6, 1.5, 2.0):
        assert uniaxial(law, stretch) == pytest.approx(1e5 * (stretch - 1.0), rel=1e-9)


# Engineering stress [Pa] at engineering strains 0.5 and 1.0, interpolated in the tests `silicones` cites
MEASURED = {
    "ecoflex-00-30": (16890.0, 29720.0),
    "ecoflex-00-50": (22780.0, 40950.0),
    "dragon-skin-10": (53000.0, 112960.0),
    "dragon-skin-30": (213920.0, 437120.0),
}


@pytest.mark.parametrize("name", MEASURED)
def test_silicones_pull_as_measured(name: str) -> None:
    item = find_silicone(name)
    law = yeoh(item.c10, item.c20, 0.0, item.poisson_ratio)
    half, whole = MEASURED[name]
    assert uniaxial(law, 1.5) == pytest.approx(half, rel=0.04)
    assert uniaxial(law, 2.0) == pytest.approx(whole, rel=0.04)
    assert 1000.0 < item.density < 1100.0


def test_every_silicone_is_measured_and_documented() -> None:
    assert {item.name for item in SILICONES} == set(MEASURED)
    page = Path(__file__).parents[2] / "model/materials/silicones.py"
    assert "10.1089/soro.2019.0115" in page.read_text(encoding="utf-8")


BAD = {
    r"young_modulus is -1 Pa": lambda: corotational(-1.0, 0.3),
    r"poisson_ratio is 0\.5, allowed is 0 up to less than 0\.5": lambda: neo_hookean(1e5, 0.5),
    r"poisson_ratio is nan": lambda: neo_hookean(1e5, float("nan")),
    r"c10 is -1 Pa and c01 is 2 Pa": lambda: mooney_rivlin(-1.0, 2.0, 0.45),
    r"softens without limit": lambda: yeoh(1e4, -1e4, 0.0, 0.45),
    r"c10 10000, c20 -1000, c30 10 Pa": lambda: yeoh(1e4, -1e3, 10.0, 0.45),
    r"silicone is 'ecoflex', known are ecoflex-00-30, ": lambda: find_silicone("ecoflex"),
}


@pytest.mark.parametrize("message", BAD)
def test_constants_that_make_no_material(message: str) -> None:
    with pytest.raises(MaterialError, match=message):
        BAD[message]()
