"""Where motion and time fail: very fast targets, slow turns, Doppler within the pulse, months of running."""

from typing import Any

import numpy as np

from radar_service.constants import KNOT
from radar_service.display.ppi import Ppi
from radar_service.engine.pipeline import TILE, CorrectedChain
from radar_service.fidelity import PRESETS
from radar_service.frames import effective_earth_radius
from radar_service.random import NOISE, generator
from radar_service.scene.checks.validity import pulse_doppler_shift
from radar_service.scene.world import Scene
from radar_service.simulator import Simulator
from radar_service.study.stability.finding import Axis, Finding, bisected, crossing, curve, decades, places
from radar_service.study.stability.twin import error_db, point, point_fields, pulse_response, scene_of
from radar_service.trace.line_of_sight import OcclusionScene

MOVING_DB = -50.0  # error of moving points that the engine is to keep (issue 3)
DAY = 86_400.0
SPOKES_A_DAY = 288 * DAY  # 720 to a turn at 24 rpm
WAVELENGTH = 299_792_458.0 / 9.41e9


def moving_error(speed: float, **radar: Any) -> float:
    """Field error [dB] of a scan of a point that crosses at `speed` [m/s], and is inside throughout, with a beam 40
    degrees wide, so that the cut of the beam does not count."""
    scene = scene_of(point(0, 300.0, speed_kn=speed / KNOT, course_deg=60), radar=radar)
    scan = Simulator(scene, "balanced").scan()
    exact = point_fields(scene, scan.time, scan.azimuth, scan.range)
    return error_db(scan.field, exact)


def fast_targets(fine: int = 1) -> Finding:
    """Targets ever faster at 24 rpm, spoke by spoke against the closed form."""
    knots = np.array([0.1, 1, 3, 10, 40, 100, 200, 400, 700, 1000, 1400, 2000])
    fast = [moving_error(speed * KNOT, azimuths=180) for speed in knots]
    coarse = [moving_error(speed * KNOT, azimuths=24) for speed in knots]
    return Finding(
        "very fast targets", "a target crossing 300 m away at 24 rpm, every spoke against the closed form",
        Axis("speed [kn]", log=True), places(knots), Axis("field error [dB]"),
        (curve("180 spokes a turn", fast), curve("24 spokes a turn", coarse)), MOVING_DB, "what is asked of moving echoes",
        crossing(knots, np.maximum(fast, coarse), MOVING_DB, log=True), "refuses",
        "Scenes are refused above 2000 kn. Spokes see the target where it is at their instant, however fast.",
    )  # fmt: skip


def slow_turns(fine: int = 1) -> Finding:
    """A ship at 12 kn under an antenna that turns ever more slowly, so that it moves far between spokes."""
    rpm = decades(0.01, 100.0, 3)[::-1]
    tiles, ours = [], []
    for turns in rpm:
        scene = scene_of(
            point(0, 300.0, speed_kn=12.0, course_deg=60), radar={"azimuths": 48, "rpm": float(turns), "range_max_m": 1200}
        )
        tiles.append(_tiled_error(scene, TILE))
        ours.append(_tiled_error(scene, None))
    return Finding(
        "slow turns", "a ship at 12 kn, 48 spokes a turn, ever slower turns",
        Axis("turns a minute", log=True), places(rpm), Axis("field error [dB]"),
        (curve("sixteen spokes at a time", tiles), curve("the engine", ours)), MOVING_DB, "what is asked of moving echoes",
        crossing(rpm, np.array(tiles), MOVING_DB, log=True), "computes right",
        "As few spokes are computed together as fit into the time in which nothing moves 5 m, at least one.",
    )  # fmt: skip


def _tiled_error(scene: Scene, rows: int | None) -> float:
    """Field error [dB] of the first scan, with `rows` spokes computed at a time or as the engine does."""
    chain, radar = _chain(scene), scene.radar
    chain.rows = rows or chain.rows
    field = np.concatenate([field for _, field, _ in chain.parts(0)])
    azimuth, time = radar.schedule(np.arange(radar.azimuths))
    return error_db(field, point_fields(scene, time, azimuth, chain.range))


def doppler_in_the_pulse(fine: int = 1) -> Finding:
    """What the stop-and-go of a pulse leaves out: a chirp's Doppler moves the echo in range by f_d T cells of c/2B."""
    knots = decades(1.0, 2000.0, 4 * fine)
    lengths = {"10 us": 10e-6, "100 us": 100e-6, "1 ms": 1e-3}
    shifts = {name: 2.0 * knots * KNOT / WAVELENGTH * pulse for name, pulse in lengths.items()}
    longest = bisected(lambda speed: pulse_doppler_shift(speed * KNOT, 1e-3, WAVELENGTH) > 0.5, 0.01, 1e4)
    return Finding(
        "Doppler within the pulse", "shift of a moving target's echo that the engine does not model",
        Axis("closing speed [kn]", log=True), places(knots), Axis("shift [cells of c/2B]", log=True),
        tuple(curve(f"pulse of {name}", values) for name, values in shifts.items()), 0.5,
        "half a resolution cell; boundary: with a pulse of 1 ms", longest, "warns",
        "Phase from spoke to spoke is exact; within a pulse targets stand still. plan says by how much that errs, and a "
        "scene where it is half a cell or more is warned of when loaded.",
    )  # fmt: skip


def _chain(scene: Scene) -> CorrectedChain:
    occlusion = OcclusionScene(scene.bodies, effective_earth_radius(scene.environment.earth_factor))
    return CorrectedChain(scene, PRESETS["balanced"], 0, occlusion)


def months(fine: int = 1) -> Finding:
    """A target that keeps pace with own ship at 12 kn, after ever more days: phase of its field, double precision time."""
    days = np.array([0.0, 1.0, 7.0, 30.0, 90.0, 365.0, 3650.0, 36_500.0, 365_000.0])
    combine_db = {"speed_kn": 12.0, "course_deg": 37.0}
    scene = scene_of(point(33.3, 301.7, **combine_db), own_ship=combine_db, environment={"earth": "flat"})
    chain, radar = _chain(scene), scene.radar
    distance = np.hypot(33.3, 301.7)
    wanted = np.exp(-4j * np.pi * distance / radar.wavelength)
    errors, clock = [], []
    for day in days:
        scan = int(day * DAY / radar.rotation_period)
        field = chain.tile(scan, 0)[0]
        peak = int(np.argmax(np.abs(field)))
        still = _beside_the_peak(distance, chain.range[peak], radar.bandwidth, radar.pulse)
        errors.append(abs(float(np.angle(field[peak] / wanted / still, deg=True))))
        number = (scan + 1) * radar.azimuths - 1
        clock.append(float(np.spacing(number * radar.spoke_period)) * 1e9)
    return Finding(
        "months of running", "own ship and a target side by side at 12 kn, the field's phase after days of simulated time",
        Axis("days"), places(days), Axis("[degrees], [ns]", log=True),
        (curve("phase error [degrees]", np.maximum(errors, 1e-9)), curve("step of the clock [ns]", np.maximum(clock, 1e-9))),
        1.0, "a degree of phase", crossing(days, np.array(errors), 1.0), "computes right",
        "Time is spoke number times period in double precision, never summed; numbers are whole and 64 bits long.",
    )  # fmt: skip


def _beside_the_peak(distance: float, sample: float, bandwidth: float, pulse: float) -> complex:
    """Phase of the compressed pulse at a sample beside its peak."""
    value = complex(pulse_response(np.array(2.0 * (sample - distance) / 299_792_458.0), bandwidth, pulse, "hamming"))
    return value / abs(value)


def numbers_at_the_end(fine: int = 1) -> Finding:
    """Keys of the random generator at spoke numbers up to the end of 64 bits: draws stay different and in place."""
    numbers = [0, 2**31 - 1, 2**31, 2**32 - 1, 2**32, 2**53, 2**53 + 1, 2**63, 2**64 - 1]
    draws = [float(generator(0, NOISE, number).standard_normal()) for number in numbers]
    again = [float(generator(0, NOISE, number).standard_normal()) for number in numbers]
    same = [float(draw in draws[:k]) for k, draw in enumerate(draws)]
    moved = [float(a != b) for a, b in zip(draws, again, strict=True)]
    return Finding(
        "numbers without end", "scan numbers as keys of randomness, about 2^31, 2^32, 2^53 and to 2^64 - 1",
        Axis("which number"), places(np.arange(float(len(numbers)))), Axis("1 where wrong"),
        (curve("a draw met before", same), curve("another draw the second time", moved)), 0.5, "any", None, "refuses",
        "At 24 rpm 2^64 scans take 1.5 million million years; beyond, generator refuses.",
    )  # fmt: skip


def sequence_numbers(fine: int = 1) -> Finding:
    """Numbers of spokes after ever longer runs: in a browser, whose numbers are doubles, and in the accumulator."""
    days = np.append(np.array([1.0, 7.0, 30.0]), decades(100.0, 1e11, 1))
    kept, doubles = [], []
    for day in days:
        number = int(day * SPOKES_A_DAY)
        ppi = Ppi(1, 1, 0.5, 1.0)
        ppi.add(0, np.zeros((1, 1)), number)
        kept.append(float(not ppi.add(0, np.ones((1, 1)), number + 1)[0]))
        doubles.append(float(np.spacing(float(number)) > 1.0))
    lost = bisected(lambda day: np.spacing(day * SPOKES_A_DAY) > 1.0, 1.0, 1e11)
    return Finding(
        "sequence numbers", "the next spoke's number told from the last one's, 288 spokes a second",
        Axis("days", log=True), places(days), Axis("1 where they are taken for one"),
        (curve("a browser's doubles", doubles), curve("the accumulator", kept)), 0.5,
        "two spokes with one number", lost, "computes right",
        "Whole numbers of 64 bits on the wire and in Python; the page's are exact to 2^53, which lasts a million years.",
    )  # fmt: skip
