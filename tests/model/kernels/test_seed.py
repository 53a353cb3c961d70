"""Kernels that are shipped: found first, unpacked safely, left out where they cannot be used."""

from __future__ import annotations

import io
import lzma
import os
import shutil
import sys
import tarfile
from collections.abc import Callable
from pathlib import Path

import pytest
from support.kernels.package import CALLEE, end, run, start, write

from tauten.model.kernels import seed
from tauten.model.kernels.files import with_digest
from tauten.model.kernels.seed import SEED, pack, unpack, unpacked

FILES = {"a.nbi": with_digest(b"index"), "a.1.nbc": with_digest(bytes(1000))}


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the kernels of a package were compiled; their names do not depend on where it is."""
    folder = tmp_path_factory.mktemp("package")
    write(folder)
    assert run(folder, folder / "first", **{SEED: "off"}) == (6.0, 0, 1)
    return folder / "first"


@pytest.fixture
def archive(tmp_path: Path, compiled: Path) -> Path:
    """The kernels of the package in `tmp_path`, packed from where they were compiled."""
    write(tmp_path)
    file = tmp_path / "seed.tar.xz"
    file.write_bytes(pack((path.name, path.read_bytes()) for path in compiled.rglob("*.nb?")))
    return file


def test_shipped_kernels_are_not_compiled(tmp_path: Path, archive: Path) -> None:
    cache = tmp_path / "second"
    assert run(tmp_path, cache, **{SEED: str(archive)}) == (6.0, 1, 0)
    assert not (cache / "tauten" / "kernels").exists(), "nothing was compiled"
    (folder,) = (cache / "tauten").glob("seed-*")
    assert {path.name for path in folder.iterdir()} == set(unpack(archive.read_bytes()))


@pytest.mark.long
def test_a_kernel_whose_sources_changed_is_compiled(tmp_path: Path, archive: Path) -> None:
    (tmp_path / "callee.py").write_text(CALLEE.replace("3.0 * x", "5.000 * x"))
    cache = tmp_path / "second"
    assert run(tmp_path, cache, **{SEED: str(archive)}) == (10.0, 0, 1)
    assert run(tmp_path, cache, **{SEED: str(archive)}) == (10.0, 1, 0)


def test_switched_off_nothing_shipped_is_used(tmp_path: Path, archive: Path) -> None:
    cache = tmp_path / "second"
    assert run(tmp_path, cache, **{SEED: "off"}) == (6.0, 0, 1)
    assert not list((cache / "tauten").glob("seed-*"))


@pytest.mark.long
def test_processes_that_start_together_unpack_one_folder(tmp_path: Path, archive: Path) -> None:
    cache = tmp_path / "second"
    several = [start(tmp_path, cache, f"{n}.txt", **{SEED: str(archive)}) for n in range(4)]
    assert [end(process) for process in several] == [(6.0, 1, 0)] * 4
    assert len(list((cache / "tauten").iterdir())) == 1, "one folder, nothing temporary"


def test_kernels_are_used_where_nothing_can_be_written(tmp_path: Path, archive: Path) -> None:
    """A file where the folder should be: root may write into any folder."""
    cache = tmp_path / "second"
    cache.touch()
    assert run(tmp_path, cache, **{SEED: str(archive)}) == (6.0, 1, 0)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such permissions")
def test_what_others_can_write_is_unpacked_into_memory(tmp_path: Path, archive: Path) -> None:
    cache = tmp_path / "second"
    run(tmp_path, cache, **{SEED: str(archive)})
    (folder,) = (cache / "tauten").glob("seed-*")
    for file in folder.iterdir():
        file.write_bytes(b"")
    folder.chmod(0o777)
    assert run(tmp_path, cache, **{SEED: str(archive)}) == (6.0, 1, 0)


@pytest.mark.long
@pytest.mark.parametrize(
    "damage",
    [
        lambda content: b"",
        lambda content: content[: len(content) // 2],
        lambda content: bytes(len(content)),
        lambda content: content[:200] + bytes(50) + content[250:],
        lambda content: b"version https://git-lfs.github.com/spec/v1\n",
        lambda content: lzma.compress(b"no archive" * 100),
    ],
)
def test_a_damaged_file_is_left_out_in_one_sentence(
    tmp_path: Path, archive: Path, compiled: Path, damage: Callable[[bytes], bytes]
) -> None:
    shutil.copytree(compiled, tmp_path / "first")
    archive.write_bytes(damage(archive.read_bytes()))
    process = start(tmp_path, tmp_path / "first", **{SEED: str(archive)})
    assert end(process) == (6.0, 1, 0), "from the user's own kernels"
    said = process.output.read_text()
    assert said.count("is not used, its kernels are compiled instead") == 1, said
    assert "Traceback" not in said


def test_one_damaged_entry_is_compiled(tmp_path: Path, archive: Path) -> None:
    files = unpack(archive.read_bytes())
    (code,) = (name for name in files if "outer" in name and name.endswith(".nbc"))
    files[code] = files[code][:-40] + bytes(40)
    archive.write_bytes(pack(files.items()))
    assert run(tmp_path, tmp_path / "second", **{SEED: str(archive)}) == (6.0, 0, 1)


def test_an_archive_has_plain_files_only(tmp_path: Path) -> None:
    assert unpack(pack(FILES.items())) == FILES
    for name, kind in (
        ("../a.nbi", tarfile.REGTYPE),
        ("a", tarfile.DIRTYPE),
        ("b", tarfile.SYMTYPE),
    ):
        buffer = io.BytesIO()
        with tarfile.open(fileobj=buffer, mode="w") as tar:
            entry = tarfile.TarInfo(name)
            entry.type, entry.linkname = kind, "/etc/passwd"
            tar.addfile(entry)
        with pytest.raises(ValueError, match=r"no file of kernels|damaged"):
            unpack(lzma.compress(buffer.getvalue()))


def test_equal_files_give_equal_archives() -> None:
    assert pack(FILES.items()) == pack(reversed(FILES.items()))


def test_a_folder_is_there_whole_or_not_at_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(path: Path, mode: int) -> None:
        raise OSError("no space left on device")

    content = pack(FILES.items())
    with monkeypatch.context() as patch:
        patch.setattr(Path, "chmod", fails)
        found = unpacked(content, tmp_path)
        assert found.folder is None and found.names() == set(FILES)
        assert found.read("a.nbi") == b"index"
        assert not list(tmp_path.iterdir())
    found = unpacked(content, tmp_path)
    assert found.folder is not None and found.names() == set(FILES)
    assert found.read("a.nbi") == b"index"
    with pytest.raises(OSError, match="b"):
        found.read("b.nbi")


def test_what_was_unpacked_long_ago_is_removed(tmp_path: Path) -> None:
    for name, age in (("seed-old", 40), ("seed-new", 1)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "a.nbi").touch()
        then = (tmp_path / name).stat().st_mtime - age * 86_400.0
        os.utime(tmp_path / name, (then, then))
    found = unpacked(pack(FILES.items()), tmp_path)
    assert found.folder is not None
    assert {path.name for path in tmp_path.iterdir()} == {"seed-new", found.folder.name}


def test_a_file_is_for_one_python_numba_and_system() -> None:
    name = seed.seed_name()
    assert name.startswith(f"py{sys.version_info[0]}{sys.version_info[1]}-numba")
    assert name.endswith(seed.SUFFIX)
