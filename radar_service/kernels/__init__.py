"""Kernels in C for the innermost loops of the engine, who compiles them in every build, and the checked functions of them."""
