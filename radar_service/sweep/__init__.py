"""Sweeps: scenes, parameters and seeds in many runs, into one Zarr store.

`spec` reads what is wanted, and numbers the runs; `variables` says what is kept of each, `store` lays it out, `sweep` computes
all runs that are not finished, and writes their parts; `estimate` says what they will take.
"""
