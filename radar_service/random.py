"""Random numbers that depend on what they are for, never on when or in which order they are drawn."""

import numpy as np

SCATTER, NOISE, FLUCTUATION, RAYS, CAST = 1, 2, 3, 4, 5  # purposes, the first key after the seed
SPECKLE, TEXTURE, INTERFERENCE = 21, 22, 23
CHART = 40  # draws of the study of speed against accuracy
_WORD = 2**64  # each key is one 64-bit word, so (2**32,) and (0, 1) cannot meet


def generator(seed: int, *key: int) -> np.random.Generator:
    """A generator for one purpose: the same seed and key always give the same stream, another key an independent one.

    seed, key: whole numbers from 0 to 2**64 - 1, e.g. generator(seed, scan, azimuth, purpose). Raises ValueError otherwise.
    """
    for name, value in (("seed", seed), *((f"key[{i}]", k) for i, k in enumerate(key))):
        if not 0 <= value < _WORD:
            raise ValueError(f"{name}: {value} is not allowed; a whole number from 0 to {_WORD - 1}")
    # SeedSequence pads short entropy with zeros, so () and (0,) would be one stream without the length in front.
    words = [len(key)]
    for value in (seed, *key):
        words += [int(value) & 0xFFFFFFFF, int(value) >> 32]
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(words)))
