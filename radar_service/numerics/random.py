"""Random numbers that depend on their purpose alone, not on the time or the order of the draws."""

import hashlib
from functools import cache

import numpy as np

from radar_service.numerics.types import Singles

SCATTER, NOISE, FLUCTUATION, RAYS, CAST = 1, 2, 3, 4, 5  # purposes, the first key after the seed
SPECKLE, TEXTURE = 21, 22
ORDER_STATISTIC = 41  # purpose of the factor of OS-CFAR
SCENARIO = 42  # purpose of the starts of targets in the test bench
PLOT_ERRORS = 43  # purpose of the errors of plots in the test bench
BIASES = 44  # purpose of the signs of the biases of sensors in the test bench
SEAWAY, LEAN = 45, 46  # purposes of the waves of a seaway, and of the lists and trims of ships
HULL_PARTS = 47  # purpose of the parts of hulls
SWEEP_SEED, SWEEP_LIST, SWEEP_DRAW = 48, 49, 50  # purposes of seeds of runs, of drawn lists, of draws of each run
SENSOR, FEED = 31, 32  # errors on purpose
NEAR_PULSE = 25  # noise and speckle of the pulses of a radar that serve nearer ranges
STAGE = 51  # purpose of effects of other packages, each by its name; 23 and 26 are those of effects here
CHART = 40  # purpose of the study of speed against accuracy
_LEVELS = 2**16  # of a normal number; the outermost is at 4.3 sigma
_WORD = 2**64  # each key is one 64-bit word, so (2**32,) and (0, 1) differ


def generator(seed: int, *key: int) -> np.random.Generator:
    """A generator for one purpose: the same seed and key always give the same stream, another key gives an independent one.

    seed, key: whole numbers from 0 to 2**64 - 1, e.g. generator(seed, scan, azimuth, purpose). Raises ValueError otherwise.
    """
    # SeedSequence pads short entropy with zeros, so () and (0,) would be one stream without the length in front.
    words = [len(key)]
    for n, value in enumerate((seed, *key)):
        if not 0 <= value < _WORD:
            name = f"key[{n - 1}]" if n else "seed"
            raise ValueError(f"{name}: {value} is not allowed; a whole number from 0 to {_WORD - 1}")
        words += [int(value) & 0xFFFFFFFF, int(value) >> 32]
    entropy = np.array(words, dtype=np.uint32)  # a list of them takes six times as long
    return np.random.Generator(np.random.SFC64(np.random.SeedSequence(entropy)))


def name_key(*names: str) -> int:
    """A key of `generator` that depends on these names alone: 64 bits of their BLAKE2b hash, the same on every machine."""
    text = b"".join(
        len(name.encode()).to_bytes(8, "big") + name.encode() for name in names
    )  # so ("ab", "") is not ("a", "b")
    return int.from_bytes(hashlib.blake2b(text, digest_size=8).digest(), "big")


def normals(rng: np.random.Generator, rows: int, columns: int) -> Singles:
    """Independent numbers (rows, columns) of mean 0 and variance 1, each the middle of one of 65,536 equally likely slices of
    the normal distribution.

    They are eight times faster than exact ones, and as good where many are summed, as in spectra. Their fourth moment is
    3 - 0.001.
    """
    count = rows * columns
    words = np.asarray(rng.bit_generator.random_raw(-(-count // 4)), dtype=np.uint64)
    return quantiles().take(words.view(np.uint16)[:count], mode="clip").reshape(rows, columns)


@cache
def quantiles() -> Singles:
    """The middles (65536,) of the slices."""
    from scipy.special import ndtri  # a service that only knows scenes starts without it

    middle = ndtri((np.arange(_LEVELS) + 0.5) / _LEVELS)
    return np.asarray(middle / np.sqrt(np.mean(middle**2)), dtype=np.float32)
