"""Rows of detection: at which ranges targets are seen, in scans with noise over the sea, at a Pfa of 1e-4."""

import math
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from radar_service.believed.run import (
    NM,
    SETS,
    SHORT,
    Figure,
    Measurement,
    Run,
    Table,
    X,
    around,
    db,
    placed,
    reaching,
    ring,
)
from radar_service.numerics import Floats, Indices, Singles, known_level_factor
from radar_service.radar import Radar
from radar_service.scans import Scan
from radar_service.simulator import Simulator

PFA, CRITERION, SCANS = 1e-4, 0.8, 20  # MSC.192(79) 5.3.1.1: 8 of 10 scans
AIR = {"noise": True, "multipath": True}
Level = Callable[[Scan, float, int], float]  # threshold [W] of a scan about a bearing [rad] and in a cell


def spokes_of_beam(radar: Radar) -> int:
    """Returns the spokes within the half-power beam, an odd number: those over which a ship's radar integrates."""
    return 2 * int(radar.beamwidth / 2.0 / radar.azimuth_step) + 1


def over_beam(power: Singles, radar: Radar) -> Floats:
    """Returns the mean (A, N) of power (A, N) [W] over the spokes of the beam about each, as `MarineThreshold` integrates."""
    half = spokes_of_beam(radar) // 2
    shifted = [np.roll(power, k, axis=0) for k in range(-half, half + 1)]
    return np.asarray(np.mean(shifted, axis=0, dtype=np.float64))


def threshold_in_noise(simulator: Simulator) -> float:
    """Returns the power [W], averaged over the pulses of the beam, that noise alone exceeds with PFA."""
    radar = simulator.scene.radar
    return known_level_factor(PFA, radar.pulses_integrated * spokes_of_beam(radar)) * simulator.noise_power


def detected(
    run: Run, radar: Table, environment: Table, bodies: Sequence[Table], scans: int = SCANS, level: Level | None = None,
    own_ship: Table | None = None, extent: float = 0.0, fidelity: str = "fast",
) -> Floats:  # fmt: skip
    """Returns the share of scans (B,) in which each of some bodies exceeds the threshold in a cell beside its own.

    level: of the scan; by default that of PFA over the mean noise, and power is averaged over the beam.
    extent: of a body along range, on either side [m].
    """
    simulator = run.simulator(radar, environment, bodies, own_ship, fidelity=fidelity)
    noise, hits = threshold_in_noise(simulator), np.zeros(len(bodies))
    cells = 1 + math.ceil(extent / simulator.range_step)
    for _ in range(scans):
        scan = simulator.scan()
        power = scan.power if level else over_beam(scan.power, simulator.scene.radar)
        crossings = {int(each.body.split()[-1]): each for each in simulator.crossings(scan.number)}
        for number, crossing in crossings.items():
            cell = int(crossing.range / simulator.range_step)
            threshold = noise if level is None else level(scan, crossing.bearing, cell)
            hits[number] += around(power, simulator, crossing.bearing, crossing.range, cells).max() > threshold
    return np.asarray(hits / scans)


def first_detection(
    run: Run, radar: Table, target: Table, height: float, nautical: Floats, environment: Table = AIR,
    criterion: float = CRITERION, aspects: int = 1, extent: float = 0.0,
) -> float:  # fmt: skip
    """Returns the farthest of some ranges [NM] at which copies of a target are detected in 8 of 10 scans, 0 where none is.

    aspects: of a hull, at each range so many, whose mean over 10 scans counts; a point has one, and 20 scans.
    """
    scans, fidelity = (SCANS, "fast") if aspects == 1 else (SCANS // 2, "balanced")
    turn = ring(len(nautical) * aspects).reshape(len(nautical), aspects)
    reach = float(nautical.max()) * NM * 1.05 + 500.0
    radar = reaching(radar, reach)
    bodies = [
        target | {"position_m": placed(bearing, float(distance) * NM, height), "heading_deg": k * 360.0 / aspects + 8.0}
        for distance, bearings in zip(nautical, turn, strict=True)
        for k, bearing in enumerate(bearings.tolist())
    ]
    share = (
        detected(run, radar, environment, bodies, scans, extent=extent, fidelity=fidelity).reshape(turn.shape).mean(axis=1)
    )
    return float(nautical[share >= criterion].max(initial=0.0))


# Small targets of table 2 of MSC.192(79): height [m], then by band the cross-section [m2] and the range [NM]; what fluctuates.
TABLE_2 = {
    "D05": (4.0, {"X": (7.5, 5.0), "S": (0.5, 3.7)}, 0),
    "D06": (3.5, {"X": (10.0, 4.9), "S": (1.0, 3.6)}, 0),
    "D07": (3.5, {"X": (5.0, 4.6), "S": (0.5, 3.0)}, 0),
    "D08": (2.0, {"X": (2.5, 3.4), "S": (1.4, 3.0)}, 1),
}
SHIPS = {"D03": (110.0, 17.0, 10.0, 11.0), "D04": (50.0, 9.0, 5.0, 8.0)}  # length, beam, height [m], range [NM]
SHORES_DRAWN = 10
SHORES = {"D01": ((60.0, 20.0),), "D02": ((6.0, 8.0), (3.0, 6.0))}  # height [m], range [NM]


def small_targets(row: str, run: Run) -> list[Figure]:
    """First detection of a point, as the footnotes of the table call it."""
    height, bands, swerling = TABLE_2[row]
    return [
        Figure.least(
            band,
            first_detection(run, SETS[band], _point(section, swerling), height, np.linspace(0.5 * floor, 2.0 * floor, 36)),
            floor, "NM",
        )
        for band, (section, floor) in bands.items()
    ]  # fmt: skip


def _point(section: float, swerling: int = 0) -> Table:
    return {"shape": "point", "rcs_dbsm": db(section), "swerling": swerling}


def ships(row: str, run: Run) -> list[Figure]:
    """First detection of a cargo ship of steel, in the mean of eight aspects."""
    length, beam, height, floor = SHIPS[row]
    hull = {"shape": "hull", "hull_type": "cargo", "length_m": length, "beam_m": beam, "height_m": height}
    nautical = np.linspace(0.8 * floor, 1.6 * floor, 5)
    return [
        Figure.least(
            band,
            first_detection(run, radar, hull, 0.0, nautical, aspects=8, extent=length / 2.0), floor, "NM",
        )
        for band, radar in SETS.items()
    ]  # fmt: skip


def shores(row: str, run: Run) -> list[Figure]:
    """Whether a beach that rises over 400 m to a height, 2 km wide and 1 km deep, is detected, and how far."""
    figures = []
    for band, radar in SETS.items():
        for height, floor in SHORES[row]:
            seen = [
                n for n in np.linspace(0.8 * floor, 1.4 * floor, 7) if shore_share(run, radar, height, float(n)) >= CRITERION
            ]
            figures.append(Figure.least(f"{band}, {height:g} m", float(max(seen, default=0.0)), floor, "NM"))
    return figures


def shore_share(run: Run, radar: Table, height: float, nautical: float) -> float:
    """Returns the share of scans, each of another draw of its scatterers, in which a cell of a shore exceeds the threshold."""
    rise = np.tile(np.clip(np.linspace(height * 2.5, -0.02 * height, 51), -1.0, height)[:, None], (1, 41))
    shore = {
        "heightmap": run.height_map(f"shore-{height:g}-m", rise), "extent_m": [2000, 1000],
        "position_m": [0, nautical * NM + 500.0, 0],
    }  # fmt: skip
    half, hits = 1000.0 / (nautical * NM), 0
    for seed in range(SHORES_DRAWN):
        scene = reaching(radar, nautical * NM + 2500.0), AIR, [shore]
        simulator = run.simulator(*scene, seed=seed, sector=(-2.0 * half, 2.0 * half), fidelity="fast")
        scan, beams = over_beam(simulator.scan().power, simulator.scene.radar), half / simulator.scene.radar.beamwidth
        power = around(scan, simulator, 0.0, nautical * NM + 300.0, round(300.0 / simulator.range_step), beams)
        hits += float(power.max()) > threshold_in_noise(simulator)  # of each cell, as of a point's
    return hits / SHORES_DRAWN


NEAR = SHORT | {"eclipsing": True, "range_max_m": 2778}  # of the scale of 1.5 NM


def near_buoy(run: Run) -> list[Figure]:
    """A buoy of 10 m2, 3.5 m high, at 48 distances from 40 m to 1 NM, over the calm sea: the least share of scans."""
    places = [placed(bearing, float(d), 3.5) for bearing, d in zip(ring(48), np.geomspace(40.0, NM, 48), strict=True)]
    share = detected(run, X | NEAR, AIR, [_point(10.0) | {"position_m": place} for place in places])
    return [Figure.least("least share of scans, 40 m to 1 NM", float(share.min()), CRITERION)]


def _dip(values: Floats) -> float:
    """How far power falls between the two ends of some values, below the lower end [dB]."""
    return db(min(values[0], values[-1]) / float(values.min()))


TWO = 3.0  # dB: two echoes with such a dip between them are two
APART = np.array([0.55, 0.75, 0.95])  # shares of the scale of 1.5 NM


def apart_in_range(run: Run) -> list[Figure]:
    """The least distance of two points on a bearing that have a dip of 3 dB between them, of 10 to 80 m."""
    return [Figure.most("apart by", _least(run, np.arange(10.0, 85.0, 5.0), _pair_in_range), 40.0, "m")]


def apart_in_bearing(run: Run) -> list[Figure]:
    """The least angle of two points at a range that have a dip of 3 dB between them, of 0.5 to 4 degrees."""
    return [Figure.most("apart by", _least(run, np.arange(0.5, 4.1, 0.1), _pair_in_bearing), 2.5, "degrees")]


def _least(run: Run, distances: Floats, dip: Callable[[Run, float, float], float]) -> float:
    resolved = [d for d in distances if all(dip(run, float(d), float(share) * 1.5 * NM) > TWO for share in APART)]
    return float(min(resolved, default=math.inf))


def _pair_in_range(run: Run, distance: float, far: float) -> float:
    bodies = [_point(10.0) | {"position_m": placed(0.0, far + shift, 3.5)} for shift in (-distance / 2.0, distance / 2.0)]
    simulator = run.simulator(X | NEAR | {"sample_rate_hz": 1e8}, {}, bodies, sector=(-0.01, 0.01))
    first, last = (int(np.hypot(far + shift, 11.5) / simulator.range_step) for shift in (-distance / 2.0, distance / 2.0))
    return _dip(np.asarray(simulator.scan().power[0, first : last + 1], dtype=np.float64))


def _pair_in_bearing(run: Run, angle: float, far: float) -> float:
    half = math.radians(angle) / 2.0
    bodies = [_point(10.0) | {"position_m": placed(math.pi + side, far, 3.5)} for side in (-half, half)]
    simulator = run.simulator(X | NEAR | {"azimuths": 4096}, {}, bodies, sector=(math.pi - 0.05, math.pi + 0.05))
    cell, turn = int(np.hypot(far, 11.5) / simulator.range_step), 2.0 * math.pi / 4096
    first, last = round((math.pi - half) / turn), round((math.pi + half) / turn)
    return _dip(np.asarray(simulator.scan().power[first : last + 1, cell], dtype=np.float64))


def rolling(run: Run) -> list[Figure]:
    """The mean loss of 16 targets round own ship at 3 NM, which rolls or pitches by 10 degrees, over 10 scans."""
    bodies = [_point(10.0) | {"position_m": placed(bearing, 3 * NM, 3.5)} for bearing in ring(16)]
    level = {}
    for name, sway in {"at rest": {}, "roll": {"roll_deg": 10.0}, "pitch": {"pitch_deg": 10.0}}.items():
        simulator = run.simulator(X | {"range_max_m": 7000}, {"noise": True}, bodies, {"heading_deg": 0, **sway})
        level[name] = np.mean(
            [each.snr_db for k in range(10) for each in simulator.crossings(k, radiometric=True) if each.snr_db]
        )
    return [
        Figure.most(f"loss by {name} of 10 degrees", float(level["at rest"] - level[name]), 2.0, "dB")
        for name in ("roll", "pitch")
    ]


def horizon(run: Run, antenna: float, target: float, earth: float | str = "4/3") -> float:
    """Returns the farthest distance [NM] at which scans have an echo of a point; antenna, target: heights [m]."""
    about = 2.2 * (antenna**0.5 + target**0.5)
    nautical, bearings = np.linspace(0.9 * about, 1.1 * about, 128), ring(128)
    bodies = [
        {"shape": "point", "rcs_dbsm": 40, "position_m": placed(b, n * NM, target)}
        for b, n in zip(bearings, nautical, strict=True)
    ]
    radar = X | {"height_m": antenna, "range_max_m": 40000, "pattern": "gaussian"}
    simulator = run.simulator(radar, {"earth": earth}, bodies, fidelity="fast")
    power = simulator.scan().power
    floor = 1e-6 * power.max()  # of arithmetic, far below what a lit point has
    return max(
        n
        for b, n in zip(bearings, list(map(float, nautical)), strict=True)
        if around(power, simulator, b, n * NM, 1).max() > floor
    )


def raymarine(run: Run) -> list[Figure]:
    """The table of ranges to the horizon."""
    printed = {(3.0, 3.0): 7.8, (3.0, 10.0): 10.9, (5.0, 3.0): 8.9, (5.0, 10.0): 12.0}
    return [Figure.near(f"{a:g} m, {t:g} m", horizon(run, a, t), p, 0.02, "NM") for (a, t), p in printed.items()]


def furuno(run: Run) -> list[Figure]:
    """A horizon, and the radar's over the optical one: of an earth of 7/6, the refraction of light."""
    computed, light = horizon(run, 9.0, 16.0), horizon(run, 9.0, 16.0, 7 / 6)
    return [
        Figure.near("radar horizon", computed, 15.4, 0.02, "NM"),
        Figure.near("over the optical one", computed / light, 1.06, 0.02),
    ]


def beside(cell: int) -> Indices:
    """Returns 40 cells on either side of a cell, 8 left out: a cell-averaging threshold has their mean."""
    return np.asarray(np.r_[max(cell - 48, 0) : cell - 8, cell + 9 : cell + 49])


def local_level(scan: Scan, bearing: float, cell: int, factor: float | None = None) -> float:
    """Returns a threshold [W]: the mean beside a cell times a factor, by default that of PFA in noise."""
    spoke = round(bearing / (2.0 * math.pi) * len(scan.azimuth)) % len(scan.azimuth)
    cells = beside(cell)
    factor = len(cells) * (PFA ** (-1.0 / len(cells)) - 1.0) if factor is None else factor
    return float(scan.power[spoke, cells].mean() * factor)


# A dome of 24 in and 4 kW on a boat, at the pulse of long ranges.
DOME = X | {"beamwidth_deg": 3.9, "gain_dbi": 26, "power_w": 4e3, "pulse_s": 8e-7, "height_m": 4, "azimuths": 720}
SEA_2 = AIR | {"sea_state": 2, "seaway": True}
YACHT = {"shape": "hull", "hull_type": "yacht", "material": "fibreglass", "length_m": 10, "beam_m": 3.3, "height_m": 2.3}
CARGO = {"shape": "hull", "hull_type": "cargo", "length_m": 140, "beam_m": 21, "height_m": 28}
RIB = {"shape": "hull", "material": "rubber", "length_m": 4.8, "beam_m": 2.0, "height_m": 0.6}


def seen_by_experience(run: Run) -> list[Figure]:
    """A yacht of fibreglass seen by a ship, and a cargo ship of 140 m by a yacht's dome, in sea state 2, in 8 of 10 scans."""
    yacht = first_detection(run, X, YACHT, 0.0, np.linspace(1.0, 6.0, 11), SEA_2, aspects=4)
    cargo = first_detection(run, DOME, CARGO, 0.0, np.linspace(7.0, 17.0, 6), SEA_2, aspects=2, extent=70)
    return [Figure.by_factor("yacht", yacht, 3.0, 4.0, 1.3, "NM"), Figure.by_factor("ship", cargo, 12.0, 12.0, 1.3, "NM")]


def tracking_lost(run: Run) -> list[Figure]:
    """Where a boat's dome sees a rigid inflatable in fewer than half of the scans, in sea state 2."""
    bare = first_detection(run, DOME, RIB, 0.0, np.linspace(0.5, 6.0, 12), SEA_2, criterion=0.5, aspects=4)
    return [Figure.near("bare", bare, 4.0, 0.25, "NM")]  # no body is an active reflector


def sart_range(run: Run) -> list[Figure]:
    """The farthest of some ranges at which the first dot of a SART 1 m high is detected in 8 of 10 scans."""
    nautical = np.linspace(3.0, 9.0, 13)
    bodies = [{"shape": "point", "rcs_dbsm": -20, "position_m": placed(b, n * NM, 1.0), "sart": {"offset_m": [0, 0, 0]}}
              for b, n in zip(ring(len(nautical)), nautical, strict=True)]  # fmt: skip
    simulator, hits = run.simulator(X | {"range_max_m": 40000}, AIR, bodies, fidelity="fast"), np.zeros(len(nautical))
    for _ in range(10):
        scan = simulator.scan()
        for each in simulator.crossings(scan.number):
            dot = each.effects["beacon"].first_dot
            if dot is not None:
                power = around(over_beam(scan.power, simulator.scene.radar), simulator, each.bearing, dot, 3)
                hits[int(each.body.split()[-1])] += power.max() > threshold_in_noise(simulator)
    return [Figure.least("first detection", float(nautical[hits >= 8].max(initial=0.0)), 5.0, "NM")]


MEASUREMENTS: dict[str, Measurement] = {
    **{row: partial(small_targets, row) for row in TABLE_2},
    **{row: partial(ships, row) for row in SHIPS},
    **{row: partial(shores, row) for row in SHORES},
    "D09": near_buoy, "D10": apart_in_range, "D11": apart_in_bearing, "D14": rolling,
    "P01": raymarine, "P03": furuno, "B05": seen_by_experience, "B07": tracking_lost, "T01": sart_range,
}  # fmt: skip
