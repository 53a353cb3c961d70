"""Errors of what another package adds: a function that fails, or that gives what cannot be used."""

from __future__ import annotations

from collections.abc import Callable
from traceback import walk_tb
from typing import TypeVar

import numpy as np

T = TypeVar("T")


class ExtensionError(RuntimeError):
    """What another package adds has failed; the text names it, the exception and the line that raised it."""


def extension_error(what: str, error: Exception) -> ExtensionError:
    """The error to raise where a function of another package, such as "effector 'grasp'", has raised one."""
    foreign = [
        (frame.f_code.co_filename, line)
        for frame, line in walk_tb(error.__traceback__)
        if not frame.f_globals.get("__name__", "").startswith("tauten.")
    ]
    # the deepest line of the package, not of a library that it calls
    own = [place for place in foreign if place[0] == foreign[0][0]]
    where = f" ({own[-1][0]}, line {own[-1][1]})" if own else ""
    text = " ".join(str(error).split())
    return ExtensionError(f"{what} has failed with {type(error).__name__}: {text}{where}")


def is_own(found: object) -> bool:
    """Whether a function, a class, or the class of an object is tauten's."""
    return str(getattr(found, "__module__", "")).startswith("tauten.")


def answer_of(
    what: str, fault: Callable[[object], str], call: Callable[..., T], *given: object
) -> T:
    """What a function of another package gives while a robot moves.

    Args:
        what: names the function.
        fault: what is wrong with an answer, see `shape_fault`; "" where nothing is.
        call: the function.
        given: its arguments.

    Raises:
        ExtensionError: it fails, or its answer cannot be used.
    """
    try:
        found = call(*given)
    except Exception as error:
        raise extension_error(what, error) from error
    wrong = fault(found)
    if wrong:
        raise ExtensionError(f"{what} {wrong}")
    return found


def shape_fault(*parts: tuple[str, object, tuple[int, ...]]) -> str:
    """What is wrong with parts from another package: name, value and right shape of each; "": nothing is."""
    for name, found, shape in parts:
        array = np.asarray(found) if isinstance(found, float | int | np.number) else found
        if not isinstance(array, np.ndarray) or array.dtype.kind not in "fiu":
            return f"gives {name} as a {type(found).__name__}, expected is an array of numbers"
        if array.shape != shape:
            return f"gives {name} of the shape {array.shape}, expected is {shape}"
    return ""
