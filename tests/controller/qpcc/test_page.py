"""docs/qpcc.md: its Python runs, and its picture shows what it says."""

from __future__ import annotations

import importlib.util
import re
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from tauten.controller.qpcc import solve_qpcc

DOCS = Path(__file__).resolve().parents[3] / "docs"


@pytest.fixture(scope="module")
def figure() -> ModuleType:
    spec = importlib.util.spec_from_file_location(
        "qpcc_figure", DOCS / "scripts" / "qpcc_figure.py"
    )
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look themselves up there
    spec.loader.exec_module(module)
    return module


def test_the_python_of_the_page_runs() -> None:
    (snippet,) = re.findall(
        r"```python\n(.*?)```", (DOCS / "qpcc.md").read_text(encoding="utf-8"), flags=re.DOTALL
    )
    names: dict[str, object] = {}
    exec(compile(snippet, "qpcc.md", "exec"), names)
    assert names["again"].pivots == 1  # type: ignore[attr-defined]


def test_the_picture_has_a_way_to_the_optimum_and_a_local_one(figure: ModuleType) -> None:
    plane, line = figure.two_cables(), figure.one_cable()
    for start in ((0.1, 0.35), (0.12, 2.1)):
        way = figure.path(plane, np.array(start))
        values = [value for _, value in way]
        assert len(way) == 3
        assert values == sorted(values, reverse=True)
        assert values[-1] == pytest.approx(solve_qpcc(plane).objective)
    local = figure.path(line, np.array([0.2]))[-1][1]
    assert local > solve_qpcc(line).objective + 0.05


@pytest.mark.long
def test_the_picture_is_drawn(
    figure: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "qpcc.svg"
    monkeypatch.setattr(figure, "FILE", file)
    figure.main()
    assert file.read_text(encoding="utf-8").rstrip().endswith("</svg>")
