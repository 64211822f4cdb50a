"""Pulse compression: low sampling rates, short chirps, the ends of range, dynamic range and single precision."""

from collections.abc import Callable
from typing import Any

import numpy as np

from radar_service.numerics import SPEED_OF_LIGHT, Floats
from radar_service.receive import compression_for
from radar_service.scene_file import MIN_CHIRP_PRODUCT
from radar_service.simulator import Simulator
from radar_service.study.compressed_pulse import compressed_chirp
from radar_service.study.stability.finding import (
    Axis,
    Expected,
    Finding,
    bisect,
    crossing,
    curve,
    decades,
    decibels,
    echo_amplitude,
    error_db,
    plain,
    point,
    point_fields,
    scene_of,
)

BUDGET_DB = -40.0  # default error budget of the field
KERNEL_DB = -60.0  # error of the engine's kernel


def point_error(**radar: Any) -> float:
    """Returns the field error [dB] of three points, well inside the range, against the closed form."""
    scene = scene_of(point(0, 150.3), point(211.1, 111.7, 14), point(-170.9, -222.2, 12), radar=radar)
    scan = Simulator(scene, "balanced").scan()
    return error_db(scan.field, point_fields(scene, scan.time, scan.azimuth, scan.range))


def sampling_rate(fine: int = 1) -> Finding:
    """Drives the sampling rate over the bandwidth: field of points."""
    ratios = np.array([1.0, 1.05, 1.1, 1.15, 1.2, 1.25, 1.3, 1.4, 1.5, 1.75, 2.0, 3.0])
    return _without_window(
        ratios, Axis("sampling rate / bandwidth [1]"), "sample_rate_hz", 50e6 * ratios,
        name="sampling rate",
        setup="field of points with B T = 100",
        expected=Expected(1.09, 0.02, "measured; the service warns where it predicts more than -40 dB"),
        instead="a default of 1.5, a warning with the predicted error",
        details="The service refuses a sampling rate below the bandwidth. It predicts the error, and warns above -40 dB. The "
        "default is 1.5.",
    )  # fmt: skip


def short_chirps(fine: int = 1) -> Finding:
    """Drives the product of bandwidth and pulse length: field of points."""
    products = np.array([4.0, 5.0, 6.0, 8.0, 10.0, 14.0, 20.0, 30.0, 50.0, 100.0, 200.0])
    return _without_window(
        products, Axis("bandwidth x pulse length [1]", log=True), "pulse_s", products / 50e6,
        name="short chirps",
        setup="field of points sampled at 1.5 times the bandwidth; short chirps have power outside of it",
        expected=Expected(13.5, 0.04, "measured; the service warns where it predicts more than -40 dB"),
        instead=f"a warning with the predicted error, a refusal below {MIN_CHIRP_PRODUCT}",
        details=f"The service refuses a product below {MIN_CHIRP_PRODUCT}. It predicts the error, and warns above -40 dB.",
    )  # fmt: skip


def _without_window(values: Floats, parameter: Axis, key: str, settings: Floats, **fields: Any) -> Finding:
    """The field of points over a parameter, whose values give a key of the radar its settings, with and without a window."""
    unweighted, hamming = (
        [point_error(**{key: setting, "window": window}) for setting in settings] for window in ("none", "hamming")
    )
    return Finding(
        method="the engine's grid without a window",
        parameter=parameter,
        values=plain(values),
        measured=Axis("field error [dB]"),
        curves=(curve("no window", unweighted), curve("Hamming", hamming)),
        limit=BUDGET_DB,
        limit_reason="the default error budget of the field",
        boundary=crossing(values[::-1], np.array(unweighted)[::-1], BUDGET_DB, log=parameter.log),
        response="warning",
        **fields,
    )


def far_end(fine: int = 1) -> Finding:
    """Drives the range of a target beyond the end of range: what a transform wraps around to the near end."""
    ranges = np.linspace(300.0, 1000.0, 29)
    engine, unpadded = [], []
    for r in ranges:
        scene = scene_of(point(0, float(r)), environment={"earth": "flat"})
        scan = Simulator(scene, "balanced").scan()
        peak = float(echo_amplitude(scene.radar, r, 10.0))
        exact = point_fields(scene, scan.time[:1], scan.azimuth[:1], scan.range)
        engine.append(float(decibels(np.max(np.abs(scan.field[0] - exact)) ** 2 / peak**2, 1e-20)))
        copies = [scan.range - r + shift * len(scan.range) * scan.range_step for shift in (-1, 1)]
        wrapped = sum(_pulse_power(copy, 50e6, 2e-6, "hamming") for copy in copies)
        unpadded.append(float(decibels(np.max(wrapped), 1e-20)))
    return Finding(
        name="end of range",
        method="a transform of the range bins without padding",
        setup="a target that leaves the range of 600 m, pulse of 2 us",
        parameter=Axis("range of the target [m]"),
        values=plain(ranges),
        measured=Axis("largest error in any bin [dB of the peak]"),
        curves=(curve("transform without padding", unpadded), curve("the engine", engine)),
        limit=KERNEL_DB,
        limit_reason="the accuracy of the engine's kernel",
        boundary=crossing(ranges, np.array(unpadded), KERNEL_DB),
        expected=Expected(347.2, 0.02, "measured; cT/2 = 300 m before the end the pulse begins to extend beyond it"),
        response="another method",
        instead="transforms padded by cT/2 at both ends",
        details="The transforms have room for cT/2 of range sidelobes at both ends, and contain targets up to cT/2 beyond.",
    )


def _pulse_power(distance: Floats, bandwidth: float, pulse: float, window: str) -> Floats:
    """Returns the power of the compressed pulse at distances [m] from its peak."""
    return np.asarray(np.abs(compressed_chirp(2.0 * distance / SPEED_OF_LIGHT, bandwidth, pulse, window)) ** 2)


def range_ends(fine: int = 1) -> Finding:
    """Drives the distance of a target from either end of range, in bins: field against the closed form."""
    step = SPEED_OF_LIGHT / 150e6
    offsets = np.array([0.01, 0.1, 0.25, 0.49, 0.5, 0.75, 0.99, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0])
    ends: list[list[float]] = [[], []]
    for offset in offsets:
        for end, distance in enumerate((offset * step, 300 * step - offset * step)):
            scene = scene_of(
                point(0, float(distance)), radar={"range_max_m": 300 * step, "range_min_m": 1e-3},
                environment={"earth": "flat"},
            )  # fmt: skip
            scan = Simulator(scene, "balanced").scan()
            ends[end].append(error_db(scan.field, point_fields(scene, scan.time, scan.azimuth, scan.range)))
    return Finding(
        name="first and last range bins",
        method="the engine's range grid",
        setup="a target within a few bins of either end of range",
        parameter=Axis("distance from the end [bins]", log=True),
        values=plain(offsets),
        measured=Axis("field error [dB]"),
        curves=(curve("near end", ends[0]), curve("far end", ends[1])),
        limit=KERNEL_DB,
        limit_reason="the accuracy of the engine's kernel",
        boundary=crossing(offsets, np.maximum(*np.array(ends)), KERNEL_DB),
        expected=Expected(None),
        response="no failure",
        instead="a grid that extends beyond both ends",
        details="The grid extends beyond both ends of range.",
    )


def dynamic_range(fine: int = 1) -> Finding:
    """Drives the distance between a ship of 60 dBsm and a buoy of 0 dBsm: the ship's range sidelobes at the buoy."""
    distances = decades(3.0, 1490.0, 40 * fine)
    curves, boundaries = [], {}
    for window in ("none", "hamming", "blackman", "blackman-harris"):
        sidelobes = decibels(_pulse_power(distances[:, None] + np.linspace(0.0, 2.0, 9), 50e6, 10e-6, window).max(axis=1))
        worst = np.maximum.accumulate(sidelobes[::-1])[::-1] + 60.0
        curves.append(curve(window, worst))
        boundaries[window] = crossing(distances[::-1], worst[::-1], 0.0, log=True)
    floor = spurious_db()
    curves.append(curve("error of the engine, ship at rest", np.full(len(distances), 60.0 + floor["rest"])))
    curves.append(curve("error of the engine, ship moving", np.full(len(distances), 60.0 + floor["moving"])))
    return Finding(
        name="dynamic range",
        method="compression with a Hamming window",
        setup="a ship of 60 dBsm and a buoy of 0 dBsm, chirp of 10 us and 50 MHz",
        parameter=Axis("ship to buoy [m]", log=True),
        values=plain(distances),
        measured=Axis("ship's sidelobes over the buoy [dB]"),
        curves=tuple(curves),
        limit=0.0,
        limit_reason="the echo of the buoy; the boundary is that of a Hamming window",
        boundary=boundaries["hamming"],
        expected=Expected(860.8, 0.02, "measured on the closed form: a Hamming window, 60 dB, 10 us"),
        response="physical limit",
        instead="the sidelobes of the scene's window, as in a real radar",
        details="The window sets the sidelobes, as in a real radar. The errors of the engine stay below the buoy, for a ship at "
        "rest and for a moving ship.",
    )


def spurious_db() -> dict[str, float]:
    """Returns the largest field error in any cell [dB of the peak] of a point at rest and of one that moves at 12 kn."""
    errors = {}
    for name, speed in (("rest", 0.0), ("moving", 12.0)):
        scene = scene_of(
            point(120.5, 301.7, speed_kn=speed, course_deg=40.0),
            radar={"azimuths": 240, "beamwidth_deg": 3.9, "window": "blackman-harris"},
        )  # fmt: skip
        scan = Simulator(scene, "balanced").scan()
        exact = point_fields(scene, scan.time, scan.azimuth, scan.range)
        errors[name] = float(decibels((np.abs(scan.field - exact).max() / np.abs(exact).max()) ** 2))
    return errors


def overflow(fine: int = 1) -> Finding:
    """Drives the power of one strong echo: power after the engine's float32 transforms."""
    return _of_power(
        "overflow", "one strong echo", 10.0 ** np.arange(0.0, 41.0, 2.0 / fine), 1e40,
        expected=Expected(3.4028e38, 1e-3, "the largest number of IEEE 754 single precision"),
        response="refusal",
        instead="a refusal of scenes with echoes above 1e34 W",
        details="The service refuses a scene whose echoes could exceed 1e34 W.",
    )  # fmt: skip


def underflow(fine: int = 1) -> Finding:
    """Drives the power of one weak echo: power after the engine's float32 transforms."""
    return _of_power(
        "underflow", "one weak echo", 10.0 ** np.arange(0.0, -49.0, -2.0 / fine), 1e-48,
        expected=Expected(
            7e-44, 0.8, "half of the smallest number, 1.4e-45, is one per cent of 7e-44; each sum rounds anew"
        ),
        response="limited output",
        instead="zero power below 1e-43 W; the field is kept",
        details="Below 1e-43 W the power falls to 0, 28 decades below the noise of a receiver. The field, whose square is the "
        "power, does not.",
    )  # fmt: skip


def _of_power(name: str, echo: str, powers: Floats, last: float, **fields: Any) -> Finding:
    """The error of the power of an echo of `powers` (N,) [W], and where it exceeds one per cent between 1 W and `last`."""
    error = _power_error()
    return Finding(
        name=name,
        method="transforms and power in float32",
        setup=f"{echo} through the engine's transforms",
        parameter=Axis("received power [W]", log=True),
        values=plain(powers),
        measured=Axis("relative error of the power [1]", log=True),
        curves=(curve("the engine", [float(np.clip(error(power), 1e-9, 1.0)) for power in powers]),),
        limit=0.01,
        limit_reason="one per cent",
        boundary=bisect(lambda power: error(power) > 0.01, 1.0, last),
        **fields,
    )


def _power_error() -> Callable[[float], float]:
    """Returns a function from the power [W] of one echo in the middle of a bin to its relative error, at most 1."""
    radar = scene_of().radar
    compression = compression_for(radar, 6)
    first, weights = compression.kernel.weights(np.array([100.0]))

    def error(power: float) -> float:
        grid = np.zeros((1, compression.size), dtype=np.complex64)
        grid[0, first[0] : first[0] + weights.shape[1]] = np.sqrt(power) * weights[0]
        with np.errstate(over="ignore", invalid="ignore", under="ignore"):
            field = compression.profiles(grid)[0, 100]
            ratio = float(field.real**2 + field.imag**2) / power
        return abs(ratio - 1.0) if np.isfinite(ratio) else 1.0

    return error


STUDIES = (sampling_rate, short_chirps, far_end, range_ends, dynamic_range, overflow, underflow)
