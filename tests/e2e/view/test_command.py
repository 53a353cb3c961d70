"""`tauten view` as a command: what it says when it cannot begin, and that it ends in order."""

from __future__ import annotations

import json
import signal
import urllib.request
from pathlib import Path

import pytest
from support.processes import START, Process, Start, run_benchmark, run_main, start_script
from support.viewers import wait_until

from tauten.service.plant import free_ports
from tauten.service.process import StopFlag
from tauten.service.view import SimulationSettings, export_simulation, open_server

WITHOUT_VISER = """
import sys
sys.modules["viser"] = None
sys.argv = ["tauten", "view", "finger", "--simulate"]
from tauten.service.cli import main
main()
"""


def refused(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    """The one sentence of a command that ends with exit code 2."""
    assert run_main("view", *arguments) == 2
    lines = capsys.readouterr().err.strip().splitlines()
    return lines[-1]


def test_a_missing_extra_is_named(tmp_path: Path) -> None:
    script = tmp_path / "without_viser.py"
    script.write_text(WITHOUT_VISER)
    process = start_script(tmp_path / "output.txt", script)
    assert process.process.wait(START) == 2
    assert process.output.read_text().strip().splitlines() == [
        "tauten: the viewer needs viser, which is not installed: pip install -e '.[viewer]'"
    ]


@pytest.mark.parametrize("what", [("beam", "--simulate"), ("nobody",), ("no.mcap",)])
def test_a_port_in_use_is_told_before_any_work(
    beam_file: Path, what: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    """A simulated robot was ready first, after 13 s, and a node was waited for."""
    robot = beam_file if what[0] == "beam" else what[0]
    with open_server(0, "first") as (server, _):
        port = server.get_port()
        assert run_main("view", robot, *what[1:], "--no-browser", "--web-port", port) == 2
    (sentence,) = capsys.readouterr().err.strip().splitlines()
    assert sentence.startswith(f"tauten: port {port} on 127.0.0.1 is taken")
    assert "--web-port" in sentence


def test_the_port_of_zenoh_is_not_the_page_s(
    beam_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run_main("view", beam_file, "--simulate", "--port", 8099) == 2
    refusal = capsys.readouterr().err
    assert "--port is Zenoh's" in refusal and "--web-port" in refusal


def test_no_node(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tauten.service.link.commanding._PATIENCE", 0.1)
    port = free_ports()
    assert refused(capsys, "nobody", "--no-browser", "--port", port) == (
        f"tauten: no node serves 'nobody' on port {port}: start it with tauten serve and the robot's name or "
        "file, or give the --port on which it is served"
    )


def test_no_log(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    missing, other = tmp_path / "missing.mcap", tmp_path / "other.mcap"
    other.write_bytes(b"no log")
    assert "missing.mcap: cannot be read" in refused(capsys, missing)
    assert "other.mcap: not the log of a run" in refused(capsys, other, "--export", "a.html")


def test_an_export_needs_a_path(
    beam_file: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It said so after seconds in which the robot was made."""
    monkeypatch.setattr("tauten.service.view.show.simulated", None)
    html = tmp_path / "beam.html"
    sentence = refused(capsys, beam_file, "--simulate", "--export", html)
    assert sentence == (
        "tauten: an export of a simulation needs a path: give --path, for instance reach"
    )
    assert not html.exists()


@pytest.mark.long
def test_a_simulation_is_exported(beam_file: Path, tmp_path: Path) -> None:
    html = tmp_path / "beam.html"
    exported = ("--simulate", "--path", "line", "--seconds", 1, "--export", html)
    assert run_main("view", beam_file, *exported) == 0
    assert "__VISER_EMBED_DATA__" in html.read_text()


@pytest.mark.long
def test_an_export_says_how_far_it_is(beam_file: Path, tmp_path: Path) -> None:
    """It takes longer than the robot's time, and showed nothing."""
    shares, settings = list[float](), SimulationSettings(str(beam_file), path="line")
    count = export_simulation(
        settings, 0.5, tmp_path / "a.html", StopFlag(), lambda share, _: shares.append(share)
    )
    assert len(shares) == count > 5
    assert sum(shares) == pytest.approx(count / (count + 1))


def test_the_page_is_served_until_ctrl_c(run: Start, beam_file: Path) -> None:
    port = free_ports()
    process: Process = run("view", beam_file, "--simulate", "--no-browser", "--web-port", port)
    address = f"http://127.0.0.1:{port}"

    def answers() -> bool:
        assert process.process.poll() is None, process.output.read_text()
        try:
            with urllib.request.urlopen(address, timeout=5.0) as page:
                return b"<title>" in page.read()
        except OSError:
            return False

    assert wait_until(answers, 120.0)
    assert "model and simulated robot get ready" in process.output.read_text(), (
        "a minute of large ones"
    )
    assert wait_until(lambda: f"open {address} in a browser" in process.output.read_text())
    assert process.end(signal.SIGINT) == 0


@pytest.mark.long
def test_the_cost_of_a_viewer_is_measured(beam_file: Path, tmp_path: Path) -> None:
    file = tmp_path / "cost.json"
    arguments = ("view", beam_file, "--seconds", 1, "--path", "line", "--json", file)
    assert run_benchmark(*arguments) == 0
    (cost,) = json.loads(file.read_text())
    assert cost["robot"] == "beam"
    assert 1.0 < cost["pictures_hz"] < 31.0
    assert 0.0 < cost["processor_share"] < 1.5
