"""Sweeps: scenes, parameters and seeds in many runs, into one Zarr store.

`spec` reads what is wanted, `runs` numbers the runs, `variables` says what is kept of each, `store` lays it out, `task` computes
a run and writes its part, `sweep` does so for all that are not finished, `estimate` says what it will take.
"""
