"""README: its tables are those of the results, its Python runs, its links lead somewhere, it is short."""

from __future__ import annotations

import json
import re
from importlib.metadata import version
from pathlib import Path

import pytest
import tables

from tauten.reduction import source_version

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
RESULTS = sorted((ROOT / "docs" / "results").glob("*.json"))
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]


@pytest.mark.parametrize("file", RESULTS, ids=lambda file: file.stem)
def test_results_are_json_that_other_programs_read(file: Path) -> None:
    """Python's own NaN and Infinity are none."""

    def refused(constant: str) -> None:
        raise ValueError(f"{file.name} has {constant}")

    assert json.loads(file.read_text(encoding="utf-8"), parse_constant=refused)


def test_tables_come_from_the_results() -> None:
    texts = [page.read_text(encoding="utf-8") for page in tables.PAGES]
    assert sum(text.count("<!-- end -->") for text in texts) == len(tables.TABLES)
    for text in texts:
        assert tables.filled(text) == text, "run python -m docs.scripts.tables"


def test_it_is_read_in_two_minutes() -> None:
    """At 250 words a minute, without its tables, commands and addresses of links."""
    text = re.sub(r"```.*?```|<[^>]*>", "", README, flags=re.DOTALL)
    text = re.sub(r"\]\([^)]*\)", "", text)
    prose = [line for line in text.splitlines() if not line.startswith("|")]
    assert 200 < len(" ".join(prose).split()) <= 500


def test_nothing_advises_to_install_what_is_not_published() -> None:
    folders = ("model", "reduction", "controller", "service", "docs", "examples", "benchmarks")
    files = [ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
    files += [path for name in folders for path in (ROOT / name).rglob("*.[pm][yd]")]
    advice = re.compile(r"pip install (?:-\S+ )*['\"]?tauten")
    files = [path for path in files if "_build" not in path.parts]
    assert len(files) > 300
    assert [path for path in files if advice.search(path.read_text(encoding="utf-8"))] == []


SNIPPETS = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)


@pytest.mark.parametrize(
    "snippet",
    [SNIPPETS[0], *(pytest.param(one, marks=pytest.mark.slow) for one in SNIPPETS[1:])],
    ids=[f"block {number}" for number in range(1, len(SNIPPETS) + 1)],
)
def test_each_block_of_python_runs_by_itself(
    snippet: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """And the robot arrives: the last decision is OK."""
    exec(compile(snippet, "README.md", "exec"), {})
    assert "OK" in capsys.readouterr().out


@pytest.mark.parametrize("snippet", SNIPPETS)
def test_the_python_of_the_readme_imports_what_there_is(snippet: str) -> None:
    imports = [line for line in snippet.splitlines() if line.startswith("from ")]
    assert imports
    exec("\n".join(imports), {})


def anchors(page: Path) -> set[str]:
    """The anchors of a page's headings, as GitHub makes them."""
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    headings = re.findall(r"^#+ +(.+)$", text, flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_targets_of_links_exist(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for target, anchor in re.findall(r"\]\(([^)#]*)(?:#([^)]*))?\)", text):
        if target.startswith(("http", "mailto")):
            continue
        path = page.parent / target if target else page
        assert path.exists(), target
        if anchor:
            assert anchor in anchors(path), f"{target}#{anchor}"


def test_a_source_tree_that_is_not_installed_has_its_version() -> None:
    assert source_version() == version("tauten")
