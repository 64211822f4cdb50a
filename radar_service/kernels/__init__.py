"""Kernels in C for the innermost loops of the engine, their build, and the functions that check their arguments."""
