"""Shipped kernels: packed from what a program used, served elsewhere, counted; why none is, in a sentence."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.kernels import (
    LARGEST,
    SEEDED,
    FirstHour,
    PackError,
    first_demos,
    pack,
    pack_kernels,
)
from benchmarks.kernels.archive import gather
from benchmarks.tables import first_hour_page
from tauten.model.kernels import OFF, SEED, SHIPPED, portable_machine, seed_name
from tauten.model.kernels.seed import unpack, unpacked
from tauten.model.numerics import Array, Ints, kernel
from tauten.model.parts.motion import _add_rows
from tauten.service.cli import main
from tauten.service.kernels import take_inventory, waiting, why_none
from tauten.service.process import host_info

ONE = (
    "from tauten.model.numerics import dot; print(dot((1.0, 2.0, 3.0), (1.0, 2.0, 3.0)), dot.stats)"
)
# one that no other kernel calls, whose shipped code is for calls from Python only; and a kernel that calls it
ALONE = """
import numpy as np
from tauten.model.numerics import kernel
from tauten.model.parts.motion import _add_rows
H = np.zeros((2, 3))
_add_rows(np.full((1, 2), 7.0), np.array([1]), 1, H)
print(H.tolist(), _add_rows.stats.cache_misses)
"""
CALLER = """
@kernel
def caller(block, rows, first, H):
    _add_rows(block, rows, first, H)
caller(np.full((1, 2), 7.0), np.array([1]), 1, H)
print(H.tolist())
"""
portable = pytest.mark.skipif(portable_machine() is None, reason="needs x86-64-v3")


def silent(share: float, what: str = "") -> None:
    """Show nothing."""


@pytest.fixture(scope="module")
def packed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What two programs need that call one kernel each."""
    file = tmp_path_factory.mktemp("packed") / "new" / "kernels.tar.xz"
    with pytest.MonkeyPatch.context() as patch:
        work = {"one kernel": ["-c", ONE], "another": ["-c", ALONE]}
        patch.setattr(pack, "workload", lambda folder: work)
        found = pack_kernels(file, silent)
    assert (found.file, found.entries, found.size) == (file, 2, file.stat().st_size)
    return file


def run(code: str, **variables: str) -> str:
    """What a new process prints."""
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.long
@portable
def test_what_was_packed_serves_an_empty_cache(tmp_path: Path, packed: Path) -> None:
    said = run(ONE, NUMBA_CACHE_DIR=str(tmp_path), **{SEED: str(packed)})
    assert said.startswith("14.0") and "cache_misses={}" in said.replace("Counter()", "{}")
    assert not (tmp_path / "tauten" / "kernels").exists()


@pytest.mark.long
@portable
def test_a_kernel_that_no_other_calls_is_shipped_for_calls_from_python(
    tmp_path: Path, packed: Path
) -> None:
    """LLVM's representation of kernels takes three quarters of the file; only callers need it."""
    here = {"NUMBA_CACHE_DIR": str(tmp_path), SEED: str(packed)}
    used = "[[0.0, 0.0, 0.0], [0.0, 7.0, 7.0]]"
    refused = CALLER.replace("caller(np", "try: caller(np").replace(
        "print", "except Exception as e: print(e)\nprint"
    )
    alone, _, after = run(ALONE + refused, **here).replace("Counter()", "{}").partition("\n")
    assert alone == f"{used} {{}}"
    assert f"set {SEED}={OFF}" in after
    assert "[0.0, 14.0, 14.0]" in run(ALONE + CALLER, **{**here, SEED: OFF})


@pytest.mark.long
@portable
def test_packing_again_needs_no_compilation(
    tmp_path: Path, packed: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From the file that is there, though the user's own folder is empty."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setenv(SEED, str(packed))
    done = "assert not dot.stats.cache_misses, dot.stats"
    monkeypatch.setattr(pack, "workload", lambda work: {"one": ["-c", f"{ONE}; {done}"]})
    again = pack_kernels(tmp_path / "again.tar.xz", silent, everything=True)
    assert set(unpack(again.file.read_bytes())) == set(unpack(packed.read_bytes()))


@pytest.mark.long
@portable
def test_what_was_compiled_here_and_never_used_is_not_packed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Entries that only callers needed keep the time of their files, 1970, in a second run."""
    run(f"{ONE}{ALONE}", NUMBA_CACHE_DIR=str(tmp_path), **{SEED: OFF})
    for path in (tmp_path / "tauten" / "kernels").iterdir():
        os.utime(path, (0.0, 0.0))
    run(ALONE, NUMBA_CACHE_DIR=str(tmp_path), **{SEED: OFF})
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setenv(SEED, OFF)
    monkeypatch.setattr(pack, "workload", lambda work: {"nothing": ["-c", "pass"]})
    file = pack_kernels(tmp_path / "some.tar.xz", silent, everything=True).file
    found = {name.partition("-")[0] for name in unpack(file.read_bytes())}
    assert found == {"tauten.model.parts.motion._add_rows"}


@kernel
def calls_add_rows(block: Array, rows: Ints, first: int, H: Array) -> None:
    """A kernel that calls one which is shipped for calls from Python only."""
    _add_rows(block, rows, first, H)


@pytest.mark.long
@portable
def test_what_a_new_caller_needs_is_compiled_again(tmp_path: Path, packed: Path) -> None:
    seed = unpacked(packed.read_bytes(), tmp_path)
    caches = [getattr(one, "_cache") for one in (_add_rows, calls_add_rows)]  # noqa: B009
    for count, found in ((1, True), (2, False)):
        target = tmp_path / str(count)
        gather(caches[:count], tmp_path / "none", seed, target)
        assert any(target.iterdir()) == found


@pytest.mark.long
@portable
def test_a_program_that_fails_leaves_no_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pack, "workload", lambda work: {"one": ["-c", "raise SystemExit('no')"]})
    with pytest.raises(PackError, match=r"ended with 1: no"):
        pack_kernels(tmp_path / "kernels.tar.xz", silent)
    assert not list(tmp_path.iterdir())


def test_nothing_is_packed_for_one_processor_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pack, "portable_machine", lambda: None)
    with pytest.raises(PackError, match="NUMBA_CPU_NAME"):
        pack_kernels(tmp_path / "kernels.tar.xz", silent)


@pytest.mark.long
@portable
def test_the_inventory_counts_what_is_served(packed: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(SEED, str(packed))
    found = take_inventory()
    assert (found.served, found.changed, found.entries, found.why_not) == (2, 0, 2, "")
    assert found.kernels > 200
    assert waiting() == "", "nothing is said of minutes where nothing is compiled"


def test_why_none_is_used(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(SEED, OFF)
    assert waiting().endswith(f"takes some minutes ({SEED} is off)")
    monkeypatch.setattr(sys, "argv", ["tauten", "kernels"])
    with pytest.raises(SystemExit, match="0"):
        main()
    assert f"{SEED} is off" in capsys.readouterr().out
    if portable_machine() is not None:
        monkeypatch.setenv(SEED, str(tmp_path / "missing"))
        assert why_none() == f"{SEED} is {tmp_path / 'missing'}, which is no file"
        monkeypatch.delenv(SEED)
        monkeypatch.setattr("tauten.service.kernels.seed_file", lambda: tmp_path / "missing")
        assert why_none().startswith(f"here is {seed_name()[:4]}")
    monkeypatch.setattr("tauten.service.kernels.portable_machine", lambda: None)
    assert "this processor lacks" in why_none()


def test_the_table_of_the_first_hour_has_a_row_for_each_start() -> None:
    demos = [FirstHour(start, 30.0, 8.25, 40.0, 3, host_info()) for start in ("cold", "warm")]
    (table,) = first_hour_page(demos).tables
    assert all(len(row) == len(table.columns) for row in table.rows)
    assert table.rows[0][1:5] == ("8.2", "30.0", "40.0", "3")


def test_shipped_files_are_small() -> None:
    """Git keeps every one of them for ever."""
    assert all(file.stat().st_size <= LARGEST for file in SHIPPED.glob("*"))


@pytest.mark.slow
@portable
def test_the_demo_compiles_few_kernels() -> None:
    if not (SHIPPED / seed_name()).is_file():
        pytest.skip("nothing is shipped for this Python, numba and system")
    (found,) = first_demos(silent, (SEEDED,))
    assert found.compiled <= 5
