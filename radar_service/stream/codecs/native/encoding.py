"""The encodings of samples in the native feed: what a display shows (u8), and four that are untouched by its controls."""

import math

import numpy as np
from numpy.typing import NDArray

from radar_service.display.video import (
    DB_PER_STEP,
    Controls,
    Layout,
    decibels,
    display_video,
    noise_threshold_db,
    peaks,
    quantise,
    strongest,
)
from radar_service.types import Profiles, Singles

LOG_DB_PER_STEP = 0.5  # of u8-log: 127 dB, from below the noise to a ship alongside
SCALE_BELOW_NOISE_DB = 20.0  # u8-log begins this far below the mean noise, so that noise keeps its distribution


def log_offset_db(noise_power: float) -> float:
    """Level [dBW] of byte 0 of u8-log, a whole number of dB."""
    return math.floor(10.0 * math.log10(noise_power) - SCALE_BELOW_NOISE_DB)


def scale(encoding: str, noise_power: float) -> dict[str, float]:
    """`db_per_step` and `offset_db` [dBW], so that byte b > 0 is the middle of its step, of the encodings in steps."""
    if encoding == "u8":
        return {"db_per_step": DB_PER_STEP, "offset_db": noise_threshold_db(noise_power) - 0.5 * DB_PER_STEP}
    if encoding == "u8-log":
        return {"db_per_step": LOG_DB_PER_STEP, "offset_db": log_offset_db(noise_power)}
    return {}


def encode(
    encoding: str,
    power: Singles,
    field: Profiles,
    to: Layout,
    controls: Controls,
    noise_power: float,
    before: Singles | None = None,
    earlier: Singles | None = None,
) -> NDArray[np.generic]:
    """Cells (K, N) as samples (K, bins) in one of the encodings of `wire.DTYPES`.

    power [W] and field [sqrt(W)] are of the same cells; noise_power [W] is the reference of the byte scales; before: (N,) power
    of the spoke before the first one [W], None where it is not known; earlier: see `display_video`.
    """
    if encoding == "u8":
        return display_video(power, to, controls, noise_power, before, earlier)
    if encoding == "c64":
        return strongest(field, to).astype("<c8")
    top = peaks(power, to)
    if encoding == "u8-log":
        return quantise(decibels(top), log_offset_db(noise_power), LOG_DB_PER_STEP)
    if encoding == "f16":
        return decibels(top).astype("<f2")
    if encoding == "f32":
        return top.astype("<f4")
    raise ValueError(f'encoding: "{encoding}" is not one of u8, u8-log, f16, f32, c64')
