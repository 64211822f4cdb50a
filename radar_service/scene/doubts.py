"""Scenes that can be run and yet leave a method's region: said when they are loaded, found by `radar-service stability`."""

from collections.abc import Iterator, Sequence

import numpy as np

from radar_service.constants import KNOT
from radar_service.radar.parameters import Radar
from radar_service.scene.error import SceneError
from radar_service.scene.world import Body, Motion

SPILLING_CHIRP = 14.0  # bandwidth x pulse: below, without a window, the field errs by more than -40 dB
CLOSE_SAMPLING = 1.1  # sample rate / bandwidth: the same
WIDE_MAP = 150_000.0  # m between bodies at rest: above, 1 % of the surface of a 1 m body is judged wrongly
HALF_A_CELL = 0.5  # of c / 2B, by which Doppler within the pulse may move an echo unmodelled
MOST_POWER = 1e34  # W: transforms in single precision overflow at 3.4e38


def pulse_doppler_shift(speed: float, pulse: float, wavelength: float) -> float:
    """Cells of c / 2B by which a chirp's echo moves when the target closes at `speed` [m/s]: f_d T = 2 v T / lambda
    (Skolnik 2001, range-Doppler coupling of a linear chirp)."""
    return 2.0 * speed * pulse / wavelength


def doubts(radar: Radar, own_ship: Motion, bodies: Sequence[Body]) -> Iterator[str]:
    """What a user should know before believing the echoes, a sentence each."""
    yield from _spilling(radar)
    yield from _doppler(radar, own_ship, bodies)
    yield from _wide(bodies)


def check_power(radar: Radar, bodies: Sequence[Body]) -> None:
    """Raises SceneError where an echo as near as radar.range_min_m could overflow single precision."""
    rcs = sum(body.rcs for body in bodies if body.rcs is not None)
    constant = radar.power * radar.gain**2 * radar.wavelength**2 / ((4.0 * np.pi) ** 3 * radar.loss)
    with np.errstate(over="ignore", divide="ignore"):
        most = float(np.float64(constant) * rcs / np.float64(radar.range_min) ** 4)
    if most > MOST_POWER:
        raise SceneError(
            f"radar.range_min_m: {radar.range_min:g} m, with this power and gain and {rcs:g} m2 of bodies, allows echoes of "
            f"{most:.0e} W; at most {MOST_POWER:.0e} W can be computed: raise range_min_m or lower gain_dbi or power_w"
        )


def _spilling(radar: Radar) -> Iterator[str]:
    if radar.modulation != "lfm" or radar.window != "none":
        return
    product, ratio = radar.bandwidth * radar.pulse, radar.sample_rate / radar.bandwidth
    if product < SPILLING_CHIRP:
        yield (
            f"radar.pulse_s: bandwidth x pulse is {product:.3g} and window is none, so the chirp spills out of its band and "
            f"the field errs by more than -40 dB: lengthen the pulse to a product of {SPILLING_CHIRP:g} or set a window"
        )
    elif ratio < CLOSE_SAMPLING:
        yield (
            f"radar.sample_rate_hz: {ratio:.3g} times the bandwidth and window is none, so its error exceeds -40 dB: "
            f"sample {CLOSE_SAMPLING:g} times the bandwidth or more, or set a window"
        )


def _doppler(radar: Radar, own_ship: Motion, bodies: Sequence[Body]) -> Iterator[str]:
    if radar.modulation != "lfm":
        return
    speed = own_ship.top_speed + max((body.motion.top_speed for body in bodies), default=0.0)
    cells = pulse_doppler_shift(speed, radar.pulse, radar.wavelength)
    if cells > HALF_A_CELL:
        yield (
            f"radar.pulse_s: at {speed / KNOT:.0f} kn Doppler would move echoes by {cells:.2g} range cells within a pulse "
            f"of {radar.pulse:g} s, which is not modelled (from spoke to spoke it is): shorten the pulse to believe ranges"
        )


def _wide(bodies: Sequence[Body]) -> Iterator[str]:
    still = [body.middle_at(0.0) for body in bodies if body.mesh is not None and body.motion.at_rest]
    if len(still) < 2:
        return
    span = float(np.ptp(np.array(still)[:, :2], axis=0).max())
    if span > WIDE_MAP:
        yield (
            f"body: bodies at rest stand {span / 1000:.0f} km apart, where sight lines are good to "
            f"{span / 2.0 * 2**-24:.2g} m only and small bodies may hide themselves: leave out what the radar never nears"
        )
