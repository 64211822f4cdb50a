"""The table of docs/accuracy.md#accuracy: quantities, theory, measured value and difference.

Every figure is measured in the run that prints it.

    .venv/bin/python -m tests.measurements.accuracy_table

A row is a function that returns Row; add it to ROWS. Theory is a closed form, a published figure or a slow reference.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

import radar_service as rs
from radar_service.numerics.constants import SPEED_OF_LIGHT
from radar_service.receive.compression import receiver_noise_power
from tests.reference.docs_tables import write_measured
from tests.reference.point_scene import error_db, exact_field, scattered
from tests.scenes import point, scene

WIDE = {"azimuths": 90, "beamwidth_deg": 10}
LONG = {**WIDE, "bandwidth_hz": 5e6}
FLAT = {"earth": "flat"}


class Row(NamedTuple):
    """One line of the table."""

    quantity: str
    theory: str
    measured: str
    difference: str


def db(power: Any) -> Any:
    return 10 * np.log10(power)


def decibels(quantity: str, theory: float, measured: float, digits: int = 2) -> Row:
    """A row of two levels."""
    return Row(quantity, f"{theory:.{digits}f} dB", f"{measured:.{digits}f} dB", f"{measured - theory:+.{digits}f} dB")


def scan_of(bodies: list[dict[str, Any]], radar: dict[str, Any], **sections: Any) -> rs.Scan:
    return rs.Simulator(scene(bodies, radar=radar, **sections)).scan()


def radar_equation(distance: float) -> Row:
    """Our field projected on the exact one, and its level by hand."""
    made = scene([point("t", 0, distance, 10.0)], radar=LONG | {"range_max_m": distance + 1000})
    scan = rs.Simulator(made).scan()
    exact = exact_field(made, scan)
    theory = float(db(np.max(np.abs(exact) ** 2)))
    return decibels(f"power of 10 m² at {distance / 1000:g} km (dBW, peak sample)", theory,
                    theory + float(db(np.abs(np.vdot(exact, scan.field) / np.vdot(exact, exact)) ** 2)), 3)  # fmt: skip


def phase_at_forty_kilometres() -> Row:
    made = scene([point("t", 12_345.678, 38_000.123, 100)], radar=LONG | {"range_max_m": 40_100, "height_m": 100})
    scan = rs.Simulator(made).scan()
    exact = exact_field(made, scan)
    turn = float(np.rad2deg(np.angle(np.vdot(exact, scan.field))))
    return Row("phase at 40 km", "-4 pi R/lambda", "the same", f"{turn:+.3f} degrees")


def field_error(what: str, radar: dict[str, Any], motion: dict[str, Any] | None = None, far: float = 0.0) -> Row:
    """Energy of the difference to the closed form over that of the closed form, six points all round, second scan."""
    bodies = scattered(6, 60, far or 0.95 * radar["range_max_m"], 1, **(motion or {}))
    made = scene(bodies, radar=WIDE | radar)
    sim = rs.Simulator(made)
    sim.scan()
    error = error_db(made, sim.scan())
    return Row(f"field error, {what}", "closed form", "engine", f"{error:.1f} dB")


def setting(what: str, theory: float, radar: dict[str, Any], environment: dict[str, Any]) -> Row:
    """What a setting changes of the power of a point at 10 km."""
    powers = []
    for more, around in (({}, FLAT), (radar, FLAT | environment)):
        scan = scan_of([point("t", 0, 10_000, rcs_dbsm=100)], LONG | {"range_max_m": 11_000} | more, environment=around)
        cell = int(10_000 / scan.range_step)
        powers.append(float(scan.power[0, cell - 3 : cell + 4].max()))
    return decibels(what, theory, float(db(powers[1] / powers[0])))


def noise_level() -> Row:
    made = scene(radar=WIDE | {"range_max_m": 5000}, environment={"noise": True})
    sim = rs.Simulator(made)
    measured = float(np.mean([sim.scan().power.mean(dtype=float) for _ in range(4)]))  # sampling error 0.006 dB
    assert receiver_noise_power(made.radar) > 0
    return decibels("noise of the default radar (dBW per sample)", float(db(1.371e-15)), float(db(measured)))


def straddle(rate: float, theory: float) -> Row:
    step = SPEED_OF_LIGHT / (2 * rate * 20e6)
    radar = {
        **WIDE,
        "bandwidth_hz": 20e6,
        "sample_rate_hz": rate * 20e6,
        "pulse_s": 50e-6,
        "window": "none",
        "range_max_m": 3000,
    }
    peaks = [
        float(scan_of([point("t", 0, n * step, rcs_dbsm=40 * np.log10(n))], radar, environment=FLAT).power[0].max())
        for n in (100.5, 101.0)
    ]
    return decibels(f"straddle loss at fs = {rate:g} B", theory, float(db(peaks[0] / peaks[1])))


def sidelobe(window: str, product: int, theory: float) -> Row:
    """Peak range sidelobe of the engine's own profile, window on the reference."""
    bandwidth, fs = 20e6, 160e6
    radar = {**WIDE, "bandwidth_hz": bandwidth, "sample_rate_hz": fs, "pulse_s": product / bandwidth, "window": window}
    step = SPEED_OF_LIGHT / (2 * fs)
    reach = SPEED_OF_LIGHT * product / bandwidth / 2
    position = (np.ceil((reach + 50) / step) + 0.5) * step
    scan = scan_of([point("t", 0, position)], radar | {"range_max_m": 2 * position}, environment=FLAT)
    power = scan.power[0].astype(float)
    top = int(power.argmax())
    right = power[top : top + int(reach / step)]
    dip = int(np.flatnonzero((right[1:-1] < right[:-2]) & (right[1:-1] < right[2:]))[0]) + 1
    return decibels(f"peak range sidelobe, {window}, BT = {product}", theory, float(db(right[dip:].max() / right[0])), 1)


def beam_width(pattern: str, theory: float) -> Row:
    """Two-way half-power width in beamwidths, from the powers of one point over the azimuths."""
    radar = {
        "azimuths": 3600,
        "beamwidth_deg": 4,
        "pattern": pattern,
        "bandwidth_hz": 5e6,
        "range_max_m": 600,
        "pulse_s": 2e-6,
    }
    scan = scan_of([point("t", 0, 500)], radar, environment=FLAT)
    power = scan.power[:60].astype(float).max(axis=1)
    offset = np.arange(60) * 0.1
    half = brentq(lambda x: float(np.interp(x, offset, db(power / power[0]))) + db(2.0), 0.01, 3)
    return Row(f"two-way width, {pattern} (beamwidths)", f"{theory:.4f}", f"{half / 2:.4f}", f"{half / 2 - theory:+.4f}")


def multipath(distance: float, theory: float) -> Row:
    radar = {"azimuths": 8, "beamwidth_deg": 60, "beamwidth_el_deg": 180, "bandwidth_hz": 5e6, "range_max_m": distance + 400}
    powers = [
        float(scan_of([point("t", 0, distance, 10.0)], radar, environment={"multipath": on}).power[0].max())
        for on in (True, False)
    ]
    return decibels(
        f"F⁴ at {distance / 1000:g} km, 15 and 10 m high",
        theory,
        float(db(powers[0] / powers[1])),
    )


SHORT = {"range_max_m": 1500, "bandwidth_hz": 20e6, "pulse_s": 1e-6, "window": "none"}
PLAIN = {"modulation": "none", "pulse_s": 0.08e-6, "bandwidth_hz": 25e6, "range_max_m": 2000}
UNDER_WAY = {"speed_kn": 12, "course_deg": 30}
FOLDED = {"range_max_m": 4000, "prf_hz": 20_000, "second_time_around": True, "height_m": 100}
ROWS: list[Callable[[], Row]] = [
    *(lambda d=d: radar_equation(d) for d in (500.0, 5000.0, 28_900.0)),
    phase_at_forty_kilometres,
    lambda: field_error("chirp at rest", {"range_max_m": 3000}),
    lambda: field_error("chirp, 12 kn", {"range_max_m": 3000}, UNDER_WAY),
    lambda: field_error("chirp of BT = 20 without window, fs = 1.5 B", SHORT),
    lambda: field_error("plain pulse 0.08 us at rest", PLAIN),
    lambda: field_error("plain pulse 0.08 us, 12 kn", PLAIN, UNDER_WAY),
    lambda: field_error("plain pulse 1.2 us at rest", {"modulation": "none", "pulse_s": 1.2e-6, "range_max_m": 20_000}),
    lambda: field_error("eclipsed chirp (60 m to cT/2)", {"range_max_m": 2500, "eclipsing": True}, far=1499.0),
    lambda: field_error("second time around (to 30 km, shown to 4 km)", FOLDED, far=30_000.0),
    lambda: setting("loss_db = 2.5", -2.5, {"loss_db": 2.5}, {}),
    lambda: setting("gas (ITU-R P.676) at 10 km", -2 * 10 * 0.01327, {}, {"gas_db_per_km": "itu"}),
    lambda: setting("rain of 16 mm/h at 10 km, H (ITU-R P.838)", -2 * 10 * 0.332, {}, {"rain_mm_h": 16}),
    noise_level,
    *(lambda r=r, t=t: straddle(r, t) for r, t in ((1.5, 1.65), (2.0, 0.91), (4.0, 0.22))),
    lambda: sidelobe("none", 100, -13.39),
    lambda: sidelobe("hamming", 500, -42.6),
    *(lambda p=p, t=t: beam_width(p, t) for p, t in (("sinc2", 0.7200), ("gaussian", 0.7071), ("cosine2", 0.7134))),
    *(lambda d=d, t=t: multipath(d, t) for d, t in ((2000, 9.59), (6000, 11.37), (12_000, 10.50), (20_000, -5.35))),
]  # fmt: skip


def table() -> str:
    """The whole table in Markdown."""
    lines = ["| quantity | theory | measured | difference |", "|---|---|---|---|"]
    return "\n".join([*lines, *(f"| {' | '.join(row())} |" for row in ROWS)])


if __name__ == "__main__":
    write_measured("accuracy", table() + "\n")
    print(table())
