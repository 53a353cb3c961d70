"""Damaged and edited files: each is loaded, checked and usable, or refused in one sentence."""

from __future__ import annotations

import dataclasses
import io
import json
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tauten.model import Robot
from tauten.model.numerics import Array
from tauten.model.tetra import NodalBody
from tauten.reduction.campaign import Origin, SnapshotError, Snapshots
from tauten.reduction.contact import BasisError, ContactBasis
from tauten.reduction.state import StateBasis, StateBasisError

VALUES: tuple[Any, ...] = (
    None, True, -1, 0, 3, 2**70, 1e300, float("nan"), float("inf"), "", "x", [], [1], {}, {"a": 1},
)  # fmt: skip
SHORT, LONG = 60, 3000


def flipped(content: bytes, rng: np.random.Generator) -> bytes:
    """Some bits turned over."""
    data = bytearray(content)
    for position in rng.integers(0, len(data), rng.integers(1, 5)):
        data[position] ^= 1 << int(rng.integers(0, 8))
    return bytes(data)


def cut(content: bytes, rng: np.random.Generator) -> bytes:
    """The end missing, or a piece of the middle."""
    first, second = sorted(rng.integers(0, len(content), 2).tolist())
    return content[:first] + (content[second:] if rng.random() < 0.5 else b"")


def edited(content: bytes, rng: np.random.Generator) -> bytes:
    """Header entries or arrays replaced in an archive that is whole, the digest removed."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    header = json.loads(members["header.json"])
    header.pop("digest")
    name = str(rng.choice(sorted(members)))
    if name == "header.json":
        entries = header.get("origin", header.get("provenance"))
        place = entries if rng.random() < 0.8 else header
        place[str(rng.choice(sorted(place)))] = VALUES[rng.integers(0, len(VALUES))]
    else:
        array = np.load(io.BytesIO(members[name]))
        stream = io.BytesIO()
        np.save(stream, strange(array, rng))
        members[name] = stream.getvalue()
    members["header.json"] = json.dumps(header).encode()
    if rng.random() < 0.1:
        members.pop(name)
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for member, data in members.items():
            archive.writestr(member, data)
    return out.getvalue()


def strange(array: Array, rng: np.random.Generator) -> Array:
    """Another shape, another type, or entries that do not belong there."""
    match rng.integers(0, 8):
        case 0:
            return array[: len(array) // 2]
        case 1:
            return array.astype(rng.choice(["c16", "f4", "i8", "u1", "S3", "?", "f8"]))
        case 2:
            return array.reshape(*array.shape, 1)
        case 3:
            return array[0]
        case 4:
            return np.zeros_like(array)
        case 5:
            return array[::-1].copy()
        case 6:
            return np.concatenate([array, array])
    changed = array.copy()
    place = tuple(rng.integers(0, size) for size in array.shape)
    with np.errstate(all="ignore"):
        changed[place] = rng.choice(
            [-1.0, 1e300, 7.0] if array.dtype.kind == "f" else [-1, 9, 10**9]
        )
    return changed


def use_contact(path: Path, thumb: Robot[NodalBody]) -> None:
    basis = ContactBasis.load(path)
    basis.check_robot(thumb)
    assert np.isfinite(basis.lift(np.ones(basis.k))).all()


def use_states(path: Path, thumb: Robot[NodalBody]) -> None:
    states = StateBasis.load(path)
    states.check_robot(thumb)
    states.check_tip(1e-3)
    assert states.origin.tip_max <= 1e-3
    assert states.elements.max() < thumb.body.n_elements


def use_snapshots(path: Path, thumb: Robot[NodalBody]) -> None:
    found = Snapshots.load(path)
    assert all(np.isfinite(column).all() for column in (found.q, found.position, found.gravity))
    assert len(found.select(found.converged)) <= len(found)


Use = Callable[[Path, Robot[NodalBody]], None]
USES: dict[str, tuple[Use, type[ValueError]]] = {
    "basis": (use_contact, BasisError),
    "states": (use_states, StateBasisError),
    "snapshots": (use_snapshots, SnapshotError),
}


@pytest.fixture(scope="module")
def whole(thumb: Robot[NodalBody], tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """A file of each kind that belongs to the thumb, by its suffix."""
    folder, rng = tmp_path_factory.mktemp("whole"), np.random.default_rng(0)
    contact, states = ContactBasis.load("finger"), StateBasis.load("finger")
    Psi = rng.random((thumb.n_c, 4))
    provenance = dataclasses.replace(contact.provenance, k=4, robot_digest=thumb.digest)
    weight = np.sqrt(3.0 * thumb.body.tetrahedra.mass / thumb.body.tetrahedra.mass.sum())  # (n,)
    Phi = np.linalg.qr(rng.normal(size=(thumb.n, 5)))[0] / weight[:, None]
    every = np.arange(0, thumb.body.n_elements, 3)
    weights = np.full(len(every), thumb.body.mesh.volumes.sum())
    weights /= thumb.body.mesh.volumes[every].sum()
    origin = dataclasses.replace(
        states.origin, r=5, sample=len(every), robot_digest=thumb.digest, tip_max=2e-4
    )
    s = 4
    snapshots = Snapshots(
        lam=rng.random((thumb.n_c, s)),
        position=rng.random((thumb.n_a, s)),
        effort=rng.random((thumb.n_a, s)),
        effector=rng.random((thumb.layout.n_e, s)),
        gravity=rng.random((3, s)),
        effector_force=rng.random((thumb.layout.n_e, s)),
        pressed=rng.random((3, s)),
        run=np.array([0, 0, 1, 1]),
        converged=np.ones(s, dtype=bool),
        q=rng.random((thumb.n, s)),
        origin=Origin("thumb", thumb.digest, "fuzz", states.origin.versions),
    )
    paths = (
        ContactBasis(Psi / np.linalg.norm(Psi, axis=0), provenance).save(folder / "thumb.basis"),
        StateBasis(Phi, every, weights, origin).save(folder / "thumb.states"),
        snapshots.save(folder / "thumb.snapshots"),
    )
    return {path.suffix.removeprefix("."): path.read_bytes() for path in paths}


@pytest.mark.parametrize("suffix", USES)
def test_whole_file_is_used(
    suffix: str, whole: dict[str, bytes], thumb: Robot[NodalBody], tmp_path: Path
) -> None:
    path = tmp_path / f"thumb.{suffix}"
    path.write_bytes(whole[suffix])
    USES[suffix][0](path, thumb)


@pytest.mark.parametrize("rounds", [SHORT, pytest.param(LONG, marks=pytest.mark.slow)])
@pytest.mark.parametrize("damage", [flipped, cut, edited])
@pytest.mark.parametrize("suffix", USES)
def test_damage_ends_in_an_object_or_in_one_sentence(
    suffix: str,
    damage: Callable[[bytes, np.random.Generator], bytes],
    rounds: int,
    whole: dict[str, bytes],
    thumb: Robot[NodalBody],
    tmp_path: Path,
) -> None:
    use, refusal = USES[suffix]
    path = tmp_path / f"thumb.{suffix}"
    refused = 0
    for seed in range(rounds):
        path.write_bytes(damage(whole[suffix], np.random.default_rng(seed)))
        try:
            use(path, thumb)
        except refusal as error:
            refused += 1
            assert "\n" not in str(error) and len(str(error)) < 1000, seed
    assert refused > rounds // 3
