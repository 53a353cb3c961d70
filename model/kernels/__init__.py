"""Machine code of kernels on disk: which processor it is for, what it depends on, where it is kept."""

from tauten.model.kernels.cache import KernelCache
from tauten.model.kernels.files import kernel_folder
from tauten.model.kernels.names import names_of_this_process
from tauten.model.kernels.packing import gather, used_archive
from tauten.model.kernels.seed import OFF, SEED, SHIPPED, SUFFIX, open_seed, seed_file, seed_name
from tauten.model.kernels.target import compiled_machine, portable_code, portable_machine

__all__ = [
    "KernelCache",
    "OFF",
    "SEED",
    "SHIPPED",
    "SUFFIX",
    "compiled_machine",
    "gather",
    "kernel_folder",
    "names_of_this_process",
    "open_seed",
    "portable_code",
    "portable_machine",
    "seed_file",
    "seed_name",
    "used_archive",
]
