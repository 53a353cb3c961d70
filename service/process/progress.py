"""What long work calls to show how far it is."""

from __future__ import annotations

from typing import Protocol


class Progress(Protocol):
    """What a computation calls when a share of it is done."""

    def __call__(self, share: float, what: str = "") -> None:
        """Show that `share` more of the whole (1) is done, and what comes next."""
