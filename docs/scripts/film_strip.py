"""Runs the commands of a page as they are written, and draws what each one shows.

    python docs/scripts/film_strip.py docs/start.md docs/figures/five-minutes.png
    python docs/scripts/film_strip.py docs/tutorials/own_robot.md docs/figures/own-robot.png

A comment before a block of a page says how it is run, and which picture it makes:

| comment | the block |
|---|---|
| `<!-- run -->` | runs to its end |
| `<!-- run; picture: FILE -->` | runs to its end and writes this picture (a pattern of names) |
| `<!-- run beside; until: TEXT -->` | prints the text and runs on; gets Ctrl-C at the end of its section |
| `<!-- run for N s; until: TEXT -->` | gets Ctrl-C N seconds after it has printed the text |
| `<!-- run in a browser; until: TEXT -->` | opens a page, which is photographed once it shows the text |

The commands run in a copy of the repository without anything that was built, and in the virtual environment
that they make and fill. `--here` leaves out blocks that install and takes the environment of this program.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import textwrap
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

import chromium
import matplotlib.image
import matplotlib.pyplot as plt

ROOT = Path(__file__).resolve().parents[2]
HEADING = re.compile(r"^#+ (.*)$", re.MULTILINE)
BLOCK = re.compile(
    r"<!-- run(?P<how> beside| in a browser| for \d+ s|)"
    r"(?:; until: (?P<until>[^;]+?))?(?:; picture: (?P<picture>\S+))? -->\n"
    r"```(?P<language>sh|python)\n(?P<code>.*?)\n```$",
    re.MULTILINE | re.DOTALL,
)
PATIENCE = 3600.0  # s; a first run compiles kernels
LOOK = 5_000  # ms for which the robot is seen moving before it is photographed
STOPPING = 60.0  # s from Ctrl-C to the end
INSTALLS = "pip install"
COLUMNS, LINES = 96, 16  # of a terminal in the picture


class StepError(RuntimeError):
    """A command that did not do what its page says."""


@dataclass(frozen=True, slots=True)
class Step:
    """A block of a page.

    Attributes:
        section: heading above it.
        language: "sh" or "python".
        code: as written.
        how: "", "beside", "in a browser" or "for N s".
        until: text that shows that it is ready.
        picture: file that it writes.
    """

    section: str
    language: str
    code: str
    how: str
    until: str | None
    picture: str | None


@dataclass(frozen=True, slots=True)
class Shot:
    """What a step has shown.

    Attributes:
        step: the step.
        output: what it printed.
        seconds: until it was ready, or its end.
        picture: that it made; None: none.
    """

    step: Step
    output: str
    seconds: float
    picture: Path | None


def steps_of(page: Path) -> list[Step]:
    """The blocks of a page that are run."""
    text = page.read_text(encoding="utf-8")
    headings = [(found.end(), found.group(1)) for found in HEADING.finditer(text)]
    return [
        Step(
            section=[title for place, title in headings if place < found.start()][-1],
            language=found["language"],
            code=found["code"],
            how=found["how"].strip(),
            until=found["until"],
            picture=found["picture"],
        )
        for found in BLOCK.finditer(text)
    ]


class Terminal:
    """Runs steps one after another in a folder; variables that a step sets remain, as in a shell."""

    def __init__(self, folder: Path) -> None:
        """Start with the environment of this program.

        Args:
            folder: where commands run.
        """
        self._folder = folder
        self._aside = folder.with_name(f"{folder.name}-film")  # outputs and pictures
        self._aside.mkdir(exist_ok=True)
        browser = self._aside / "browser"
        browser.write_text(f'#!/bin/sh\necho "$1" > {self._aside}/address\n', encoding="utf-8")
        browser.chmod(0o755)
        tools = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
        self._environment = os.environ | {
            "PATH": tools,
            "BROWSER": str(browser),  # what Python opens pages with
            "COLUMNS": str(COLUMNS),
            "PYTHONUNBUFFERED": "1",
        }
        self._count = 0

    def run(self, step: Step) -> Shot:
        """Run a step that ends by itself, after some time, or with its page.

        Args:
            step: not one that runs beside others.

        Raises:
            StepError: it ends with another code than 0, or its page or picture does not appear.
        """
        begin = time.monotonic()
        picture = None
        with self.running(step) as (process, output):
            if step.how == "in a browser":
                picture = self._photographed(step, process, output)
                seconds = time.monotonic() - begin
                _interrupt(process)
            elif step.how:
                self._await_text(step, process, output)
                time.sleep(float(step.how.split()[1]))
                _interrupt(process)
                seconds = time.monotonic() - begin
            else:
                process.wait(PATIENCE)
                seconds = time.monotonic() - begin
        if process.returncode:
            raise StepError(_report(step, output, f"ended with {process.returncode}"))
        if step.picture is not None:
            picture = max(self._folder.glob(step.picture), default=None)
            if picture is None:
                raise StepError(_report(step, output, f"has not written {step.picture}"))
        self._take_variables()
        return Shot(step, _text(output), seconds, picture)

    @contextmanager
    def running(self, step: Step) -> Iterator[tuple[subprocess.Popen[bytes], Path]]:
        """A step as a process, with the file of its output; it gets Ctrl-C at the end of the block."""
        self._count += 1
        output = self._aside / f"{self._count}.txt"
        if step.language == "python":
            file = self._aside / f"{self._count}.py"
            file.write_text(step.code, encoding="utf-8")
            code = f"python {file}"
        else:
            code = step.code
        with output.open("wb") as sink:
            process = subprocess.Popen(
                ["bash", "-c", f"set -e\n{code}\nenv -0 > {self._aside}/variables"],
                cwd=self._folder,
                env=self._environment,
                stdin=subprocess.DEVNULL,
                stdout=sink,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        try:
            yield process, output
        finally:
            _interrupt(process)

    def beside(self, step: Step, stack: ExitStack) -> Shot:
        """Start a step and leave it running until the stack is closed; returns when it is ready.

        Args:
            step: that runs beside others.
            stack: ends it.

        Raises:
            StepError: it is not ready.
        """
        begin = time.monotonic()
        process, output = stack.enter_context(self.running(step))
        self._await_text(step, process, output)
        return Shot(step, _text(output), time.monotonic() - begin, None)

    def _await_text(self, step: Step, process: subprocess.Popen[bytes], output: Path) -> None:
        """Wait until a step has printed its text."""
        end = time.monotonic() + PATIENCE
        while step.until is not None and step.until not in _text(output):
            if process.poll() is not None or time.monotonic() > end:
                raise StepError(_report(step, output, f"has not printed {step.until!r}"))
            time.sleep(0.2)

    def _photographed(self, step: Step, process: subprocess.Popen[bytes], output: Path) -> Path:
        """A picture of the page that a step opens."""
        address, begin = self._aside / "address", time.monotonic()
        address.unlink(missing_ok=True)
        while not address.is_file() or not address.read_text(encoding="utf-8").endswith("\n"):
            if process.poll() is not None or time.monotonic() - begin > PATIENCE:
                raise StepError(_report(step, output, "has opened no page"))
            time.sleep(0.2)
        picture = self._aside / f"{self._count}.png"
        with chromium.launched() as browser:
            page = chromium.viewer_page(browser, address.read_text(encoding="utf-8").strip())
            page.get_by_text(step.until or "Operate").first.wait_for()
            page.wait_for_timeout(LOOK)
            # without a graphics card the browser falls behind on a busy machine: the viewer waits for it
            os.killpg(process.pid, signal.SIGSTOP)
            try:
                chromium.photograph(page, picture)
            finally:
                os.killpg(process.pid, signal.SIGCONT)
        return picture

    def _take_variables(self) -> None:
        """Take over the variables that the last step has set: a virtual environment that was activated."""
        file = self._aside / "variables"
        if file.is_file():
            entries = file.read_text(encoding="utf-8").split("\0")
            self._environment = dict(entry.split("=", 1) for entry in entries if "=" in entry)
            file.unlink()


def film(page: Path, folder: Path, here: bool = False) -> list[Shot]:
    """Run a page's commands.

    Args:
        page: of the documentation.
        folder: where they run, a copy of the repository.
        here: leave out what installs packages.

    Raises:
        StepError: a command did not do what the page says.
    """
    terminal, shots = Terminal(folder), list[Shot]()
    steps = [one for one in steps_of(page) if not (here and INSTALLS in one.code)]
    with ExitStack() as stack:
        section = ""
        for step in steps:
            if step.section != section:
                stack.close()  # what ran beside the steps of the section before
                section = step.section
            beside = step.how == "beside"
            shots.append(terminal.beside(step, stack) if beside else terminal.run(step))
    return shots


def copy_of_repository(folder: Path) -> Path:
    """A copy of what the repository holds, without anything that was built."""
    copy = folder / "tauten"
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout
    for name in filter(None, listed.split("\0")):
        if (ROOT / name).is_file():  # not one that is deleted but not committed
            target = copy / name
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, target)
    return copy


def draw(shots: list[Shot], file: Path) -> None:
    """Draw a terminal for each step, and beside it the picture that it made.

    Args:
        shots: of the steps.
        file: PNG to write.
    """
    texts = [_terminal_text(shot) for shot in shots]
    heights = [
        max(0.165 * (text.count("\n") + 1) + 0.55, 3.9 if shot.picture else 0.0)
        for shot, text in zip(shots, texts, strict=True)
    ]
    figure = plt.figure(figsize=(15.0, sum(heights)), dpi=100, facecolor="white")
    rows = figure.subfigures(len(shots), 1, height_ratios=heights, squeeze=False)[:, 0]
    for number, (row, shot, text) in enumerate(zip(rows, shots, texts, strict=True), 1):
        left, right = row.subplots(1, 2, width_ratios=(8.2, 6.8))
        row.subplots_adjust(
            left=0.01, right=0.99, wspace=0.02, bottom=0.02, top=1 - 0.35 / heights[number - 1]
        )
        left.set_facecolor("#1d2530")
        left.set_xticks([])
        left.set_yticks([])
        left.set_title(f"{number}  {shot.step.section}", loc="left", fontsize=13, weight="bold")
        left.set_title(f"{shot.seconds:.0f} s", loc="right", fontsize=10, color="0.4")
        left.text(
            0.012, 0.97, text, transform=left.transAxes, va="top", family="DejaVu Sans Mono",
            fontsize=8.4, color="#e8edf2", parse_math=False,
        )  # fmt: skip
        right.axis("off")
        if shot.picture is not None:
            right.imshow(matplotlib.image.imread(shot.picture))
            right.set_anchor("W")
    figure.savefig(file)
    plt.close(figure)


def _terminal_text(shot: Shot) -> str:
    """The command and the last lines of its output, as wide as a terminal."""
    prompt = "$ " if shot.step.language == "sh" else ">>> "
    lines = [prompt + line for line in shot.step.code.splitlines()]
    printed = [
        part
        for line in shot.output.replace("\r", "\n").splitlines()
        for part in textwrap.wrap(line, COLUMNS, drop_whitespace=False, subsequent_indent="  ")
    ]
    if len(printed) > LINES:
        printed = ["…", *printed[-LINES:]]
    return "\n".join([*lines, *printed])


def _interrupt(process: subprocess.Popen[bytes]) -> None:
    """Press Ctrl-C, unless the process has ended."""
    if process.poll() is not None:
        return
    os.killpg(process.pid, signal.SIGINT)
    try:
        process.wait(STOPPING)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def _text(output: Path) -> str:
    return output.read_text(encoding="utf-8", errors="replace")


def _report(step: Step, output: Path, what: str) -> str:
    return f"{step.section}: the command {what}\n{step.code}\n{_text(output)}"


def main() -> None:
    """Run a page and draw it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("page", type=Path)
    parser.add_argument("figure", type=Path)
    parser.add_argument("--here", action="store_true", help="take this program's environment")
    settings = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        shots = film(settings.page, copy_of_repository(Path(folder)), settings.here)
        draw(shots, settings.figure)


if __name__ == "__main__":
    main()
