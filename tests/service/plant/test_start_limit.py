"""A process may take the longer to start the more kernels are compiled meanwhile, and says how many."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from tauten.model.numerics import kernel
from tauten.service.cli.terminal import WithKernels
from tauten.service.plant import DemoError, StartLimit


def test_a_limit_begins_again_with_each_kernel(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A demo that compiled all of its kernels on a busy machine failed after five minutes."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))

    @kernel
    def half(x: float) -> float:
        return 0.5 * x

    limit, shown = StartLimit(0.0), WithKernels("the node gets ready")
    assert shown.__rich__() == "the node gets ready"
    assert half(3.0) == 1.5 and list(tmp_path.rglob("*half*.nbc"))
    assert shown.__rich__() == "the node gets ready; kernels compiled so far, once for all: 1"
    limit.check("the node")
    time.sleep(1e-3)
    with pytest.raises(DemoError, match=r"the node did not start; no kernel has been compiled"):
        limit.check("the node")
