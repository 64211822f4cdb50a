"""Rows of the signal: rain on the path, pulses and their repetition, beams, beacons, and the settings of real sets."""

import math
from functools import partial

import numpy as np

from radar_service.believed.run import BARE, NM, SETS, Figure, Measurement, Run, Table, X, db, placed, reaching, ring
from radar_service.numerics import SPEED_OF_LIGHT, Floats
from radar_service.radar import Radar
from radar_service.scans import Scan
from radar_service.simulator import Simulator

POINT: Table = {"shape": "point", "rcs_dbsm": 30}
NORTH = (-0.02, 0.02)  # rad: azimuths that are computed


def north(run: Run, radar: Table, bodies: list[Table], air: Table | None = None) -> tuple[Simulator, Scan]:
    """Returns a simulator and its scan of the azimuths about north; radar: keys beside those of BARE."""
    simulator = run.simulator(BARE | radar, {"earth": "flat", **(air or {})}, bodies, sector=NORTH)
    return simulator, simulator.scan()


def rain_loss(run: Run, frequency: float, polarization: str, rain: float) -> float:
    """Returns the one-way loss [dB/km] by which rain weakens the echo of a point 2 km off, far stronger than that of the rain."""
    radar = {
        "frequency_hz": frequency,
        "polarization": polarization,
        "range_max_m": 3000,
        "bandwidth_hz": 10e6,
        "power_w": 1e9,
    }
    point = POINT | {"rcs_dbsm": 100, "position_m": [0, 2000, 15]}
    wet, dry = (np.nanmax(north(run, radar, [point], air)[1].power) for air in ({"rain_mm_h": rain}, {}))
    return db(float(dry) / float(wet)) / 4.0


def rain(rows: tuple[tuple[float, str, float, float], ...], share: float, run: Run) -> list[Figure]:
    """Specific attenuation. rows: frequency [Hz], polarization, rain [mm/h], published [dB/km]."""
    return [
        Figure.near(f"{f / 1e9:g} GHz, {p.upper()}, {mm:g} mm/h", rain_loss(run, f, p, mm), published, share, "dB/km")
        for f, p, mm, published in rows
    ]


def second_trace(run: Run) -> list[Figure]:
    """How much nearer an echo from 90 km appears at 1900 pulses a second."""
    mountain = POINT | {"position_m": [0, 90e3, 15]}
    radar = {"prf_hz": 1900, "second_time_around": True, "range_max_m": 30e3, "bandwidth_hz": 10e6, "rpm": 24}
    simulator, scan = north(run, radar, [mountain])
    place = float(scan.range[np.nanargmax(np.nanmax(scan.power, axis=0))])
    return [Figure.near("offset", (90e3 - place) / NM, 43.0, 0.02, "NM")]


def minimum_range(run: Run) -> list[Figure]:
    """The nearest range at which a pulse of 1 us is received whole, of a set with one antenna, for each us of it."""
    received = []
    for distance in np.arange(100.0, 200.0, 1.0).tolist():
        body = POINT | {"position_m": [0, distance, 15]}
        pulse = {"modulation": "none", "pulse_s": 1e-6, "sample_rate_hz": 20e6, "range_max_m": 600}
        full, cut = (
            np.nanmax(north(run, pulse | {"eclipsing": is_eclipsing}, [body])[1].power) for is_eclipsing in (False, True)
        )
        if cut > (1.0 - 1e-4) * full:
            received.append(distance)
    return [Figure.near("nearest", min(received, default=math.inf), 150.0, 0.02, "m")]


def one_way_db(run: Run, antenna: Table, angles: Floats, vertical: bool = False) -> Floats:
    """Returns the one-way pattern (A,) [dB] of an antenna as scans of a point at these angles off its axis [degrees] show it."""
    levels = []
    for angle in np.deg2rad(angles).tolist():
        place = [0, 2000 * math.cos(angle), 100 + 2000 * math.sin(angle)] if vertical else placed(angle, 2000, 100)
        radar = X | {"pattern": "taylor", **antenna, "height_m": 100, "range_max_m": 2500, "azimuths": 2048}
        body = POINT | {"position_m": place}
        simulator = run.simulator(radar, {"earth": "flat"}, [body], sector=(-1e-3, 1e-3))
        levels.append(0.5 * db(float(np.nanmax(simulator.scan().power[0]))))
    return np.array(levels) - max(levels)


def width(run: Run, antenna: Table, nominal: float, vertical: bool = False) -> float:
    """Returns the half-power width [degrees] of a beam that is nominally so wide."""
    angles = np.linspace(0.0, nominal, 21)
    level = one_way_db(run, antenna, angles, vertical)
    return 2.0 * float(np.interp(3.0103, -level, angles))


def beams(rows: tuple[tuple[float, bool], ...], run: Run) -> list[Figure]:
    """Half-power widths. rows: of a set [degrees], and whether it is the vertical one."""
    return [
        Figure.near(
            f"{'vertical' if up else 'horizontal'} {nominal:g}",
            width(run, {"beamwidth_el_deg" if up else "beamwidth_deg": nominal}, nominal, up),
            nominal,
            0.1,
            "deg",
        )
        for nominal, up in rows
    ]


def slotted_guides(run: Run) -> list[Figure]:
    """Widths, side lobes of a Taylor pattern of 23 dB within and beyond 10 degrees, and gain."""
    figures = beams(((1.8, False), (1.1, False), (23.0, True)), run)
    for beam, gain in ((1.8, 27.0), (1.1, 29.0)):
        antenna = {"beamwidth_deg": beam, "beamwidth_el_deg": 23.0, "taylor_sidelobe_db": 23.0}
        angles = np.linspace(1.3 * beam, 30.0, 120)
        lobes = one_way_db(run, antenna, np.r_[0.0, angles])[1:]
        levels = [
            north(run, X | {**antenna, "gain_dbi": g}, [POINT | {"position_m": [0, 2000, 15]}])[1].power for g in (gain, 0.0)
        ]
        computed = 0.5 * db(float(np.nanmax(levels[0])) / float(np.nanmax(levels[1])))
        figures += [
            Figure.most(f"{beam:g}: lobes within 10 deg", float(lobes[angles <= 10].max()), -22.0, "dB"),
            Figure.most(f"{beam:g}: beyond", float(lobes[angles > 10].max()), -29.0, "dB"),
            Figure.within(f"{beam:g}: gain over an isotropic antenna", computed, gain, 1.0, "dB"),
        ]
    return figures


# A beam of 1 degree with the side lobes that a maker allows of slotted guides (row A01): -23 dB to 10 degrees, -30 dB beyond.
GUIDE = [[0, 0], [0.5, -3], [1, -12], [1.5, -23], [10, -23], [11, -30], [180, -30]]


def side_lobe_arcs(run: Run) -> list[Figure]:
    """The farthest range at which a cargo ship of 140 m shows 3 beamwidths off its ends, over the noise."""
    seen = []
    for nautical in np.arange(0.5, 8.1, 0.5).tolist():
        ship = {"shape": "hull", "hull_type": "cargo", "length_m": 140, "beam_m": 21, "height_m": 28, "heading_deg": 80}
        body = ship | {"position_m": [0, nautical * NM, 0]}
        off = math.radians(3.0) + 70.0 / (nautical * NM)  # from the ship's end
        radar = X | {"pattern": GUIDE, "pattern_el": "taylor", "range_max_m": nautical * NM + 500.0}
        simulator = run.simulator(radar, {"noise": True, "multipath": True}, [body], sector=(off, off + 0.12))
        power = simulator.scan().power[:, int((nautical * NM - 150) / simulator.range_step) :]
        if np.nanmax(power) > 20.0 * simulator.noise_power:
            seen.append(nautical)
    return [Figure.by_factor("side lobes to", max(seen, default=0.0), 3.0, 3.0, 1.5, "NM")]


SART = {"shape": "point", "rcs_dbsm": -50, "position_m": [0, NM, 15], "sart": {"offset_m": [0, 0, 0]}}


def sart_profile(run: Run, pulse: float) -> tuple[Floats, Floats]:
    """Returns ranges (N,) [m] and the power there on the bearing of a SART 1 NM off, as a plain pulse [s] has it."""
    radar = X | {"range_max_m": NM + 18e3, "pattern": "gaussian", "pulse_s": pulse}
    simulator = run.simulator(radar, {"earth": "flat"}, [SART], sector=(-0.003, 0.003))
    scan = simulator.scan()
    return scan.range, np.asarray(scan.power[0], dtype=np.float64)


def slow_dots(distance: Floats, power: Floats) -> Floats:
    """Returns the ranges (D,) [m] of the dots of the slow sweeps: the stronger ones, 500 m apart at least."""
    from scipy.signal import find_peaks  # here: it takes half a second

    gap = round(500.0 / float(distance[1] - distance[0]))
    peaks, _ = find_peaks(power, height=0.5 * power.max(), distance=gap)
    return np.asarray(distance[peaks])


def sart_dots(run: Run) -> list[Figure]:
    """The dots of a SART 1 NM off: their number, distance and delay, and the first of a fast sweep."""
    dots = slow_dots(*sart_profile(run, 2.5e-7))
    distance, power = sart_profile(run, 7e-8)
    fast = distance[(distance > NM) & (power > power.max() * 1e-4)]
    return [
        Figure("dots", len(dots), 12, 12), Figure.near("apart", float(np.diff(dots).mean()) / NM, 0.64, 0.05, "NM"),
        Figure("first slow dot behind", (float(dots[0]) - NM) / NM, 0.0, 0.64, "NM"),
        Figure("first fast dot behind", float(fast[0]) - NM, 0.0, 150.0, "m"),
    ]  # fmt: skip


def sart_signal(run: Run) -> list[Figure]:
    """Radiated power by the level of its dots, the power that triggers it, and the times of its sweeps by their dots."""
    dots = slow_dots(*sart_profile(run, 2.5e-7))
    simulator = run.simulator(X | {"range_max_m": 30e3}, {"earth": "flat"}, [SART])
    radar, truth = simulator.scene.radar, simulator.crossings(0)[0].effects["beacon"]
    path = radar.gain * radar.wavelength**2 / (4.0 * math.pi * NM) ** 2 / math.sqrt(radar.loss)  # one way
    eirp = truth.answer_dbm - db(path)
    cycle = 2.0 * float(np.diff(dots).mean()) / SPEED_OF_LIGHT * 1e6
    length = 2.0 * (truth.end - truth.begin) / SPEED_OF_LIGHT * 1e6
    late = 2.0 * (truth.begin - NM) / SPEED_OF_LIGHT * 1e6 + 0.5 * radar.pulse * 1e6
    return [
        Figure.least("e.i.r.p.", round(eirp, 1), 26.0, "dBm"), Figure.within("slow and fast sweep", cycle, 7.9, 1.1, "us"),
        Figure.most("delay", late, 0.5 + 1e-6, "us"), Figure.most("in all", length, 100.0, "us"),
        Figure.most("triggers at", trigger_level(run), -50.0 + 0.2, "dBm"),
    ]  # fmt: skip


def trigger_level(run: Run) -> float:
    """Returns the power of the pulse [dBm] at the farthest SART of a row of them that still answers, in free space."""
    ranges = np.geomspace(40e3, 120e3, 80)
    bodies = [SART | {"position_m": placed(b, float(d), 15)} for b, d in zip(ring(80), ranges, strict=True)]
    simulator = run.simulator(X | {"range_max_m": 130e3}, {"earth": "flat"}, bodies, fidelity="fast")
    answers = [each.effects["beacon"] for each in simulator.crossings(0)]
    return min((each.pulse_dbm for each in answers if each.triggered), default=math.inf)


def bandwidths(run: Run) -> list[Figure]:
    """The bands of a set's receiver for its long and its short pulses, which its maker prints on the same page."""
    figures = []
    for name, nautical, low, high in (("long pulse, 1.2 us", 48, 3.0, 5.0), ("short pulse, 0.07 us", 1.5, 10.0, 25.0)):
        radar = on_scale(run, SETS["X"], nautical)
        figures.append(Figure.by_factor(name, radar.bandwidth / 1e6, low, high, 1.5, "MHz"))
    return figures


def on_scale(run: Run, radar: Table, nautical: float) -> Radar:
    """Returns a set as it transmits on a scale [NM]."""
    return run.simulator(reaching(radar, nautical * NM)).scene.radar


SMALL_SET = {1.5: (80, 2100), 3: (300, 1200), 4: (800, 600)}  # NM: ns, Hz
ARGUS = {0.75: (70, 70), 3: (70, 250), 12: (250, 800), 96: (800, 800)}  # NM: ns, normal and boost


def small_set(run: Run) -> list[Figure]:
    """Pulse and its rate on the scales of a small set."""
    radars = {nm: on_scale(run, {"set": "furuno-1824c"}, nm) for nm in SMALL_SET}
    return [
        figure
        for nm, (pulse, prf) in SMALL_SET.items()
        for figure in (
            Figure.near(f"{nm:g} NM: pulse", radars[nm].pulse * 1e9, pulse, 0.05, "ns"),
            Figure.near(f"{nm:g} NM: rate", radars[nm].prf or 0.0, prf, 0.05, "Hz"),
        )
    ]


def argus(run: Run) -> list[Figure]:
    """The pulse on the scales of another, normal and boosted."""
    return [
        Figure.near(f"{nm:g} NM{what}", on_scale(run, {"set": name}, nm).pulse * 1e9, pulse, 1e-9, "ns")
        for nm, pulses in ARGUS.items()
        for name, what, pulse in zip(("simrad-argus", "simrad-argus-boost"), ("", ", boost"), pulses, strict=True)
    ]


def racon_reply(run: Run) -> list[Figure]:
    """Where the answer of a racon 2 km off begins and how long it is, by the cells over a hundredth of its power."""
    body = {"shape": "point", "rcs_dbsm": -50, "position_m": [0, 2000, 15], "racon": {"letter": "T", "offset_m": [0, 0, 0]}}
    simulator, scan = north(run, X | {"pulse_s": 7e-8, "range_max_m": 9000, "pattern": "gaussian"}, [body])
    power = np.nanmax(scan.power, axis=0)
    answer = scan.range[power > 0.25 * power.max()]
    begin, length = (float(v) * 2.0 / SPEED_OF_LIGHT * 1e6 for v in (answer[0] - 2000.0, answer[-1] - answer[0]))
    return [Figure.most("begins after", begin, 0.7 * 1.2, "us"), Figure.near("length", length, 25.0, 0.2, "us")]


def spokes_and_samples(run: Run) -> list[Figure]:
    """Shapes of scans of two sets."""
    sets = {"HALO20+": (2048, 512), "DRS4D-NXT": (8192, 900)}
    figures = []
    for name, (spokes, samples) in sets.items():
        radar = BARE | {
            "azimuths": spokes,
            "bandwidth_hz": 25e6,
            "sample_rate_hz": 25e6,
            "range_max_m": samples * SPEED_OF_LIGHT / 50e6 - 1,
        }
        scan = run.simulator(radar, {}, [POINT | {"position_m": [0, 500, 15]}], fidelity="fast").scan()
        figures += [Figure(f"{name}: {what}", size, expected, expected) for what, size, expected in
                    (("spokes", scan.power.shape[0], spokes), ("samples", scan.power.shape[1], samples))]  # fmt: skip
    return figures


MEASUREMENTS: dict[str, Measurement] = {
    "R02": partial(rain, ((9.41e9, "v", 16, 0.274), (9.41e9, "h", 50, 1.443)), 0.02),
    "R03": partial(rain, ((9e9, "h", 16, 0.257), (10e9, "h", 16, 0.345)), 0.2),
    "R04": partial(rain, ((3e9, "h", 16, 0.0059),), 0.4),
    "P04": second_trace, "P06": minimum_range, "P08": side_lobe_arcs,
    "A01": slotted_guides, "A03": partial(beams, ((5.0, False), (3.5, False), (25.0, True))),
    "A05": partial(beams, ((20.0, True),)),
    "T03": sart_dots, "T05": sart_signal, "T06": bandwidths, "T07": racon_reply,
    "E01": small_set, "E03": argus, "E05": spokes_and_samples,
}  # fmt: skip
