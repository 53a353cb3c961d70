"""What the machine code of a kernel depends on, as a digest.

That is what Python compiled of the kernel and of every kernel that it reaches, the constants and the named
tuples that they use, the compiler's options and numba's version. Comments, docstrings, annotations, line
numbers and whatever else is in the same file do not count.
"""

from __future__ import annotations

import dis
import enum
import hashlib
import uuid
from collections.abc import Callable, Iterable
from functools import cache
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any

import numba
import numpy as np
from numba.core import types
from numba.core.dispatcher import Dispatcher

from tauten.model.kernels.names import NUMBERING

# What numba compiles these to is its own.
LIBRARIES = ("numpy", "math", "cmath", "numba", "builtins")


def sources_digest(function: Callable[..., Any], options: str) -> str:
    """SHA-256 over all that the machine code of a function depends on, except the types of its arguments.

    It has to be called where all that the function uses is defined, as when it is compiled: numba takes the
    values from that time.
    """
    found = ((full_name(one), _own(one)) for one in _reached(function))
    parts = [numba.__version__, NUMBERING, options, full_name(function), *sorted(found)]
    return hashlib.sha256(repr(parts).encode()).hexdigest()


def callees(function: Callable[..., Any]) -> frozenset[str]:
    """Full names of all functions that a kernel calls, directly or not."""
    return frozenset(full_name(one) for one in _reached(function) if one is not function)


def _reached(function: Callable[..., Any]) -> list[Callable[..., Any]]:
    """A function and all that are compiled into it."""
    found: dict[int, Callable[..., Any]] = {}
    waiting = [function]
    while waiting:
        one = waiting.pop()
        if id(one) not in found:
            found[id(one)] = one
            waiting += [_function(value) for value in _used(one).values() if _is_function(value)]
    return list(found.values())


def layouts(signature: Iterable[Any]) -> tuple[str, ...]:
    """Fields of all named tuples among types of arguments: numba compares such types by their names."""
    found: list[str] = []
    for one in signature:
        if isinstance(one, types.NamedTuple | types.NamedUniTuple):
            found.append(_layout(one.instance_class))
        if isinstance(one, types.Tuple | types.NamedTuple):
            found += layouts(one.types)
        elif isinstance(one, types.UniTuple | types.NamedUniTuple):
            found += layouts([one.dtype])
        elif isinstance(one, types.Optional):
            found += layouts([one.type])
    return tuple(found)


@cache
def _own(function: Callable[..., Any]) -> str:
    """What a function contains itself, and what it calls by which name."""
    code = function.__code__
    uses = [(name, _described(value)) for name, value in sorted(_used(function).items())]
    defaults = getattr(function, "__defaults__", None), getattr(function, "__kwdefaults__", None)
    return repr((_of_code(code, function.__doc__), uses, defaults))


def _of_code(code: CodeType, doc: str | None = None) -> tuple[object, ...]:
    """What Python compiled, without names of files, line numbers and the docstring."""
    constants = list(code.co_consts)
    if doc is not None and constants and constants[0] == doc:
        constants[0] = None
    arguments = code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_flags
    return (
        code.co_code, getattr(code, "co_exceptiontable", b""), arguments, code.co_names,
        code.co_varnames, code.co_freevars, code.co_cellvars, [_constant(one) for one in constants],
    )  # fmt: skip


def _constant(value: object) -> object:
    if isinstance(value, CodeType):
        return _of_code(value)
    return (
        sorted(map(repr, value)) if isinstance(value, frozenset) else (type(value).__name__, value)
    )


def _used(function: Callable[..., Any]) -> dict[str, Any]:
    """Values outside of a function that its code names, and what it may name of modules among them."""
    names, values = _names(function.__code__), function.__globals__
    found = {name: values[name] for name in _globals(function.__code__) if name in values}
    cells = getattr(function, "__closure__", None) or ()
    for name, cell in zip(function.__code__.co_freevars, cells, strict=True):
        found[name] = cell.cell_contents
    modules = [(name, value) for name, value in found.items() if isinstance(value, ModuleType)]
    for path, module in modules:  # grows by modules inside
        if not _in_library(module.__name__):
            inside = {
                f"{path}.{name}": getattr(module, name) for name in names if hasattr(module, name)
            }
            modules += [item for item in inside.items() if isinstance(item[1], ModuleType)]
            found.update(inside)
    return found


def _names(code: CodeType) -> set[str]:
    inner = (_names(one) for one in code.co_consts if isinstance(one, CodeType))
    return set(code.co_names).union(*inner)


@cache
def _globals(code: CodeType) -> frozenset[str]:
    """Names that code loads from its module: `co_names` has those of attributes and methods too."""
    inner = (_globals(one) for one in code.co_consts if isinstance(one, CodeType))
    loaded = (one.argval for one in dis.get_instructions(code) if one.opname == "LOAD_GLOBAL")
    return frozenset(loaded).union(*inner)


def _described(value: object) -> str:
    """What compiled code takes over from a value."""
    if _is_function(value):
        return full_name(_function(value))  # its content is in the digest on its own
    if isinstance(value, np.ndarray | np.generic):
        return f"{value.dtype} {value.shape} {hashlib.sha256(value.tobytes()).hexdigest()}"
    if isinstance(value, tuple):
        return f"({', '.join(_described(entry) for entry in value)})"
    if value is None or isinstance(value, bool | int | float | complex | str | bytes):
        return repr(value)
    if isinstance(value, type):
        return _class(value)
    if isinstance(value, types.Type | np.dtype):
        return repr(value)
    if isinstance(value, ModuleType):
        return value.__name__  # what is used of it is in the digest on its own
    if isinstance(value, BuiltinFunctionType | np.ufunc) or _of_library(value):
        return f"{getattr(value, '__module__', '')}.{getattr(value, '__name__', value)}"
    return uuid.uuid4().hex  # never the same: code that contains it is not found again


def _class(value: type) -> str:
    if hasattr(value, "_fields"):
        return _layout(value)
    if issubclass(value, enum.Enum):
        return f"{value.__qualname__} {[(one.name, one.value) for one in value]}"
    return f"{value.__module__}.{value.__qualname__}"


def _layout(tuple_type: Any) -> str:
    """Name and fields of a named tuple, in order; their types are in the signatures."""
    return f"{tuple_type.__module__}.{tuple_type.__qualname__}({', '.join(tuple_type._fields)})"


def _is_function(value: object) -> bool:
    """Whether a value is compiled into what calls it."""
    return isinstance(value, Dispatcher | FunctionType) and not _of_library(value)


def _of_library(value: object) -> bool:
    return _in_library(str(getattr(value, "__module__", "")))


def _in_library(module: str) -> bool:
    return module.split(".")[0] in LIBRARIES


def _function(value: Any) -> Callable[..., Any]:
    function: Callable[..., Any] = value.py_func if isinstance(value, Dispatcher) else value
    return function


def full_name(function: Callable[..., Any]) -> str:
    """Name with the module; cached code refers so to the kernels that it calls."""
    return f"{function.__module__}.{function.__qualname__}"
