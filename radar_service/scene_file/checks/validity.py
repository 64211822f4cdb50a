"""Warns of settings outside the valid region of a method, and refuses powers that overflow.

The limits come from `radar-service stability`.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from radar_service.numerics.constants import KNOT
from radar_service.radar.folding import least_chirp_error_db, remedies
from radar_service.radar.parameters import Radar
from radar_service.radar.waveform import pulse_doppler_shift
from radar_service.scattering.reflector_patterns import highest_rcs
from radar_service.world.body import Body
from radar_service.world.error import SceneError
from radar_service.world.motion import Motion
from radar_service.world.platform import Platform
from radar_service.world.scene import World

MAX_CHIRP_ERROR_DB = -40.0  # of the field, what the samples fold: the default error budget
MAX_STATIC_EXTENT = 150_000.0  # m between bodies at rest: above, visibility is wrong on 1 % of a 1 m body's surface
MAX_DOPPLER_SHIFT = 0.5  # range cells c / 2B: the shift within the pulse is not modelled
MAX_POWER = 1e34  # W: transforms in single precision overflow at 3.4e38


def validity_warnings(world: World, radar: Radar, platform: Platform) -> Iterator[str]:
    """Yields a warning for each setting with which echoes may be inaccurate."""
    for pulse in radar.of_each_pulse:
        yield from _folding(pulse)
        yield from _doppler(world, pulse, platform)
    yield from _static_extent(world.bodies)


def check_echo_power(radar: Radar, bodies: Sequence[Body]) -> None:
    """Raises SceneError if an echo at radar.range_min_m could overflow single precision."""
    rcs = sum(body.rcs for body in bodies if body.rcs is not None)
    rcs += sum(highest_rcs(body.reflector, radar.wavelength) for body in bodies if body.reflector is not None)
    constant = radar.power * radar.gain**2 * radar.wavelength**2 / ((4.0 * np.pi) ** 3 * radar.loss)
    with np.errstate(over="ignore", divide="ignore"):
        maximum = float(np.float64(constant) * rcs / np.float64(radar.range_min) ** 4)
    if maximum > MAX_POWER:
        raise SceneError(
            f"radar.range_min_m: {radar.range_min:g} m, with this power and gain and {rcs:g} m2 of bodies, allows echoes of "
            f"{maximum:.0e} W; at most {MAX_POWER:.0e} W can be computed: raise range_min_m or lower gain_dbi or power_w"
        )


def check_antenna(radar: Radar, own_ship: Motion) -> None:
    """Raises SceneError if sway dips the antenna into the sea."""
    sway = own_ship.sway
    if sway is None:
        return
    lowest, heave = radar.height * float(np.prod(np.cos(sway.likely_values[:2]))), float(sway.likely_values[3])
    if heave >= lowest:
        raise SceneError(
            f"own_ship.heave_m: {heave:g} m dips the antenna into the sea; roll and pitch leave it {lowest:.1f} m up: "
            f"give less than {lowest:.1f} m, or raise radar.height_m"
        )


def _folding(radar: Radar) -> Iterator[str]:
    """Warns where a chirp's spectrum exceeds the sampled band so far that the field errs."""
    if radar.modulation == "none" or (error := least_chirp_error_db(radar)) <= MAX_CHIRP_ERROR_DB:
        return
    product, ratio = radar.bandwidth * radar.pulse, radar.sample_rate / radar.bandwidth
    helpful = remedies(radar, least_chirp_error_db, MAX_CHIRP_ERROR_DB) or "raise sample_rate_hz and lengthen pulse_s"
    yield (
        f"radar.sample_rate_hz: with bandwidth x pulse {product:.3g}, window {radar.window} and {ratio:.3g} x bandwidth, the "
        f"chirp's spectrum exceeds the sampled band: the field error is {error:.0f} dB, above {MAX_CHIRP_ERROR_DB:.0f} dB: "
        f"{helpful}"
    )


def _doppler(world: World, radar: Radar, platform: Platform) -> Iterator[str]:
    if radar.modulation == "none":
        return
    speed = platform.motion.top_speed + max((body.motion.top_speed for body in world.bodies), default=0.0)
    cells = pulse_doppler_shift(speed, radar.pulse, radar.wavelength, radar.chirp.doppler_coupling)
    if cells > MAX_DOPPLER_SHIFT:
        yield (
            f"radar.pulse_s: at {speed / KNOT:.0f} kn Doppler within a pulse of {radar.pulse:g} s moves echoes by "
            f"{cells:.2g} "
            "range cells; the simulation models motion between spokes only: shorten the pulse for exact ranges"
        )


def _static_extent(bodies: Sequence[Body]) -> Iterator[str]:
    middles = [body.middle_at(0.0) for body in bodies if body.mesh is not None and body.motion.at_rest]
    if len(middles) < 2:
        return
    span = float(np.ptp(np.array(middles)[:, :2], axis=0).max())
    if span > MAX_STATIC_EXTENT:
        yield (
            f"body: bodies at rest are {span / 1000:.0f} km apart, so lines of sight are accurate to "
            f"{span / 2.0 * 2**-24:.2g} m only and small bodies may occlude themselves: remove bodies that stay out of range"
        )
