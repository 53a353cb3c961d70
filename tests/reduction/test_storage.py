import zipfile
from pathlib import Path

import numpy as np
import pytest

from tauten.reduction import DamagedFile, storage

KIND = "test record"


@pytest.fixture
def stored(tmp_path: Path) -> Path:
    path = tmp_path / "folder" / "record.npz"
    noise = np.random.default_rng(0).random(3000)
    storage.write(path, KIND, {"name": "ξ", "k": 3}, {"noise": noise, "flags": noise > 0.5})
    return path


def test_round_trip(stored: Path) -> None:
    header, arrays = storage.read(stored, KIND)
    assert header == {"name": "ξ", "k": 3}
    noise = np.random.default_rng(0).random(3000)
    np.testing.assert_array_equal(arrays["noise"], noise)
    np.testing.assert_array_equal(arrays["flags"], noise > 0.5)


def test_same_content_gives_the_same_bytes(stored: Path, tmp_path: Path) -> None:
    header, arrays = storage.read(stored, KIND)
    storage.write(tmp_path / "again.npz", KIND, header, arrays)
    assert (tmp_path / "again.npz").read_bytes() == stored.read_bytes()


def test_failed_write_leaves_the_old_file_and_no_other(stored: Path) -> None:
    before = stored.read_bytes()
    with pytest.raises(TypeError):
        storage.write(stored, KIND, {"unserialisable": object()}, {})
    with pytest.raises(ValueError, match="Object arrays"):
        storage.write(stored, KIND, {}, {"objects": np.array([object()])})
    assert stored.read_bytes() == before
    assert list(stored.parent.iterdir()) == [stored]


def test_missing_file_is_not_called_damaged(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        storage.read(tmp_path / "none.npz", KIND)


def test_other_kind_is_named(stored: Path) -> None:
    with pytest.raises(DamagedFile, match=r"record.npz: this is a test record file, expected a x"):
        storage.read(stored, "x")


def test_pickled_content_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "evil.npz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("header.json", f'{{"kind": "{KIND}"}}')
        with archive.open("objects.npy", "w") as member:
            np.lib.format.write_array(member, np.array([object()]), allow_pickle=True)
    with pytest.raises(DamagedFile, match=r"evil\.npz.*allow_pickle"):
        storage.read(path, KIND)


def test_every_truncation_is_noticed(stored: Path) -> None:
    whole = stored.read_bytes()
    for length in (0, 1, 10, len(whole) // 2, len(whole) - 30, len(whole) - 1):
        stored.write_bytes(whole[:length])
        with pytest.raises(DamagedFile, match=r"record\.npz"):
            storage.read(stored, KIND)


def test_altered_bytes_are_noticed(stored: Path) -> None:
    """Wherever a byte changes, the content is either refused or still what was saved."""
    whole = stored.read_bytes()
    expected = np.random.default_rng(0).random(3000)
    refused = 0
    for position in range(0, len(whole), len(whole) // 200):
        stored.write_bytes(
            whole[:position] + bytes([whole[position] ^ 0xFF]) + whole[position + 1 :]
        )
        try:
            header, arrays = storage.read(stored, KIND)
        except DamagedFile:
            refused += 1
            continue
        assert header == {"name": "ξ", "k": 3}
        np.testing.assert_array_equal(arrays.get("noise", expected), expected)
    assert refused > 190
