"""Predicted errors of the numerical methods, and the cheapest settings that keep an error budget.

Errors of kernels and of the cut beam follow from their transforms and the pattern of this radar. Other errors are measured, and
their constants name the source. All errors are relative field errors [dB] over all echoes of a scene.
"""

import itertools
import math
from dataclasses import replace
from functools import lru_cache

import numpy as np
import scipy.fft

from radar_service.numerics import Floats
from radar_service.plan.budget import ErrorBudget
from radar_service.radar import ALIASES, KERNEL_WIDTHS, Radar, chirp_error_db, grid_rows, sampling_error_db
from radar_service.receive import Kernel, PulseKernel, azimuth_kernel, beam_spectrum, range_kernel, waveform_spectra
from radar_service.records import MIN_SCATTERERS, Fidelity
from radar_service.scattering import MAX_STRATA, density_db, scattering_model
from radar_service.stages.registry import has_paths
from radar_service.world import Scene

BEAM_KERNEL_WIDTHS = (4, 6)
EXTENTS = (1.5, 2.0, 3.0, 4.0, 6.0, 9.0, 12.0, 18.0, 27.0, math.inf)  # beamwidths each side
BLOCK_SIZES = (16, 1)  # azimuths per block: where range histories are interpolated at all, a block may be long
INTERPOLATED_DB, EXACT_DB = -61.5, -88.0  # chirps at 12 kn (tests/measurements/accuracy_table.py), and `reference` under way
MULTIPATH_DB = -62.0  # gains held over blocks where they hardly change, phases less (echo.sea_paths)
MULTIPATH_PEAK_DB = 4.3  # |F|^4 is 16 at its peaks and 6 on average over all phases
BEAM_TABLE_DB = {1: -78.0, 8: -96.0}  # by oversampling: docs/engine.md#errors, and 18 dB less for 8 times as many entries
RESTING_DB, MOVING_DB = -82.0, -88.0  # single precision and tables: chart of the harbour, `reference` under way
DENSITIES = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0)  # scatterers per cell; with a quarter of one targets are missed (chart)
KEPT_DB = 0.3  # rms error of power below which false echoes of ships have aspects of their own (docs/engine.md#errors)
VISIBILITY_STEPS = {1.0: 20.0, 0.2: 5.0, 0.0: 1.0}  # m, by the minimum budget [dB]: those of the three presets
ALIASING_MARGIN = 20.0  # dB that kernels keep: their aliases lie along the whole profile, beside still weaker targets
NEAR_BEST = 1.0  # dB: where no setting keeps the budget, the cheapest within this of the best


def combine_db(*errors_db: float) -> float:
    """The sum of independent relative errors [dB]."""
    return 10.0 * math.log10(sum(10.0 ** (error / 10.0) for error in errors_db))


def aliasing_db(kernel: Kernel, frequency: Floats, power: Floats) -> float:
    """Relative error [dB] of gridding points at random positions with a kernel.

    frequency, power: (F,) frequencies [cycles per sample] and the power spectrum of the points there. Each alias m adds
    |K(f + m) / K(f)|^2; their phases are independent.
    """
    own = kernel.transform(frequency) ** 2
    aliases = sum(kernel.transform(frequency + m) ** 2 for m in ALIASES)
    return float(10.0 * np.log10(np.sum(power * aliases / own) / np.sum(power)))


@lru_cache(maxsize=64)
def kernel_db(radar: Radar, width: int) -> float:
    """Relative error [dB] of echoes along range, sampled and gridded with a kernel of `width` bins.

    It holds what the samples fold of the pulse's spectrum. -inf where the pulse is the kernel.
    """
    kernel = range_kernel(radar, width)
    if isinstance(kernel, PulseKernel):
        return -math.inf
    if radar.modulation != "none":
        return chirp_error_db(radar, width)
    transmitted, filtered = waveform_spectra(radar)
    return sampling_error_db(lambda f: transmitted(f) * filtered(f), kernel.transform, radar.sample_rate)


@lru_cache(maxsize=64)
def beam_kernel_db(radar: Radar, width: int) -> float:
    """Relative error [dB] of gridding resting echoes along azimuth with a kernel of `width` rows."""
    beamwidth = radar.pattern.aperture_beamwidth(radar.beamwidth)
    rows = grid_rows(radar.azimuths, beamwidth)
    beam = beam_spectrum(lambda offset: radar.pattern.gain(offset, radar.beamwidth), rows)
    return aliasing_db(azimuth_kernel(beamwidth, rows, width), scipy.fft.fftfreq(rows), beam**2)


@lru_cache(maxsize=64)
def extent_db(radar: Radar, extent: float) -> float:
    """Relative error [dB] of a beam cut at `extent` beamwidths each side: the share of squared gain beyond."""
    if extent * radar.beamwidth >= math.pi:
        return -math.inf
    offset = np.linspace(0.0, math.pi, int(64 * math.pi / radar.beamwidth))  # 64 to a beamwidth: sidelobes are as wide
    power = radar.pattern.gain(offset, radar.beamwidth) ** 2
    beyond = np.sum(power[offset > extent * radar.beamwidth])
    return float(10.0 * np.log10(beyond / np.sum(power))) if beyond > 0.0 else -math.inf


def resting_db(radar: Radar, fidelity: Fidelity) -> float:
    """Predicted relative field error [dB] of resting echoes."""
    kernel, beam = kernel_db(radar, fidelity.kernel_width), beam_kernel_db(radar, fidelity.beam_kernel_width)
    return combine_db(RESTING_DB, kernel, beam)


def moving_db(radar: Radar, fidelity: Fidelity) -> float:
    """Predicted relative field error [dB] of moving echoes."""
    kernel, beam = kernel_db(radar, fidelity.kernel_width), extent_db(radar, fidelity.beam_extent)
    return combine_db(MOVING_DB, motion_db(fidelity), kernel, beam)


def motion_db(fidelity: Fidelity) -> float:
    """Predicted relative field error [dB] of range histories and of the beam table."""
    history = INTERPOLATED_DB if fidelity.azimuths_per_block > 1 else EXACT_DB
    return combine_db(history, BEAM_TABLE_DB[8 if fidelity.beam_table_oversampling >= 8 else 1])


def multipath_db(scene: Scene, fidelity: Fidelity) -> float:
    """Predicted relative field error [dB] of sea reflection on moving echoes, at any time of a run.

    It is relative to the rms field of the lobe: the beam is cut where sea reflection may be at its peak, while the target is in a
    null on boresight. It is -inf without multipath or motion, and where each azimuth is computed by itself with the full circle
    of the beam.
    """
    if not scene.environment.multipath or all_rests(scene):
        return -math.inf
    held = MULTIPATH_DB if fidelity.azimuths_per_block > 1 else -math.inf
    total = 10.0 ** (held / 10.0) + 10.0 ** ((extent_db(scene.radar, fidelity.beam_extent) + MULTIPATH_PEAK_DB) / 10.0)
    return 10.0 * math.log10(total) if total > 0.0 else -math.inf


def _min_scatterers(scene: Scene, budget: ErrorBudget) -> int:
    """Scatterers that keep the budget on any surface of the scene, at least those of `balanced`."""
    multipath = scene.environment.multipath
    models = {scattering_model(body) for body in scene.bodies if body.mesh is not None}
    for count in range(MIN_SCATTERERS, MAX_STRATA):
        if all(model.sampling_db(count, multipath) <= budget.target_db for model in models):
            return count
    return MAX_STRATA


def fidelity_for(scene: Scene, budget: ErrorBudget) -> Fidelity:
    """The cheapest fidelity that keeps the budget in this scene, or nearly the most accurate one where none does.

    The result depends on the scene and the budget alone. Settings that the scene does not need are those of `balanced`.
    """
    chosen = Fidelity(
        "auto",
        scatterers_per_cell=next((n for n in DENSITIES if density_db(n) <= budget.target_db), DENSITIES[-1]),
        min_scatterers=_min_scatterers(scene, budget),
        visibility_step=next(step for minimum, step in VISIBILITY_STEPS.items() if budget.target_db >= minimum),
        held_false_echoes=budget.target_db >= KEPT_DB,
        bounces=2 if budget.target_db > 1.0 else 3,
        error_db=budget.target_db,
    )
    radar = scene.radar
    along_range = KERNEL_WIDTHS[1:] if all_rests(scene) else KERNEL_WIDTHS  # wide ones are cheap for echoes gridded once
    widths = itertools.product(along_range, BEAM_KERNEL_WIDTHS)
    kernels = [replace(chosen, kernel_width=along, beam_kernel_width=around) for along, around in widths]
    errors = [resting_db(radar, choice) for choice in kernels]
    chosen = _cheapest(radar, kernels, errors, budget.method_db - ALIASING_MARGIN)
    if all_rests(scene):
        return chosen
    beams = [
        replace(chosen, beam_extent=extent, azimuths_per_block=size, beam_table_oversampling=oversampling)
        for extent, size, oversampling in itertools.product(EXTENTS, BLOCK_SIZES, BEAM_TABLE_DB)
    ]
    errors = [max(moving_db(radar, choice), multipath_db(scene, choice) - MULTIPATH_PEAK_DB) for choice in beams]
    return _cheapest(radar, beams, errors, budget.method_db)


def _cheapest(radar: Radar, choices: list[Fidelity], errors: list[float], allowed: float) -> Fidelity:
    """The cheapest choice with an error of at most `allowed` [dB], or within NEAR_BEST of the best one."""
    limit = max(allowed, min(errors) + NEAR_BEST)
    kept = [choice for choice, error in zip(choices, errors, strict=True) if error <= limit]
    return min(kept, key=lambda choice: relative_cost(radar, choice))


def relative_cost(radar: Radar, fidelity: Fidelity) -> float:
    """Mean cost of gridding a moving echo in a scan, in any unit; it only orders settings.

    It is the beam's share of the scan times a cost per echo and azimuth: 80 for each range history, which a block shares, and
    1 for each bin of the kernel (measured, in about 20 ns). Small terms for the other settings decide ties.
    """
    span = (fidelity.azimuths_per_block - 1) * radar.azimuth_step
    beam = min(2.0 * math.pi, 2.0 * fidelity.beam_extent * radar.beamwidth + span)
    each = 80.0 / fidelity.azimuths_per_block
    return beam * (each + fidelity.kernel_width + 0.1 * fidelity.beam_kernel_width + 0.01 * fidelity.beam_table_oversampling)


def all_rests(scene: Scene) -> bool:
    """Whether all echoes are gridded once: nothing moves relative to the antenna, and nothing fluctuates."""
    still = scene.own_ship.at_rest and not has_paths(scene.radar)
    return still and all(body.at_rest and body.swerling == 0 for body in scene.bodies)
