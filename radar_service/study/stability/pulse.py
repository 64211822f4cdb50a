"""Where compression fails: sampling near the bandwidth, short chirps, the far end, dynamic range, single precision."""

from collections.abc import Callable
from typing import Any

import numpy as np

from radar_service.receive.compression import compression_for
from radar_service.scene.checks.validity import MIN_UNWINDOWED_PRODUCT
from radar_service.scene.radar_model import MIN_CHIRP_PRODUCT
from radar_service.simulator import Simulator
from radar_service.study.stability.finding import Axis, Finding, bisected, crossing, curve, decades, decibels, places
from radar_service.study.stability.twin import error_db, level, point, point_fields, pulse_response, scene_of
from radar_service.trace.line_of_sight import Floats

FIELD_DB = -40.0  # error of the field that the engine is to keep (issue 4, the default budget)


def point_error(**radar: Any) -> float:
    """Error [dB] of the field of three points, well inside the range, against the closed form."""
    scene = scene_of(point(0, 150.3), point(211.1, 111.7, 14), point(-170.9, -222.2, 12), radar=radar)
    scan = Simulator(scene, "balanced").scan()
    return error_db(scan.field, point_fields(scene, scan.time, scan.azimuth, scan.range))


def sampling_rate(fine: int = 1) -> Finding:
    """Field of points against sampling rate over bandwidth."""
    ratios = np.array([1.0, 1.05, 1.1, 1.15, 1.2, 1.25, 1.3, 1.4, 1.5, 1.75, 2.0, 3.0])
    hamming, plain = (
        [point_error(sample_rate_hz=50e6 * ratio, window=window) for ratio in ratios] for window in ("hamming", "none")
    )
    return Finding(
        "sampling rate", "the engine's grid against sampling rate over bandwidth, B T = 100",
        Axis("sampling rate / bandwidth [1]"), places(ratios), Axis("field error [dB]"),
        (curve("no window", plain), curve("Hamming", hamming)), FIELD_DB, "the error budget of the field",
        crossing(ratios[::-1], np.array(plain)[::-1], FIELD_DB), "warns",
        "Below the bandwidth a scene is refused; below 1.1 times it, without a window, it is warned of; the default is 1.5.",
    )  # fmt: skip


def short_chirps(fine: int = 1) -> Finding:
    """Field of points against the product of bandwidth and pulse, whose small values spill out of the band."""
    products = np.array([4.0, 5.0, 6.0, 8.0, 10.0, 14.0, 20.0, 30.0, 50.0, 100.0, 200.0])
    errors = [point_error(pulse_s=product / 50e6) for product in products]
    bare = [point_error(pulse_s=product / 50e6, window="none") for product in products]
    return Finding(
        "short chirps", "the engine's grid at 1.5 times the bandwidth against bandwidth x pulse",
        Axis("bandwidth x pulse [1]", log=True), places(products), Axis("field error [dB]"),
        (curve("no window", bare), curve("Hamming", errors)), FIELD_DB, "the error budget of the field",
        crossing(products[::-1], np.array(bare)[::-1], FIELD_DB, log=True), "warns",
        f"A product below {MIN_CHIRP_PRODUCT} is refused; below {MIN_UNWINDOWED_PRODUCT:g}, without a window, it is warned of.",
    )  # fmt: skip


def far_end(fine: int = 1) -> Finding:
    """A target that leaves the range: what wraps round to the near end, in the engine and in a transform of the bins."""
    places_m = np.linspace(300.0, 1000.0, 29)
    ours, plain = [], []
    for r in places_m:
        scene = scene_of(point(0, float(r)), environment={"earth": "flat"})
        scan = Simulator(scene, "balanced").scan()
        loudest = float(level(scene.radar, r, 10.0))
        exact = point_fields(scene, scan.time[:1], scan.azimuth[:1], scan.range)
        ours.append(float(decibels(np.max(np.abs(scan.field[0] - exact)) ** 2 / loudest**2, 1e-20)))
        turns = [scan.range - r + turn * len(scan.range) * scan.range_step for turn in (-1, 1)]
        wrapped = sum(_heard(turn, 50e6, 2e-6, "hamming") for turn in turns)
        plain.append(float(decibels(np.max(wrapped), 1e-20)))
    return Finding(
        "wrap at the far end", "a target leaving the range of 600 m, pulse 2 us; error against its own peak",
        Axis("range of the target [m]"), places(places_m), Axis("greatest error in any bin [dB of the peak]"),
        (curve("transform of the bins alone", plain), curve("the engine", ours)), -60.0, "the kernel's -60 dB",
        crossing(places_m, np.array(plain), -60.0), "computes right",
        "Transforms keep room for cT/2 of sidelobes at either end, and targets up to cT/2 beyond are laid.",
    )  # fmt: skip


def _heard(distance: Floats, bandwidth: float, pulse: float, window: str) -> Floats:
    """Power of the compressed pulse that far from its peak [m]."""
    return np.asarray(np.abs(pulse_response(2.0 * distance / 299_792_458.0, bandwidth, pulse, window)) ** 2)


def range_ends(fine: int = 1) -> Finding:
    """A target in fractions of a bin from either end of the range."""
    step = 299_792_458.0 / 150e6
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
        "kernel at the ends of range", "a target within a few bins of either end",
        Axis("distance from the end [bins]", log=True), places(offsets), Axis("field error [dB]"),
        (curve("near end", ends[0]), curve("far end", ends[1])), -60.0, "the kernel's -60 dB",
        crossing(offsets, np.maximum(*np.array(ends)), -60.0), "computes right",
        "The grid goes on beyond both ends.",
    )  # fmt: skip


def dynamic_range(fine: int = 1) -> Finding:
    """A ship of 60 dBsm beside a buoy of 0 dBsm: where the ship's range sidelobes let it be seen."""
    apart = decades(3.0, 1490.0, 40 * fine)
    curves, edges = [], {}
    for window in ("none", "hamming", "blackman", "blackman-harris"):
        sidelobes = decibels(_heard(apart[:, None] + np.linspace(0.0, 2.0, 9), 50e6, 10e-6, window).max(axis=1))
        worst = np.maximum.accumulate(sidelobes[::-1])[::-1] + 60.0
        curves.append(curve(window, worst))
        edges[window] = crossing(apart[::-1], worst[::-1], 0.0, log=True)
    floor = spurious_db()
    curves.append(curve("error of the engine, ship at rest", np.full(len(apart), 60.0 + floor["rest"])))
    curves.append(curve("error of the engine, ship moving", np.full(len(apart), 60.0 + floor["moving"])))
    return Finding(
        "dynamic range", "a ship of 60 dBsm and a buoy of 0 dBsm apart in range, 10 us, 50 MHz",
        Axis("ship to buoy [m]", log=True), places(apart), Axis("ship's sidelobes over the buoy [dB]"),
        tuple(curves), 0.0, "the buoy's own level; boundary: with a Hamming window", edges["hamming"], "computes right",
        "As a real radar would: the window decides. The engine adds less than that: errors stay below the "
        "buoy, at rest and moving.",
    )  # fmt: skip


def spurious_db() -> dict[str, float]:
    """Greatest error of the field in any cell over the peak [dB] of a point at rest and of one moving at 12 kn."""
    found = {}
    for name, speed in (("rest", 0.0), ("moving", 12.0)):
        scene = scene_of(
            point(120.5, 301.7, speed_kn=speed, course_deg=40.0),
            radar={"azimuths": 240, "beamwidth_deg": 3.9, "window": "blackman-harris"},
        )  # fmt: skip
        scan = Simulator(scene, "balanced").scan()
        exact = point_fields(scene, scan.time, scan.azimuth, scan.range)
        found[name] = float(decibels((np.abs(scan.field - exact).max() / np.abs(exact).max()) ** 2))
    return found


def overflow(fine: int = 1) -> Finding:
    """Echoes ever larger through the engine's single-precision transforms."""
    error, powers = _power_error(), 10.0 ** np.arange(0.0, 41.0, 2.0 / fine)
    high = bisected(lambda power: error(power) > 0.01, 1.0, 1e40)
    return Finding(
        "overflow", "one loud echo through the single-precision transforms and power",
        Axis("received power [W]", log=True), places(powers), Axis("relative error of the power [1]", log=True),
        (curve("the engine", [float(np.clip(error(power), 1e-9, 1.0)) for power in powers]),), 0.01, "one per cent", high,
        "refuses", "A scene whose echoes could exceed 1e34 W is refused when loaded.",
    )  # fmt: skip


def underflow(fine: int = 1) -> Finding:
    """Echoes ever smaller through the same."""
    error, powers = _power_error(), 10.0 ** np.arange(0.0, -49.0, -2.0 / fine)
    low = bisected(lambda power: error(power) > 0.01, 1.0, 1e-48)
    return Finding(
        "underflow", "one faint echo through the single-precision transforms and power",
        Axis("received power [W]", log=True), places(powers), Axis("relative error of the power [1]", log=True),
        (curve("the engine", [float(np.clip(error(power), 1e-9, 1.0)) for power in powers]),), 0.01, "one per cent", low,
        "falls back", "Below 1e-43 W, twenty-eight decades under the noise of a receiver, power fades to 0; the field, whose "
        "square it is, does not.",
    )  # fmt: skip


def _power_error() -> Callable[[float], float]:
    """Relative error, 1 at most, of the power of one echo of so much power [W] in the middle of a bin."""
    radar = scene_of().radar
    compression = compression_for(radar, 6)
    first, weights = compression.kernel.weights(np.array([100.0]))

    def error(power: float) -> float:
        gridded = np.zeros((1, compression.size), dtype=np.complex64)
        gridded[0, first[0] : first[0] + weights.shape[1]] = np.sqrt(power) * weights[0]
        with np.errstate(over="ignore", invalid="ignore", under="ignore"):
            field = compression.profiles(gridded)[0, 100]
            found = float(field.real**2 + field.imag**2) / power
        return abs(found - 1.0) if np.isfinite(found) else 1.0

    return error
