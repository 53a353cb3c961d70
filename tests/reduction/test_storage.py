import gc
import os
import stat
import sys
import threading
import tracemalloc
import zipfile
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
import pytest

from tauten.reduction import DamagedFile, storage, write_text

KIND = "test record"
ARRAYS = {"noise": "f", "flags": "b"}


@pytest.fixture
def stored(tmp_path: Path) -> Path:
    path = tmp_path / "folder" / "record.npz"
    noise = np.random.default_rng(0).random(3000)
    storage.write(path, KIND, {"name": "ξ", "k": 3}, {"noise": noise, "flags": noise > 0.5})
    return path


def test_round_trip(stored: Path) -> None:
    header, arrays = storage.read(stored, KIND, ARRAYS)
    assert header == {"name": "ξ", "k": 3}
    noise = np.random.default_rng(0).random(3000)
    np.testing.assert_array_equal(arrays["noise"], noise)
    np.testing.assert_array_equal(arrays["flags"], noise > 0.5)


def test_same_content_gives_the_same_bytes(stored: Path, tmp_path: Path) -> None:
    header, arrays = storage.read(stored, KIND, ARRAYS)
    storage.write(tmp_path / "again.npz", KIND, header, arrays)
    assert (tmp_path / "again.npz").read_bytes() == stored.read_bytes()


@pytest.mark.skipif(sys.platform == "win32", reason="has no such permissions")
def test_a_file_that_is_replaced_keeps_its_permissions(tmp_path: Path) -> None:
    """A new one has those that the umask leaves."""
    before = os.umask(0o027)
    try:
        for mode in (0o600, 0o644):
            path = tmp_path / f"{mode:o}.toml"
            path.touch()
            path.chmod(mode)
            write_text(path, "new")
            assert path.read_text() == "new"
            assert stat.S_IMODE(path.stat().st_mode) == mode
        write_text(tmp_path / "new.toml", "new")
        assert stat.S_IMODE((tmp_path / "new.toml").stat().st_mode) == 0o640
    finally:
        os.umask(before)


def test_failed_write_leaves_the_old_file_and_no_other(stored: Path) -> None:
    before = stored.read_bytes()
    with pytest.raises(TypeError):
        storage.write(stored, KIND, {"unserialisable": object()}, {})
    with pytest.raises(ValueError, match="Object arrays"):
        storage.write(stored, KIND, {}, {"objects": np.array([object()])})
    assert stored.read_bytes() == before
    assert list(stored.parent.iterdir()) == [stored]


def interrupted(line: int, files: set[str], action: Callable[[], None]) -> int:
    """Do something with Ctrl-C at a line of some files; returns how many of their lines were run."""
    seen = 0

    def trace(frame: FrameType, event: str, _: object) -> Any:
        nonlocal seen
        if frame.f_code.co_filename not in files:
            return None
        if event == "line":
            seen += 1
            if seen == line:
                sys.settrace(None)
                raise KeyboardInterrupt
        return trace

    before = sys.gettrace()
    gc.disable()  # the end of an archive that was interrupted earlier has lines too
    sys.settrace(trace)
    try:
        action()
    finally:
        sys.settrace(before)
        gc.enable()
    return seen


def interrupted_write(path: Path, line: int) -> int:
    """Write a file with Ctrl-C at a line of `storage` or `zipfile`; returns how many were run."""
    contents = {"noise": np.zeros(2)}
    return interrupted(
        line,
        {storage.__file__, zipfile.__file__},
        lambda: storage.write(path, KIND, {}, contents),
    )


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # of ZipFile.__del__
def test_ctrl_c_at_any_line_of_a_write_is_ctrl_c(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`zipfile` makes a ValueError of it while it opens a member: commands would end with exit code 1."""
    monkeypatch.setattr(os, "fsync", lambda _: None)  # for the sake of time
    path = tmp_path / "record.npz"
    lines = interrupted_write(path, 0)
    assert lines > 300
    for line in range(1, lines - 10):  # the last ones clean up: what is raised there is ignored
        path.unlink(missing_ok=True)
        with pytest.raises(KeyboardInterrupt):
            interrupted_write(path, line)
        assert not list(tmp_path.iterdir()) or storage.read(path, KIND, {"noise": "f"})
    gc.collect()  # archives that were interrupted: what they say belongs to this test


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # of a file
@pytest.mark.filterwarnings("ignore::ResourceWarning")  # that was just open
def test_ctrl_c_at_any_line_leaves_no_other_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From the first line to the last: the old text or the new one, and nothing beside it."""
    monkeypatch.setattr(os, "fsync", lambda _: None)
    path, files = tmp_path / "text.txt", {sys.modules[write_text.__module__].__file__ or ""}
    write_text(path, "old")
    lines = interrupted(0, files, lambda: write_text(path, "new"))
    assert lines > 10
    for line in range(1, lines + 1):
        write_text(path, "old")
        with pytest.raises(KeyboardInterrupt):
            interrupted(line, files, lambda: write_text(path, "new"))
        assert list(tmp_path.iterdir()) == [path]
        assert path.read_text() in ("old", "new")
    gc.collect()


def test_missing_file_is_not_called_damaged(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        storage.read(tmp_path / "none.npz", KIND, ARRAYS)


def test_other_kind_is_named(stored: Path) -> None:
    with pytest.raises(DamagedFile, match=r"record.npz: this is a test record file, expected a x"):
        storage.read(stored, "x", ARRAYS)


def test_pickled_content_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "evil.npz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("header.json", f'{{"kind": "{KIND}"}}')
        with archive.open("objects.npy", "w") as member:
            np.lib.format.write_array(member, np.array([object()]), allow_pickle=True)
    with pytest.raises(DamagedFile, match=r"evil\.npz.*data type object"):
        storage.read(path, KIND, {"objects": "f"})


def test_every_truncation_is_noticed(stored: Path) -> None:
    whole = stored.read_bytes()
    for length in (0, 1, 10, len(whole) // 2, len(whole) - 30, len(whole) - 1):
        stored.write_bytes(whole[:length])
        with pytest.raises(DamagedFile, match=r"record\.npz"):
            storage.read(stored, KIND, ARRAYS)


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
            header, arrays = storage.read(stored, KIND, ARRAYS)
        except DamagedFile:
            refused += 1
            continue
        assert header == {"name": "ξ", "k": 3}
        np.testing.assert_array_equal(arrays.get("noise", expected), expected)
    assert refused > 190


@pytest.mark.long
def test_bomb_is_refused_before_it_is_decompressed(tmp_path: Path) -> None:
    """A file of 0.1 MB that holds 80 MB of zeros, as entry or as an array's header claims."""
    path = tmp_path / "bomb.npz"
    storage.write(path, KIND, {}, {"noise": np.zeros(10_000_000)})
    tracemalloc.start()
    with pytest.raises(DamagedFile, match=r"bomb\.npz.*decompress to 80000\d+ bytes, allowed are"):
        storage.read(path, KIND, {"noise": "f"})
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("header.json", f'{{"kind": "{KIND}"}}')
        with archive.open("noise.npy", "w") as member:
            layout = {"descr": "<f8", "fortran_order": False, "shape": (10_000_000,)}
            np.lib.format.write_array_header_1_0(member, layout)
    with pytest.raises(DamagedFile, match=r"noise\.npy has the shape \(10000000,\) .* but 0 bytes"):
        storage.read(path, KIND, {"noise": "f"})
    assert tracemalloc.get_traced_memory()[1] < 10e6
    tracemalloc.stop()


def test_changed_content_does_not_match_the_digest(stored: Path) -> None:
    _, arrays = storage.read(stored, KIND, ARRAYS)
    with zipfile.ZipFile(stored) as archive:
        text = archive.read("header.json").decode()
    for changed_text, noise in (
        (text, arrays["noise"] + 1e-12),
        (text.replace('"k": 3', '"k": 4'), arrays["noise"]),
    ):
        with zipfile.ZipFile(stored, "w") as archive:
            archive.writestr("header.json", changed_text)
            for name, array in {**arrays, "noise": noise}.items():
                with archive.open(f"{name}.npy", "w") as member:
                    np.lib.format.write_array(member, array)
        with pytest.raises(DamagedFile, match="digest does not match"):
            storage.read(stored, KIND, ARRAYS)


def test_file_without_a_digest_is_read(tmp_path: Path) -> None:
    """Files of earlier versions have none."""
    path = tmp_path / "old.npz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("header.json", f'{{"kind": "{KIND}", "k": 3}}')
        with archive.open("noise.npy", "w") as member:
            np.lib.format.write_array(member, np.ones(3))
    assert storage.read(path, KIND, {"noise": "f"})[0] == {"k": 3}


def test_other_arrays_than_expected_are_named(stored: Path) -> None:
    with pytest.raises(DamagedFile, match="holds the arrays flags, noise, expected noise"):
        storage.read(stored, KIND, {"noise": "f"})
    with pytest.raises(DamagedFile, match=r"flags\.npy has the data type bool"):
        storage.read(stored, KIND, {"noise": "f", "flags": "i"})


def test_text_is_written_whole(tmp_path: Path) -> None:
    path = tmp_path / "folder" / "text.txt"
    write_text(path, "Ψ\n")
    assert path.read_bytes() == "Ψ\n".encode()
    with pytest.raises(UnicodeEncodeError):
        write_text(path, "\ud800")
    assert list(path.parent.iterdir()) == [path]
    assert path.read_text(encoding="utf-8") == "Ψ\n"


def test_a_link_remains_one(tmp_path: Path) -> None:
    """As a robot file elsewhere: the link was replaced."""
    (tmp_path / "here").mkdir()
    (tmp_path / "there").mkdir()
    link, file = tmp_path / "here" / "robot.toml", tmp_path / "there" / "robot.toml"
    link.symlink_to("../there/robot.toml")
    for text in ("new\n", "newer\n"):  # the file is missing at first
        write_text(link, text)
        assert link.is_symlink() and file.read_text() == text
        assert list(link.parent.iterdir()) == [link] and list(file.parent.iterdir()) == [file]


def test_links_to_each_other_are_replaced(tmp_path: Path) -> None:
    """Before Python 3.13 the error was that of a program, which no command says in a sentence."""
    first, second = tmp_path / "first", tmp_path / "second"
    first.symlink_to(second)
    second.symlink_to(first)
    write_text(first, "new\n")
    assert first.read_text() == second.read_text() == "new\n"


@pytest.mark.skipif(sys.platform == "win32", reason="has no such file")
def test_what_was_printed_into_the_same_file_remains(capfd: pytest.CaptureFixture[str]) -> None:
    """The shell leads /dev/stdout into a file, with >> into one that had something: that was lost."""
    os.write(1, b"before\n")  # pytest has led it into a file, too
    write_text(Path("/dev/stdout"), "written\n")
    os.write(1, b"after\n")
    assert capfd.readouterr().out == "before\nwritten\nafter\n"


@pytest.mark.skipif(sys.platform == "win32", reason="has no pipes of a name")
def test_a_pipe_remains_one(tmp_path: Path) -> None:
    """So does /dev/null, which the administrator could replace."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    read = list[bytes]()
    reader = threading.Thread(target=lambda: read.append(pipe.read_bytes()))
    reader.start()
    write_text(pipe, "{}\n")
    reader.join(10.0)
    assert read == [b"{}\n"]
    assert pipe.is_fifo()
    assert list(tmp_path.iterdir()) == [pipe]
