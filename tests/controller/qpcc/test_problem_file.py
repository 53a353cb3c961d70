"""A problem written to a file is the problem read back; other files are refused with a sentence."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.processes import run_main
from support.qpcc_checks import recorded
from typer.testing import CliRunner

from tauten.controller.qpcc import read_qpcc, solve_qpcc, write_qpcc
from tauten.service.cli.app import app


def test_a_written_problem_is_solved_as_before(tmp_path: Path) -> None:
    step, file = recorded("three_cables_5")[40], tmp_path / "problem.qpcc"
    problem = step.problem()
    write_qpcc(file, problem, step.start)
    again, start = read_qpcc(file)
    assert start is not None
    for before, after in zip(problem.arrays, again.arrays, strict=True):
        np.testing.assert_array_equal(before, after)
    assert (again.constant, again.bound_names, again.row_names) == (
        problem.constant,
        problem.bound_names,
        problem.row_names,
    )
    first, second = solve_qpcc(problem, step.start), solve_qpcc(again, start)
    np.testing.assert_array_equal(first.lam_a, second.lam_a)
    assert first.pivots == second.pivots


def test_a_problem_is_replaced_whole_or_not_at_all(tmp_path: Path) -> None:
    """The file was emptied first, and one of a full disk or a lost power remained half written."""
    file = tmp_path / "problem.npz"
    write_qpcc(file, recorded("finger_5")[0].problem())
    before = file.read_bytes()
    with file.open("rb") as opened:
        write_qpcc(file, recorded("three_cables_5")[40].problem())
        assert opened.read() == before
    assert file.read_bytes() != before


def test_names_and_start_may_be_missing(tmp_path: Path) -> None:
    problem = replace(recorded("finger_5")[0].problem(), bound_names=(), row_names=())
    file = tmp_path / "problem.npz"
    write_qpcc(file, problem)
    again, start = read_qpcc(file)
    assert start is None
    assert again.name_of_bound(0) == "bound 0"


def test_files_that_are_none_are_refused(tmp_path: Path) -> None:
    text, other, crooked = (tmp_path / name for name in ("a.npz", "b.npz", "c.npz"))
    text.write_text("no problem")
    np.savez(other, Q=np.eye(2))
    problem = recorded("finger_5")[0].problem()
    arrays = dict(zip(("c", "lb", "ub", "G", "g_lo", "g_hi", "M", "m"), problem.arrays[1:]))  # noqa: B905
    np.savez(crooked, Q=np.eye(2), **arrays)
    with pytest.raises(ValueError, match=r"a\.npz: not an npz file"):
        read_qpcc(text)
    text.write_bytes(b"")
    with pytest.raises(ValueError, match=r"a\.npz: not an npz file"):
        read_qpcc(text)
    with pytest.raises(ValueError, match=r"b\.npz: no QPCC, the arrays c, lb, .* are missing"):
        read_qpcc(other)
    with pytest.raises(ValueError, match=r"c\.npz: Qpcc: Q, c, .* do not fit"):
        read_qpcc(crooked)
    with pytest.raises(OSError, match="nowhere"):
        read_qpcc(tmp_path / "nowhere.npz")


def test_the_command_prints_solution_certificate_and_status(tmp_path: Path) -> None:
    step, file = recorded("finger_5")[10], tmp_path / "problem.npz"
    write_qpcc(file, step.problem(), step.start)
    result = CliRunner().invoke(app, ["solve", str(file)])
    assert result.exit_code == 0
    solution = solve_qpcc(step.problem(), step.start)
    assert "OK: stationary point" in result.stdout
    assert f"{solution.lam_a[0]:.6g}" in result.stdout
    assert "stationarity" in result.stdout


def test_the_command_names_limits_in_conflict_and_bad_files(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    step, file = recorded("finger_5")[10], tmp_path / "problem.npz"
    problem = step.problem()
    write_qpcc(file, replace(problem, g_lo=problem.g_hi + 1.0, g_hi=problem.g_hi + 2.0))
    result = CliRunner().invoke(app, ["solve", str(file)])
    assert result.exit_code == 1
    assert "INFEASIBLE" in result.stdout
    assert "conflict" in result.stdout and "of cable 0" in result.stdout
    assert run_main("solve", tmp_path / "nowhere.npz") == 2
    assert capsys.readouterr().err == f"tauten: {tmp_path}/nowhere.npz: no such file or directory\n"
    file.write_text("no problem")
    refused = CliRunner().invoke(app, ["solve", str(file)])
    assert refused.exit_code == 2
