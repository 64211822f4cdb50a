"""Motion and time: fast targets, slow rotation, Doppler within the pulse, and long runs."""

from dataclasses import replace
from typing import Any

import numpy as np

from radar_service.engine.pipeline import Engine, profiles, tile_azimuths
from radar_service.engine.preparation import Prepared, prepare
from radar_service.numerics import KNOT, SPEED_OF_LIGHT
from radar_service.radar import pulse_doppler_shift
from radar_service.records import PRESETS
from radar_service.simulator import Simulator
from radar_service.study.compressed_pulse import compressed_chirp
from radar_service.study.stability.finding import (
    WAVELENGTH,
    Axis,
    Expected,
    Finding,
    bisect,
    crossing,
    curve,
    decades,
    error_db,
    plain,
    point,
    point_fields,
    scene_of,
)
from radar_service.world import Scene

MAX_ERROR_DB = -50.0  # the accuracy that the engine promises for moving points
DAY = 86_400.0
SPOKES_IN_BLOCK = 16  # of the driven method


def moving_error(speed: float, **radar: Any) -> float:
    """Returns the field error [dB] of one scan of a point that passes at `speed` [m/s].

    The beam is 40 degrees wide, so that the truncation of the beam does not matter.
    """
    scene = scene_of(point(0, 300.0, speed_kn=speed / KNOT, course_deg=60), radar=radar)
    scan = Simulator(scene, "balanced").scan()
    return error_db(scan.field, point_fields(scene, scan.time, scan.azimuth, scan.range))


def fast_targets(fine: int = 1) -> Finding:
    """Drives the speed of a target at 24 rpm: every spoke against the closed form."""
    knots = np.array([0.1, 1, 3, 10, 40, 100, 200, 400, 700, 1000, 1400, 2000])
    spokes_180 = [moving_error(speed * KNOT, azimuths=180) for speed in knots]
    spokes_24 = [moving_error(speed * KNOT, azimuths=24) for speed in knots]
    return Finding(
        name="fast targets",
        method="the engine's moving echoes",
        setup="a target that passes 300 m away at 24 rpm",
        parameter=Axis("speed [kn]", log=True),
        values=plain(knots),
        measured=Axis("field error [dB]"),
        curves=(curve("180 spokes for each scan", spokes_180), curve("24 spokes for each scan", spokes_24)),
        limit=MAX_ERROR_DB,
        limit_reason="the accuracy promised for moving echoes",
        boundary=crossing(knots, np.maximum(spokes_180, spokes_24), MAX_ERROR_DB, log=True),
        expected=Expected(None),
        response="no failure",
        instead="the position of the target at each spoke; a refusal above 2000 kn",
        details="Each spoke uses the position of the target at its time. The service refuses scenes with speeds above 2000 kn.",
    )


def slow_turns(fine: int = 1) -> Finding:
    """Drives the rotation rate under a ship at 12 kn, which moves far between spokes: field of blocks of spokes."""
    rpm = decades(0.01, 100.0, 3)[::-1]
    blocks, engine = [], []
    for rate in rpm:
        scene = scene_of(
            point(0, 300.0, speed_kn=12.0, course_deg=60), radar={"azimuths": 48, "rpm": float(rate), "range_max_m": 1200}
        )
        blocks.append(_block_error(scene, SPOKES_IN_BLOCK))
        engine.append(_block_error(scene, None))
    return Finding(
        name="slow rotation",
        method="blocks of sixteen spokes",
        setup="a ship at 12 kn, 48 spokes for each scan, at different rotation rates",
        parameter=Axis("rotation rate [rpm]", log=True),
        values=plain(rpm),
        measured=Axis("field error [dB]"),
        curves=(curve("sixteen spokes in a block", blocks), curve("the engine", engine)),
        limit=MAX_ERROR_DB,
        limit_reason="the accuracy promised for moving echoes",
        boundary=crossing(rpm, np.array(blocks), MAX_ERROR_DB, log=True),
        expected=Expected(0.25, 0.05, "measured: 16 spokes of 5.0 s at 12 kn are 490 m"),
        response="another method",
        instead="blocks in which nothing moves more than 5 m",
        details="A block has as many spokes as fit into the time in which nothing moves 5 m, and at least one.",
    )


def _block_error(scene: Scene, tile: int | None) -> float:
    """Returns the field error [dB] of the first scan, with `tile` spokes in a block, or as many as the engine chooses."""
    radar, prepared = scene.radar, _prepared(scene)
    if tile is not None:  # blocks end where a visibility step does, so one of these is as long as a tile
        step = tile * radar.spoke_period * scene.bodies[0].motion.top_speed
        prepared = replace(_prepared(scene, step), tile=tile)
    engine = Engine(prepared)
    field = np.concatenate([field for _, field, _ in engine.tiles(0)])
    azimuth, time = radar.schedule(np.arange(radar.azimuths))
    return error_db(field, point_fields(scene, time, azimuth, engine.range))


def doppler_in_the_pulse(fine: int = 1) -> Finding:
    """Drives the closing speed: the shift of an echo by Doppler within the pulse, f_d T cells of c/2B."""
    knots = decades(1.0, 2000.0, 4 * fine)
    lengths = {"10 us": 10e-6, "100 us": 100e-6, "1 ms": 1e-3}
    shifts = {name: 2.0 * knots * KNOT / WAVELENGTH * pulse for name, pulse in lengths.items()}
    return Finding(
        name="Doppler within the pulse",
        method="targets at rest during a pulse",
        setup="shift of a moving target's echo that the engine does not model",
        parameter=Axis("closing speed [kn]", log=True),
        values=plain(knots),
        measured=Axis("shift [cells of c/2B]", log=True),
        curves=tuple(curve(f"pulse of {name}", values) for name, values in shifts.items()),
        limit=0.5,
        limit_reason="half a range cell; the boundary is that of a pulse of 1 ms",
        boundary=bisect(lambda speed: pulse_doppler_shift(speed * KNOT, 1e-3, WAVELENGTH) > 0.5, 0.01, 1e4),
        expected=Expected(0.5 * WAVELENGTH / 2e-3 / KNOT, 1e-6, "lambda / (4 T): 15.48 kn for 1 ms"),
        response="warning",
        instead="a warning from half a range cell on; the plan states the shift",
        details="The phase from spoke to spoke is exact. Within a pulse targets are at rest; the plan states the shift that "
        "this ignores. The service warns of scenes where it is half a cell or more.",
    )


def _prepared(scene: Scene, visibility_step: float = PRESETS["balanced"].visibility_step) -> Prepared:
    return prepare(scene, replace(PRESETS["balanced"], visibility_step=visibility_step), 0)


def months(fine: int = 1) -> Finding:
    """Drives the time of the run: phase of a target that keeps its distance from own ship at 12 kn."""
    days = np.array([0.0, 1.0, 7.0, 30.0, 90.0, 365.0, 3650.0, 36_500.0, 365_000.0])
    motion = {"speed_kn": 12.0, "course_deg": 37.0}
    scene = scene_of(point(33.3, 301.7, **motion), own_ship=motion, environment={"earth": "flat"})
    prepared, radar = _prepared(scene), scene.radar
    sample_range = Engine(prepared).range
    distance = np.hypot(33.3, 301.7)
    expected = np.exp(-4j * np.pi * distance / radar.wavelength)
    errors, clock = [], []
    for day in days:
        scan = int(day * DAY / radar.rotation_period)
        field = profiles(prepared, tile_azimuths(prepared, scan, 0))[0]
        peak = int(np.argmax(np.abs(field)))
        pulse = _phase_beside_peak(distance, sample_range[peak], radar.bandwidth, radar.pulse)
        errors.append(abs(float(np.angle(field[peak] / expected / pulse, deg=True))))
        spokes = (scan + 1) * radar.azimuths - 1
        clock.append(float(np.spacing(spokes * radar.spoke_period)) * 1e9)
    return Finding(
        name="months of simulated time",
        method="time in float64",
        setup="own ship and a target side by side at 12 kn: phase of the field",
        parameter=Axis("days"),
        values=plain(days),
        measured=Axis("phase [degrees], clock [ns]", log=True),
        curves=(
            curve("phase error [degrees]", np.maximum(errors, 1e-9)), curve("step of the clock [ns]", np.maximum(clock, 1e-9)),
        ),
        limit=1.0,
        limit_reason="one degree of phase",
        boundary=crossing(days, np.array(errors), 1.0),
        expected=Expected(None),
        response="no failure",
        instead="spoke number times spoke period, without a running sum",
        details="Time is the spoke number times the spoke period in float64, never a sum. Numbers are 64-bit integers.",
    )  # fmt: skip


def _phase_beside_peak(distance: float, sample: float, bandwidth: float, pulse: float) -> complex:
    """Returns the phase factor of the compressed pulse at a sample beside its peak."""
    value = complex(compressed_chirp(np.array(2.0 * (sample - distance) / SPEED_OF_LIGHT), bandwidth, pulse, "hamming"))
    return value / abs(value)


STUDIES = (fast_targets, slow_turns, doppler_in_the_pulse, months)
