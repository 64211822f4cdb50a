"""Each source of a scene by itself: the engine runs with all other bodies silent, and without noise and the other effects.

Bodies stay in place, so shadows do too; so do rain and sea, which attenuate and reflect what bodies return.
"""

from collections.abc import Collection
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import radar_service as rs
from radar_service.engine.pipeline import Engine
from radar_service.engine.preparation import Prepared, prepare
from radar_service.engine.source_numbers import INTERFERENCE, NOISE, RAIN, SEA, SECOND_TIME_AROUND, source_numbers
from radar_service.fidelity import PRESETS
from radar_service.receive.compression import receiver_noise_power

Fields = NDArray[np.complexfloating[Any, Any]]
Powers = dict[int, NDArray[np.float64]]
ROUNDING = 1e-14  # of the peak of a profile: the square of the relative precision of a float32, 6e-8, is 4e-15


def prepared_quiet(made: rs.Scene, silent: Collection[int], seed: int = 0) -> Prepared:
    """The engine of a scene without noise, clutter, interference and the echoes of silent bodies."""
    without_noise = made.with_world(environment=replace(made.environment, noise=False))
    return replace(prepare(without_noise, PRESETS["balanced"], seed, silent), clutter=None, interference=())


def field_of(prepared: Prepared, scan: int) -> Fields:
    """The field (A, N) of one scan."""
    return np.concatenate([field for _, field, _ in Engine(prepared).tiles(scan)])


def body_field(made: rs.Scene, scan: int, bodies: Collection[int], seed: int = 0) -> Fields:
    """The field of some bodies alone, echoes of earlier pulses among them where the radar has any."""
    return field_of(prepared_quiet(made, [k for k in range(len(made.bodies)) if k not in bodies], seed), scan)


def first_pulse(made: rs.Scene) -> rs.Scene:
    """The scene whose radar receives echoes of its last pulse alone."""
    return replace(made, radar=replace(made.radar, second_time_around=False))


def powers_alone(made: rs.Scene, scan: int, seed: int = 0) -> Powers:
    """The power (A, N) [W] of each source of a scene in one scan, by source number."""
    every, numbers = range(len(made.bodies)), source_numbers(made)[:-1]
    fields: dict[int, Fields] = {}
    later: Fields = np.zeros((made.radar.azimuths, made.radar.bins), dtype=np.complex64)
    for number in np.unique(numbers).tolist():
        bodies = np.flatnonzero(numbers == number).tolist()
        fields[number] = body_field(first_pulse(made), scan, bodies, seed)
        if made.radar.second_time_around:
            later += body_field(made, scan, bodies, seed) - fields[number]
    fields[SECOND_TIME_AROUND] = later
    nothing, full = prepared_quiet(made, every, seed), prepare(made, PRESETS["balanced"], seed, every)
    if full.clutter is not None:
        sea_alone = replace(full.clutter, rain=np.zeros(0, dtype=np.float32))
        fields[SEA] = field_of(replace(nothing, clutter=sea_alone), scan)
        fields[RAIN] = field_of(replace(nothing, clutter=replace(full.clutter, sea=None)), scan)
    fields[INTERFERENCE] = field_of(replace(nothing, interference=full.interference), scan)
    noise = receiver_noise_power(made.radar) if made.environment.noise else 0.0
    powers = {number: np.abs(field.astype(np.complex128)) ** 2 for number, field in fields.items()}
    return {NOISE: np.full((made.radar.azimuths, made.radar.bins), noise)} | powers


def agreement(labels: NDArray[np.uint32], powers: Powers) -> tuple[float, float]:
    """The share of cells whose label is the strongest source, of those where it leads by 3 dB; and how many these are of all.

    Without noise there are cells in which the strongest source has but the rounding of its transforms: they do not count.
    """
    numbers, stacked = np.array(list(powers)), np.stack(list(powers.values()))
    strongest = stacked.argmax(axis=0)
    ordered = np.sort(stacked, axis=0)
    peak = stacked.max(axis=2)[strongest, np.arange(len(labels))[:, None]]  # of the same source in the same azimuth
    leads = (ordered[-1] > 10.0**0.3 * ordered[-2]) & (ordered[-1] > ROUNDING * peak)
    return float(np.mean(labels[leads] == numbers[strongest][leads])), float(leads.mean())
