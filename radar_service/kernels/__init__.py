"""Kernels in C for the innermost loops of the engine. Each stands beside numpy code that does the same where there are none."""
