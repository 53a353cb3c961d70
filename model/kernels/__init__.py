"""Machine code of kernels on disk: which processor it is for, what it depends on, where it is kept."""

from tauten.model.kernels.cache import KernelCache, KernelCacheFile, SeedFile
from tauten.model.kernels.files import kernel_folder, make_folder
from tauten.model.kernels.linking import has_ir, without_ir
from tauten.model.kernels.names import names_of_this_process
from tauten.model.kernels.seed import (
    OFF,
    SEED,
    SHIPPED,
    SUFFIX,
    Seed,
    open_seed,
    pack,
    seed_file,
    seed_name,
)
from tauten.model.kernels.target import compiled_machine, portable_code, portable_machine

__all__ = [
    "KernelCache",
    "KernelCacheFile",
    "OFF",
    "SEED",
    "SHIPPED",
    "SUFFIX",
    "Seed",
    "SeedFile",
    "compiled_machine",
    "has_ir",
    "kernel_folder",
    "make_folder",
    "names_of_this_process",
    "open_seed",
    "pack",
    "portable_code",
    "portable_machine",
    "seed_file",
    "seed_name",
    "without_ir",
]
