"""Benchmarks that measure tauten for those who make it; no part of the package.

`python -m benchmarks` in the root of the repository lists them.
"""
