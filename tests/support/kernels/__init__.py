"""Kernels that tests compile."""
