"""Compiled kernels against the numpy code beside their calls."""
