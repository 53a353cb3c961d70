"""What kernels need of the kernels that they call: LLVM's intermediate representation, beside machine code.

It is three times as large as the machine code and compresses badly. The shipped code of a kernel that no
other kernel calls is without it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from llvmlite import binding
from numba.core.errors import NumbaError

from tauten.model.kernels.seed import OFF, SEED

NONE = b""


def without_ir(reduced: tuple[Any, ...]) -> tuple[Any, ...]:
    """A compiled kernel, as numba reduces it to what can be pickled, without intermediate representation."""
    (name, kind, (code, _)), *rest = reduced
    return (name, kind, (code, NONE)), *rest


def has_ir(reduced: tuple[Any, ...]) -> bool:
    """Whether a compiled kernel, as numba reduces it, has what callers need."""
    found: bool = reduced[0][2][1] != NONE
    return found


def rebuilt(rebuild: Callable[..., Any], context: Any, reduced: tuple[Any, ...]) -> Any:
    """The compiled kernel; compiling a kernel that calls one `without_ir` raises a `NumbaError`."""
    (name, kind, data), described, *rest = reduced
    if kind != "object" or data[1] != NONE:
        return rebuild(context, reduced)
    # numba finds in machine code only the functions whose names the representation defines
    ways_in = (described.llvm_cpython_wrapper_name, described.llvm_cfunc_wrapper_name)
    functions = "".join(f'define void @"{one}"() {{ ret void }}\n' for one in ways_in)
    ir = binding.parse_assembly(functions).as_bitcode()
    result = rebuild(context, ((name, kind, (data[0], ir)), described, *rest))

    def refuse() -> None:
        raise NumbaError(
            f"{name} is shipped for calls from Python only: set {SEED}={OFF} to compile kernels that call it"
        )

    result.library._get_module_for_linking = refuse
    return result
