"""Predicted errors of the numerical methods, and the cheapest settings that keep a budget.

Kernels and the cut beam are predicted from their transforms and the pattern, for this radar; what has no such law was
measured, and says where. Errors are relative field errors [dB] over all echoes of a scene.
"""

import itertools
import math
from dataclasses import replace
from functools import lru_cache

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from radar_service.fidelity import MIN_SCATTERERS, Fidelity
from radar_service.plan.budget import ErrorBudget
from radar_service.plan.multipath_error import multipath_error_db
from radar_service.radar.antenna import grid_rows
from radar_service.radar.parameters import Radar
from radar_service.receive.beam import azimuth_kernel, beam_spectrum
from radar_service.receive.compression import range_kernel, waveform_spectra
from radar_service.receive.gridding import Kernel
from radar_service.receive.plain_pulse import PulseKernel
from radar_service.scattering.fixed_scatterers import FixedScatterers, density_db, surface_db
from radar_service.scattering.models import scattering_model
from radar_service.scene.world import Scene

Floats = NDArray[np.float64]

KERNEL_WIDTHS, BEAM_KERNEL_WIDTHS = (4, 6, 8), (4, 6)
EXTENTS = (1.5, 2.0, 3.0, 4.0, 6.0, 9.0, 12.0, 18.0, 27.0, math.inf)  # beamwidths each side
SWEPT = (16, 8, 4, 2, 1)  # azimuths together
COURSES, BY_ITSELF = -61.5, -88.0  # chirps at 12 kn (tests/bench/accuracy_table.py), and `reference` under way
FINENESS = {1: -78.0, 8: -96.0}  # of the beam's table: DESIGN section 4, and 18 dB less for 8 times as many entries
AT_REST, MOVING = -82.0, -88.0  # single precision and tables: chart of the harbour, `reference` under way
DENSITIES = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0)  # scatterers per cell; with a quarter of one targets are missed (chart)
MOST_FEWEST = 4096  # points on the smallest surface: 0.2 dB among the lobes of the sea's mirror
GLANCES = {1.0: 20.0, 0.2: 5.0, 0.0: 1.0}  # m between looks from a budget [dB] on: those of the three presets
FREQUENCIES = 4096  # at which spectra are compared
ALIASING_MARGIN = 20.0  # dB that kernels keep: their aliases lie along the whole profile, beside still weaker targets
NEARLY_BEST = 1.0  # dB: where no setting keeps the budget, the cheapest so near to the best
ALIASES = tuple(m for m in range(-4, 5) if m)  # the kernels' transforms fall off: further ones change nothing


def combine_db(*errors_db: float) -> float:
    """Independent relative errors [dB] as one."""
    return 10.0 * math.log10(sum(10.0 ** (error / 10.0) for error in errors_db))


def aliasing_db(kernel: Kernel, frequency: Floats, power: Floats) -> float:
    """Relative error [dB] of points laid with a kernel at random places, whose spectrum has this power (F,) at frequencies
    (F,) [cycles per sample]: what every alias m adds, |K(f + m) / K(f)|^2, none of which knows the others' phases."""
    own = kernel.transform(frequency) ** 2
    aliases = sum(kernel.transform(frequency + m) ** 2 for m in ALIASES)
    return float(10.0 * np.log10(np.sum(power * aliases / own) / np.sum(power)))


@lru_cache(maxsize=64)
def kernel_db(radar: Radar, width: int) -> float:
    """Relative error [dB] of laying echoes along range with a kernel of `width` bins; -inf where the pulse itself is laid."""
    kernel = range_kernel(radar, width)
    if isinstance(kernel, PulseKernel):
        return -math.inf
    frequency = scipy.fft.fftfreq(FREQUENCIES)
    sent, passed = waveform_spectra(radar)
    spectrum = sent(frequency * radar.sample_rate) * passed(frequency * radar.sample_rate)
    return aliasing_db(kernel, frequency, np.abs(spectrum) ** 2)


@lru_cache(maxsize=64)
def beam_kernel_db(radar: Radar, width: int) -> float:
    """Relative error [dB] of laying echoes at rest along azimuth with a kernel of `width` rows."""
    beamwidth = radar.pattern.aperture_beamwidth(radar.beamwidth)
    rows = grid_rows(radar.azimuths, beamwidth)
    beam = beam_spectrum(lambda offset: radar.pattern.gain(offset, radar.beamwidth), rows)
    return aliasing_db(azimuth_kernel(beamwidth, rows, width), scipy.fft.fftfreq(rows), beam**2)


@lru_cache(maxsize=64)
def extent_db(radar: Radar, extent: float) -> float:
    """Relative error [dB] of a beam cut `extent` beamwidths each side: its share of the squared two-way gain beyond."""
    if extent * radar.beamwidth >= math.pi:
        return -math.inf
    offset = np.linspace(0.0, math.pi, int(64 * math.pi / radar.beamwidth))  # 64 to a beamwidth: sidelobes are as wide
    power = radar.pattern.gain(offset, radar.beamwidth) ** 2
    beyond = np.sum(power[offset > extent * radar.beamwidth])
    return float(10.0 * np.log10(beyond / np.sum(power))) if beyond > 0.0 else -math.inf


def resting_db(radar: Radar, fidelity: Fidelity) -> float:
    """Predicted relative field error [dB] of echoes at rest."""
    return combine_db(AT_REST, kernel_db(radar, fidelity.kernel_width), beam_kernel_db(radar, fidelity.beam_kernel_width))


def moving_db(radar: Radar, fidelity: Fidelity) -> float:
    """Predicted relative field error [dB] of moving echoes."""
    kernel, beam = kernel_db(radar, fidelity.kernel_width), extent_db(radar, fidelity.beam_extent)
    return combine_db(MOVING, motion_db(fidelity), kernel, beam)


def motion_db(fidelity: Fidelity) -> float:
    """Predicted relative field error [dB] of following what moves."""
    swept = COURSES if fidelity.azimuths_per_block > 1 else BY_ITSELF
    return combine_db(swept, FINENESS[8 if fidelity.beam_table_oversampling >= 8 else 1])


def _fewest(scene: Scene, budget: ErrorBudget) -> int:
    """Points that keep the budget on any surface of the scene, at least those of `balanced`."""
    mirrored = scene.environment.multipath
    surfaces = [
        body for body in scene.bodies if body.mesh is not None and issubclass(scattering_model(body), FixedScatterers)
    ]
    if not any(body.rcs is None or mirrored for body in surfaces):  # a declared cross-section is shared out exactly
        return MIN_SCATTERERS
    return int(np.clip(math.ceil((surface_db(1.0, mirrored) / budget.target_db) ** 2), MIN_SCATTERERS, MOST_FEWEST))


def fidelity_for(scene: Scene, budget: ErrorBudget) -> Fidelity:
    """The cheapest fidelity that keeps the budget in this scene, or nearly the most accurate one where none does. It
    depends on the scene and the budget alone. What the scene does not need stays as in `balanced`."""
    chosen = Fidelity(
        "auto",
        scatterers_per_cell=next((n for n in DENSITIES if density_db(n) <= budget.target_db), DENSITIES[-1]),
        min_scatterers=_fewest(scene, budget),
        visibility_step=next(visibility_step for least, visibility_step in GLANCES.items() if budget.target_db >= least),
        bounces=2 if budget.target_db > 1.0 else 3,
        error_db=budget.target_db,
    )
    radar = scene.radar
    along_range = KERNEL_WIDTHS[1:] if all_rests(scene) else KERNEL_WIDTHS  # those of echoes laid once cost nothing later
    widths = itertools.product(along_range, BEAM_KERNEL_WIDTHS)
    kernels = [replace(chosen, kernel_width=along, beam_kernel_width=around) for along, around in widths]
    chosen = _cheapest(radar, kernels, [resting_db(radar, choice) for choice in kernels], budget.method_db - ALIASING_MARGIN)
    if all_rests(scene):
        return chosen
    kept = [swept for swept in SWEPT if swept == 1 or multipath_error_db(scene, swept) <= budget.field_db]
    reaches = itertools.product(EXTENTS, kept, FINENESS)
    beams = [
        replace(chosen, beam_extent=reach, azimuths_per_block=swept, beam_table_oversampling=fine)
        for reach, swept, fine in reaches
    ]
    return _cheapest(radar, beams, [moving_db(radar, choice) for choice in beams], budget.method_db)


def _cheapest(radar: Radar, choices: list[Fidelity], errors: list[float], allowed: float) -> Fidelity:
    """The cheapest choice that errs by no more than allowed [dB], or than the best one by NEARLY_BEST."""
    limit = max(allowed, min(errors) + NEARLY_BEST)
    kept = [choice for choice, error in zip(choices, errors, strict=True) if error <= limit]
    return min(kept, key=lambda choice: relative_cost(radar, choice))


def relative_cost(radar: Radar, fidelity: Fidelity) -> float:
    """What laying a moving echo costs on average over the turn, in any unit; it only has to put settings in order.

    The beam's share of the turn, by a price per echo and azimuth: 80 for each course, which azimuths swept together share, and
    1 for each bin of the kernel (measured, in some 20 ns). What hardly costs anything decides ties.
    """
    span = (fidelity.azimuths_per_block - 1) * radar.azimuth_step
    beam = min(2.0 * math.pi, 2.0 * fidelity.beam_extent * radar.beamwidth + span)
    each = 80.0 / fidelity.azimuths_per_block
    return beam * (each + fidelity.kernel_width + 0.1 * fidelity.beam_kernel_width + 0.01 * fidelity.beam_table_oversampling)


def all_rests(scene: Scene) -> bool:
    """Whether everything is laid once: nothing moves relative to the antenna, nothing fluctuates."""
    return scene.own_ship.at_rest and all(body.motion.at_rest and body.swerling == 0 for body in scene.bodies)
