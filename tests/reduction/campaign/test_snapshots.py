import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tauten.reduction.campaign import Origin, SnapshotError, Snapshots, join_snapshots

ORIGIN = Origin("thumb", "ab" * 32, "ramp", (("python", "3.11"), ("numpy", "2.0")))


def some(s: int, run: int = 0) -> Snapshots:
    rng = np.random.default_rng(run)
    return Snapshots(
        lam=rng.random((6, s)),
        position=rng.random((2, s)),
        effort=rng.random((2, s)),
        effector=rng.random((3, s)),
        gravity=np.tile([[0.0], [0.0], [-9.81]], s),
        effector_force=np.zeros((3, s)),
        pressed=rng.random((6, s)),
        run=np.full(s, run),
        converged=rng.random(s) > 0.3,
        q=np.zeros((0, s)),
        origin=ORIGIN,
    )


def test_round_trip(tmp_path: Path) -> None:
    one = some(7)
    again = Snapshots.load(one.save(tmp_path / "run.snapshots"))
    assert again.origin == one.origin
    for field in dataclasses.fields(one):
        if field.name != "origin":
            np.testing.assert_array_equal(getattr(again, field.name), getattr(one, field.name))
            assert getattr(again, field.name).dtype == getattr(one, field.name).dtype


def test_join_keeps_order_and_select_takes_it_apart() -> None:
    whole = join_snapshots([some(3, run=0), some(4, run=1)])
    assert len(whole) == 7
    np.testing.assert_array_equal(whole.run, [0, 0, 0, 1, 1, 1, 1])
    np.testing.assert_array_equal(whole.select(whole.run == 1).lam, some(4, run=1).lam)
    np.testing.assert_array_equal(
        whole.select(np.array([5])).position, some(4, run=1).position[:, 2:3]
    )


def test_digest_is_of_the_forces_not_of_their_memory_layout() -> None:
    one = some(5)
    turned = dataclasses.replace(one, lam=np.asfortranarray(one.lam))
    assert turned.digest() == one.digest() != some(5, run=1).digest()


def test_different_origins_do_not_mix() -> None:
    other = dataclasses.replace(some(3), origin=dataclasses.replace(ORIGIN, robot="octopus"))
    with pytest.raises(SnapshotError, match="different origin"):
        join_snapshots([some(3), other])
    with pytest.raises(SnapshotError, match="no snapshots to join"):
        join_snapshots([])


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"robot": "octopus"}, "of robot 'octopus', this one is 'thumb'"),
        ({"robot_digest": "2"}, "made before the model in the robot file or its mesh was changed"),
        ({"campaign": "other"}, "other, this one is ramp"),
        ({"versions": (("numpy", "1"), ("scipy", "4"))}, "made with numpy 1, now 3"),
    ],
)
def test_what_differs_is_said_in_a_few_words(changed: dict[str, Any], said: str) -> None:
    mine = Origin("thumb", "1", "ramp", (("numpy", "3"), ("scipy", "4")))
    assert dataclasses.replace(mine, **changed).difference(mine) == said


def test_columns_must_agree() -> None:
    with pytest.raises(SnapshotError, match="different numbers of columns: lam 5, position 4"):
        dataclasses.replace(some(5), position=np.zeros((2, 4)))


def test_damaged_file(tmp_path: Path) -> None:
    path = some(7).save(tmp_path / "run.snapshots")
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(SnapshotError, match=r"run\.snapshots: this is no readable"):
        Snapshots.load(path)
    with pytest.raises(SnapshotError, match=r"run\.npz: a snapshot file ends in \.snapshots"):
        some(7).save(tmp_path / "run.npz")
