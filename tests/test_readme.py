"""README: its tables are those of the results, its Python runs, the targets of its links exist."""

from __future__ import annotations

import importlib.util
import re
from importlib.metadata import version
from pathlib import Path

import pytest

from tauten.reduction import source_version

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]


def test_tables_come_from_the_results() -> None:
    spec = importlib.util.spec_from_file_location("tables", ROOT / "docs" / "tables.py")
    assert spec is not None and spec.loader is not None
    tables = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tables)
    assert README.count("<!-- end -->") == len(tables.TABLES)
    assert tables.filled(README) == README, "run python -m docs.tables"


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
