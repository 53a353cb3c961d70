"""What tests share: reference data beside the repository, the finger, a small robot for processes."""

from __future__ import annotations

import gc
import os
import signal
import sys
from collections import Counter
from collections.abc import Generator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import settings

if (
    TYPE_CHECKING
):  # the process that starts the others need not wait until it has imported tauten itself
    from tauten.model import Robot
    from tauten.model.tetra import NodalBody

# The processes of the suite share the processor's cores; read by BLAS when numpy is imported.
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ["MPLBACKEND"] = "Agg"
# Else each of hundreds of processes would compile all modules again, and rewrite the assertions of all tests.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

EARLY = 0.8  # share of the suite in which files that wait for processes are begun
MOST_CORES = 8  # that the suite uses; each process of it needs about half a gigabyte

# The same examples every time, so that what fails here fails there; see CONTRIBUTING for others.
# Without deadlines: how long an example takes depends on what else the machine does.
settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")


def whole_suite(config: pytest.Config) -> bool:
    """Whether no files and folders are named."""
    return config.args_source is pytest.Config.ArgsSource.TESTPATHS


def pytest_configure(config: pytest.Config) -> None:
    """Leave out tests marked `long` where nothing is selected, neither by files nor by marks."""
    if whole_suite(config) and config.option.markexpr in config.getini("addopts"):
        config.option.markexpr += " and not long"


def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """Two more than there are cores where the whole suite runs: tests of processes mostly wait for them.

    None for single files, a debugger, and times of the real clock.
    """
    if whole_suite(config) and "realtime" not in config.option.markexpr.replace("not realtime", ""):
        config.option.loadscopereorder = False  # `pytest_collection_modifyitems` has an order
        return min(os.cpu_count() or 1, MOST_CORES) + 2
    config.option.dist = "no"
    return 0


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Files that wait for processes are spread among the others, so that neither are left at the end.

    Of both kinds those with most tests come first. Each process of the suite takes the next file.
    """
    if os.environ.get("PYTEST_XDIST_WORKER") is None:
        return
    sizes = Counter(item.path for item in items)
    own = config.rootpath / "tests"
    places: dict[Path, float] = {}
    for waits, end in ((True, EARLY), (False, 1.0)):
        files = [
            path for path in sizes if (path.parent == own or own / "e2e" in path.parents) == waits
        ]
        files.sort(key=lambda path: -sizes[path])
        places |= {path: end * (i + 0.5) / len(files) for i, path in enumerate(files)}
    items.sort(key=lambda item: places[item.path])


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """What is imported and collected lives to the end: the garbage collector leaves it out.

    It looks less often at the rest, most of which lives on where kernels are compiled.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.set_threshold(20_000, 20, 20)
        gc.enable()


@pytest.fixture(autouse=True)
def heed_interrupts() -> None:
    """Commands under test obey Ctrl-C, also where a background shell made this process ignore it."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def reference() -> Path:
    """Folder of the curves other programs made; see CONTRIBUTING for where it is looked for."""
    default = Path(__file__).resolve().parents[2] / "shared" / "data"
    folder = Path(os.environ.get("TAUTEN_REFERENCE_DATA", default))
    if not folder.is_dir():
        pytest.skip(f"reference data not found in {folder}; set TAUTEN_REFERENCE_DATA")
    return folder


@pytest.fixture(scope="session")
def finger() -> Robot[NodalBody]:
    """A finger that is quick to compute: the shipped one on a coarse mesh."""
    from support.robots.thumb import coarse_finger

    return coarse_finger()


@pytest.fixture(scope="session")
def shipped_finger() -> Robot[NodalBody]:
    """The shipped finger, with thousands of nodes."""
    from tauten.model import load_robot
    from tauten.model.tetra import NodalBody

    robot = load_robot("finger")
    assert isinstance(robot.body, NodalBody)
    return robot


@pytest.fixture(scope="session")
def beam_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The small robot's file."""
    from support.processes import write_robot

    return write_robot(tmp_path_factory.mktemp("beam"))


@pytest.fixture(scope="session")
def beam(beam_file: Path) -> Robot:
    """The small robot."""
    from tauten.model import load_robot

    return load_robot(beam_file)
