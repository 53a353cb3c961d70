#!/usr/bin/env -S uv run --script
# /// script
# dependencies = ["nox>=2025.2.9"]
# ///
"""Tasks for contributors: `nox` runs the checks and the tests, `nox -l` lists the others."""

from __future__ import annotations

import nox

nox.needs_version = ">=2025.2.9"
nox.options.default_venv_backend = "uv|virtualenv"


@nox.session
def tests(session: nox.Session) -> None:
    """Run the default test suite; further arguments go to pytest."""
    session.install("-e", ".[fast,test]")
    session.run("pytest", *session.posargs)


@nox.session
def lint(session: nox.Session) -> None:
    """Check style and format."""
    session.install("ruff>=0.6")
    session.run("ruff", "check", ".")
    session.run("ruff", "format", "--check", ".")


@nox.session(default=False)
def realtime(session: nox.Session) -> None:
    """Run the tests that need an idle machine."""
    session.install("-e", ".[fast,test]")
    session.run("pytest", "-m", "realtime", *session.posargs)


if __name__ == "__main__":
    nox.main()
