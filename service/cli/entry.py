"""Where `tauten` starts: `tauten command` at once, all other commands with the whole program."""

from __future__ import annotations

import sys


def main() -> None:
    """Entry point: errors of the set-up become one sentence and exit code 2."""
    try:
        if sys.argv[1:2] == ["command"]:
            from tauten.service.cli.emergency import emergency

            emergency()
        else:
            from tauten.service.cli.app import app

            app()
    except Exception as error:
        if not _is_of_set_up(error):
            raise
        print(f"tauten: {error}", file=sys.stderr)
        sys.exit(2)


def _is_of_set_up(error: Exception) -> bool:
    """Whether an error is one of those whose text names what to change."""
    from tauten.service.link import NetworkError, OrderError

    if isinstance(error, NetworkError | OrderError | OSError):
        return True
    from tauten.service.cli.app import setup_errors

    return isinstance(error, setup_errors())
