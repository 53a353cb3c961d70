"""Machine code of kernels on disk: which processor it is for, what it depends on, where it is kept."""

from tauten.model.kernels.cache import KernelCache
from tauten.model.kernels.target import portable_code

__all__ = ["KernelCache", "portable_code"]
