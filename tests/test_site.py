"""The documentation site: it builds without warnings, loads nothing from elsewhere, and its commands run."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from importlib.metadata import packages_distributions, requires
from pathlib import Path

import chromium
import film_strip
import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "docs" / "start.md", ROOT / "docs" / "tutorials" / "own_robot.md"]


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site, built in a process of its own as the contributors' command does."""
    pytest.importorskip("sphinx", reason="tauten[docs] is not installed")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "docs", str(folder)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return folder


def test_what_the_build_imports_comes_with_the_extra() -> None:
    """So that it runs where `tauten[docs]` alone is installed."""
    imported: set[str] = set()
    for script in ("conf", "scripts/reference_pages", "scripts/robot_file_page"):
        tree = ast.parse((ROOT / "docs" / f"{script}.py").read_text(encoding="utf-8"))
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                imported |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module is not None:
                imported.add(node.module.partition(".")[0])
    imported -= {*sys.stdlib_module_names, "tauten", "reference_pages", "robot_file_page"}
    needed = [Requirement(line) for line in requires("tauten") or ()]
    listed = {
        canonicalize_name(one.name)
        for one in needed
        if one.marker is None or one.marker.evaluate({"extra": "docs"})
    }
    found = packages_distributions()
    assert "typer" in imported
    for name in imported:
        assert listed & {canonicalize_name(one) for one in found.get(name, [])}, name


@pytest.mark.parametrize("page", PAGES, ids=[page.stem for page in PAGES])
def test_a_page_waits_for_what_its_commands_print(page: Path) -> None:
    """The plant's message had changed: the page's picture waited an hour for the words of before."""
    sources = [path.read_text(encoding="utf-8") for path in (ROOT / "service").rglob("*.py")]
    awaited = [step.until for step in film_strip.steps_of(page) if step.until is not None]
    assert len(awaited) > 2
    for text in awaited:
        message = re.sub(r"\b(finger|bender)\b", "%s", text)
        assert any(f'"{message}' in source for source in sources), text


def test_every_page_is_in_the_contents() -> None:
    contents = (ROOT / "docs" / "index.md").read_text(encoding="utf-8").splitlines()
    pages = sorted((ROOT / "docs").rglob("*.md"))
    assert len(pages) > 20
    for page in pages:
        name = page.relative_to(ROOT / "docs").with_suffix("").as_posix()
        if not name.startswith("_build") and name != "index":
            assert name in contents, name


@pytest.mark.slow
def test_every_page_is_reached_from_the_first(site: Path) -> None:
    first = (site / "index.html").read_text(encoding="utf-8")
    for page in sorted((ROOT / "docs").rglob("*.md")):
        name = page.relative_to(ROOT / "docs").with_suffix(".html")
        if "_build" in name.parts or name.name == "index.html":
            continue
        assert f'href="{name.as_posix()}"' in first, name


@pytest.mark.slow
def test_pages_load_nothing_from_elsewhere(site: Path) -> None:
    for page in site.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        assert not re.findall(r'(?:src|<link[^>]*href)="(?:https?:)?//[^"]*', text), page.name


@pytest.mark.slow
def test_the_reference_has_every_table_and_command(site: Path) -> None:
    robot_file = (site / "reference" / "robot-file.html").read_text(encoding="utf-8")
    commands = (site / "reference" / "commands.html").read_text(encoding="utf-8")
    for field in ("max_outside", "young_modulus", "alarm_distance", "target_timeout", "basis"):
        assert field in robot_file
    for command in ("serve", "reduce", "check", "new", "bench closed-loop"):
        assert f"tauten {command}" in commands


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_commands_of_a_page_run_as_written(page: Path, tmp_path: Path) -> None:
    """In the environment of the tests; the picture shows every step."""
    pytest.importorskip("netgen", reason="tauten[mesh] is not installed")
    pytest.importorskip("playwright", reason="playwright is not installed")
    if chromium.installed() is None:
        pytest.skip("no Chromium on this computer: apt-get install chromium")
    shots = film_strip.film(page, film_strip.copy_of_repository(tmp_path), here=True)
    commands = " ".join(shot.step.code for shot in shots)
    for command in ("view", "demo", "serve", "stream"):
        assert f"tauten {command}" in commands
    assert sum(shot.picture is not None for shot in shots) >= 2
    film_strip.draw(shots, tmp_path / "strip.png")
    assert (tmp_path / "strip.png").stat().st_size > 100_000


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_commands_of_a_page_run_in_a_new_environment(page: Path, tmp_path: Path) -> None:
    """With everything installed and compiled anew, as a newcomer does it."""
    pytest.importorskip("playwright", reason="playwright is not installed")
    if chromium.installed() is None:
        pytest.skip("no Chromium on this computer: apt-get install chromium")
    try:
        shots = film_strip.film(page, film_strip.copy_of_repository(tmp_path))
    except film_strip.StepError as error:
        if "No matching distribution" in str(error) or "connection" in str(error).lower():
            pytest.skip(f"packages cannot be installed here: {str(error).splitlines()[-1]}")
        raise
    assert any(film_strip.INSTALLS in shot.step.code for shot in shots)


def test_blocks_are_run_as_their_comments_say(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(
        """# Page
## First

<!-- run beside; until: ready -->
```sh
trap 'echo over > ended' INT; echo ready; sleep 60 & wait
```

<!-- run; picture: made-* -->
```sh
export WHO=there
echo hello > made-1.png
```

```sh
touch not-marked
```

## Second

<!-- run -->
```python
import os; print("hello", os.environ["WHO"], os.path.exists("ended"))
```

<!-- run for 0 s; until: sending -->
```sh
trap 'exit 0' INT; echo sending; sleep 60 & wait
```
""",
        encoding="utf-8",
    )
    folder = tmp_path / "folder"
    folder.mkdir()
    beside, run, python, ended = film_strip.film(page, folder)
    assert (beside.step.section, beside.output) == ("First", "ready\n")
    assert run.picture == folder / "made-1.png"
    assert python.output == "hello there True\n"
    assert ended.output == "sending\n"
    assert not (folder / "not-marked").exists()


@pytest.mark.parametrize(
    ("block", "match"),
    [
        ("<!-- run -->\n```sh\nfalse\n```", "ended with 1"),
        ("<!-- run; picture: none.png -->\n```sh\ntrue\n```", "has not written none.png"),
        ("<!-- run beside; until: never -->\n```sh\necho ready\n```", "has not printed 'never'"),
        ("<!-- run in a browser -->\n```sh\ntrue\n```", "has opened no page"),
    ],
)
def test_a_block_that_does_not_do_what_its_page_says(
    block: str, match: str, tmp_path: Path
) -> None:
    page = tmp_path / "page.md"
    page.write_text(f"# Page\n\n{block}\n", encoding="utf-8")
    with pytest.raises(film_strip.StepError, match=match):
        film_strip.film(page, tmp_path)
