"""Arithmetic that all share: constants, types, frames of reference, random numbers, threads, caches."""
