"""What makes machine code stale: what it was compiled from, and nothing else in the same file."""

from __future__ import annotations

import types
from collections.abc import Callable
from typing import Any

import numba
import pytest
from numba import types as nb

from tauten.model.kernels.sources import layouts, sources_digest

TEXT = '''
import numpy as np
from collections import namedtuple

SHARE = 2.0
ORDER = np.array([0, 1, 2])
OTHER = 1.0
Pair = namedtuple("Pair", ["first", "second"])

@njit
def deepest(x):
    """A docstring."""
    return x + ORDER[0]

@njit
def inner(x, n=2):
    # a comment
    total = 0.0
    for i in range(n):
        total += np.sqrt(3.0 * deepest(x))
    return total

@njit
def outer(pair):
    return Pair(SHARE * inner(pair.first), 1.0)

def unused(x):
    return OTHER * x
'''


def digest(text: str, name: str = "outer", options: str = "") -> str:
    """Of a kernel of a module with this text."""
    names: dict[str, Any] = {"njit": numba.njit, "__name__": "module_of_kernels"}
    exec(compile(text, "module.py", "exec"), names)
    function: Callable[..., Any] = names[name].py_func
    return sources_digest(function, options)


def changed(old: str, new: str) -> str:
    assert old in TEXT
    return TEXT.replace(old, new)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("3.0 * deepest(x)", "3.5 * deepest(x)"),
        ("x + ORDER", "x - ORDER"),  # two calls away
        ("SHARE = 2.0", "SHARE = 2.5"),
        ("SHARE = 2.0", "SHARE = 2"),
        ("[0, 1, 2]", "[1, 0, 2]"),
        ("[0, 1, 2]", "[0.0, 1.0, 2.0]"),
        ("np.sqrt", "np.cbrt"),
        ("n=2", "n=3"),
        ('["first", "second"]', '["second", "first"]'),
    ],
)
def test_what_is_compiled_counts(old: str, new: str) -> None:
    assert digest(changed(old, new)) != digest(TEXT)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("# a comment", "# another one"),
        ('"""A docstring."""', '"""Another one,\n    of two lines."""'),
        ("SHARE = 2.0", "\n\nSHARE = 2.0"),  # other lines
        ("OTHER = 1.0", "OTHER = 5.0"),  # which no kernel uses
        ("return OTHER * x", "return x"),
        ("def inner(x, n=2):", "def inner(x, n: int = 2) -> float:"),
        ("@njit\ndef outer", "@njit\ndef new(x):\n    return x\n\n@njit\ndef outer"),
    ],
)
def test_nothing_else_in_the_file_counts(old: str, new: str) -> None:
    assert digest(changed(old, new)) == digest(TEXT)


def test_the_compilers_options_and_what_a_name_stands_for_count() -> None:
    assert digest(TEXT, options="fast") != digest(TEXT)
    assert digest(TEXT, "inner") != digest(TEXT, "deepest")
    other = changed(
        "@njit\ndef deepest", "@njit\ndef other(x):\n    return x\n\n@njit\ndef deepest"
    )
    assert digest(other + "\ndeepest = other\n") != digest(other)


def test_what_is_defined_later_counts() -> None:
    """A kernel takes the values from when it is compiled."""
    assert digest(TEXT + "\nSHARE = 9.0\n") == digest(changed("SHARE = 2.0", "SHARE = 9.0"))


def test_functions_that_call_each_other_have_digests() -> None:
    first = "@njit\ndef outer(n):\n    return n if n < 1 else inner(n - 1)\n"
    text = first + "@njit\ndef inner(n):\n    return outer(n)\n"
    assert digest(text) != digest(text.replace("n - 1", "n - 2"))
    assert digest(text, "inner") != digest(text.replace("n - 1", "n - 2"), "inner")


def test_kernels_of_a_module_that_is_used_by_its_name_count() -> None:
    def of(body: str) -> str:
        module = types.ModuleType("helpers")
        exec(f"def helper(x):\n    return {body}", vars(module))
        names: dict[str, Any] = {"helpers": module, "__name__": "module_of_kernels"}
        exec("def outer(x):\n    return helpers.helper(x)", names)
        return sources_digest(names["outer"], "")

    assert of("x") == of("x") and of("x") != of("2 * x")


def test_closures_count() -> None:
    def made(factor: float) -> Callable[[float], float]:
        def scaled(x: float) -> float:
            return factor * x

        return scaled

    assert sources_digest(made(2.0), "") == sources_digest(made(2.0), "")
    assert sources_digest(made(2.0), "") != sources_digest(made(3.0), "")


def test_code_with_a_value_of_unknown_kind_is_never_found_again() -> None:
    text = "unknown = object()\n@njit\ndef outer(x):\n    return unknown\n"
    assert digest(text) != digest(text)


def test_fields_of_named_tuples_are_found_in_signatures() -> None:
    names: dict[str, Any] = {"__name__": "m"}
    exec("from collections import namedtuple\nPair = namedtuple('Pair', ['a', 'b'])", names)
    mixed = nb.NamedTuple([nb.float64, nb.int64], names["Pair"])
    uniform = nb.NamedUniTuple(nb.float64, 2, names["Pair"])
    found = layouts([nb.float64, mixed, nb.Tuple([uniform, nb.int64]), nb.UniTuple(mixed, 2)])
    assert found == ("m.Pair(a, b)",) * 3
    assert layouts([nb.Optional(mixed), nb.float64]) == ("m.Pair(a, b)",)


def test_a_method_is_not_what_has_its_name_in_the_file() -> None:
    """`from copy import copy` made every kernel that copies an array compile anew in each process."""
    text = "@njit\ndef outer(x):\n    return x.copy()\n"
    for other in ("from copy import copy", "copy = object()"):
        assert digest(f"{other}\n{text}") == digest(text)
