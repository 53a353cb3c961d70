"""The package of docs/extend.md, installed while these tests run."""

from __future__ import annotations

from collections.abc import Iterator
from types import ModuleType

import pytest
from support.robots.my_package import installed


@pytest.fixture(scope="session")
def package(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ModuleType]:
    """The module of the page."""
    with installed(tmp_path_factory.mktemp("site")) as module:
        yield module
