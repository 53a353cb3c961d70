"""Machine code on disk follows the sources: a package of two kernel files, run in processes of its own."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from support.kernels.package import CALLEE, end, run, start, write

from tauten.model.kernels.cache import KernelCacheFile, remove_unused
from tauten.model.kernels.files import cache_folder, written_by_others


@pytest.mark.long
def test_changed_callee_is_compiled_into_its_caller(tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    write(tmp_path)
    assert run(tmp_path, cache) == (6.0, 0, 1)
    text = CALLEE
    for old, new, value in (
        ("3.0 * x", "5.0 * x", 10.0),  # the called kernel
        ("SHARE = 2.0", "SHARE = 7.0", 35.0),  # an imported constant
        ("first: float\n    second: float", "second: float\n    first: float", 35.0),
    ):
        text = text.replace(old, new)
        (tmp_path / "callee.py").write_text(text)
        assert run(tmp_path, cache) == (value, 0, 1), new
    assert run(tmp_path, cache) == (35.0, 1, 0), "unchanged sources are not compiled again"


@pytest.mark.long
def test_a_second_clone_compiles_what_differs(tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    clones = [tmp_path / "first", tmp_path / "second"]
    for clone in clones:
        clone.mkdir()
        write(clone)
    assert run(clones[0], cache) == (6.0, 0, 1)
    assert run(clones[1], cache) == (6.0, 1, 0)
    (clones[1] / "callee.py").write_text(CALLEE.replace("3.0 * x", "5.000 * x"))
    assert run(clones[1], cache) == (10.0, 0, 1)
    assert run(clones[0], cache) == (6.0, 1, 0), "entries of both clones are kept"


@pytest.mark.long
def test_a_renamed_module_of_a_callee_is_compiled_again(tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    write(tmp_path)
    assert run(tmp_path, cache) == (6.0, 0, 1)
    for name in ("caller", "main"):
        file = tmp_path / f"{name}.py"
        file.write_text(file.read_text().replace("from callee", "from renamed"))
    (tmp_path / "callee.py").rename(tmp_path / "renamed.py")
    assert run(tmp_path, cache) == (6.0, 0, 1)


@pytest.mark.long
def test_processes_that_start_together_compile_once(tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    write(tmp_path)
    together = [start(tmp_path, cache, f"{number}.txt") for number in range(3)]
    assert sum(end(process)[2] for process in together) == 1


@pytest.mark.long
def test_damaged_files_are_compiled_again(tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    write(tmp_path)
    run(tmp_path, cache)
    for file in cache.rglob("*.nbc"):
        file.write_bytes(b"")
    assert run(tmp_path, cache) == (6.0, 0, 1)
    assert run(tmp_path, cache) == (6.0, 1, 0)


DAMAGES: list[Callable[[bytes], bytes]] = [
    lambda content: b"",
    lambda content: bytes(len(content)),
    lambda content: content[: len(content) // 2],
    lambda content: content[:-1],
    lambda content: content[:100] + bytes(20) + content[120:],
    lambda content: content + b"more",
    lambda content: bytes(reversed(content)),
]


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize("kind", ["*.nbc", "*.nbi"])
def test_no_damaged_entry_is_read(
    tmp_path: Path, kind: str, damage: Callable[[bytes], bytes]
) -> None:
    file = KernelCacheFile(str(tmp_path), "kernel", "stamp")
    file.save("signature", list(range(1000)))
    assert file.load("signature") == list(range(1000))
    path = next(tmp_path.glob(kind))
    path.write_bytes(damage(path.read_bytes()))
    assert file.load("signature") is None
    file.save("signature", "again")
    assert file.load("signature") == "again"


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such permissions")
@pytest.mark.parametrize("mode", [0o775, 0o757, 0o777])
@pytest.mark.parametrize("what", ["folder", "file"])
def test_what_others_can_write_is_not_read(tmp_path: Path, mode: int, what: str) -> None:
    file = KernelCacheFile(str(tmp_path), "kernel", "stamp")
    file.save("signature", [1])
    for path in [tmp_path] if what == "folder" else list(tmp_path.iterdir()):
        path.chmod(mode)
    assert file.load("signature") is None
    if what == "file":
        file.save("signature", [2])  # in files of its own
        assert file.load("signature") == [2]
    else:
        with pytest.raises(OSError, match="others can write it"):
            file.save("signature", [2])


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such permissions")
def test_what_belongs_to_others_is_not_read() -> None:
    own = Path(__file__).stat()
    assert not written_by_others(own)
    assert written_by_others(os.stat_result([*own[:4], os.geteuid() + 1, *own[5:]]))


@pytest.mark.long
def test_kernels_run_where_others_can_write(tmp_path: Path) -> None:
    folder = tmp_path / "cache" / "tauten" / "kernels"
    folder.mkdir(parents=True)
    folder.chmod(0o777)
    write(tmp_path)
    process = start(tmp_path, tmp_path / "cache")
    assert end(process) == (6.0, 0, 1)
    output = process.output.read_text()
    assert "which other users can write" in output and f"chmod -R go-w {folder}" in output
    assert not list(folder.iterdir())


@pytest.mark.long
def test_kernels_run_where_nothing_can_be_written(tmp_path: Path) -> None:
    """A file where the folder should be: root may write into any folder."""
    cache = tmp_path / "cache"
    cache.touch()
    write(tmp_path)
    process = start(tmp_path, cache)
    assert end(process) == (6.0, 0, 1)
    output = process.output.read_text()
    assert output.count("compiled kernels cannot be kept") == 1
    assert "set NUMBA_CACHE_DIR" in output


@pytest.mark.skipif(sys.platform != "linux", reason="the variable is of Linux")
def test_an_empty_variable_is_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With an empty XDG_CACHE_HOME kernels were kept in the folder in which the command ran."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", "")
    monkeypatch.setenv("XDG_CACHE_HOME", "")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert cache_folder() == tmp_path / ".cache" / "tauten"


def test_what_was_not_used_for_longest_is_removed(tmp_path: Path) -> None:
    for number in range(6):
        file = tmp_path / f"kernel-{number}.nbc"
        file.write_bytes(bytes(100))
        os.utime(file, (1000 * number, 1000 * number))
    remove_unused(tmp_path, 600)
    assert len(list(tmp_path.iterdir())) == 6, "not larger than permitted"
    remove_unused(tmp_path, 599)
    assert {file.name for file in tmp_path.iterdir()} == {"kernel-4.nbc", "kernel-5.nbc"}


@pytest.mark.long
def test_a_kernel_in_use_counts_as_new(tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    write(tmp_path)
    run(tmp_path, cache)
    code = next(cache.rglob("*outer*.nbc"))
    old = code.stat().st_mtime - 1e6
    for file in cache.rglob("*.nb?"):
        os.utime(file, (old, old))
    run(tmp_path, cache)
    assert code.stat().st_mtime > old + 0.5e6
