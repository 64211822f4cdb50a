"""Rows of cross-sections: reflectors and their nulls, ships, boats, and land."""

import math
from collections.abc import Sequence
from functools import partial

import numpy as np

from radar_service.believed.run import BARE, NM, Figure, Measurement, Run, Table, around, placed, ring, sections
from radar_service.believed.targets import CARGO, RIB, YACHT
from radar_service.numerics import Floats

ASPECTS, TURNS = 72, 2  # bearings of a scan, and scans with other headings: aspects 2.5 degrees apart
REQUIRED = {9.41e9: 7.5, 3.05e9: 0.5}  # m2, MSC.164(78)


def tri_lens(radius: float) -> list[Table]:
    """Returns three Luneburg lenses that touch each other, each with its cap towards the middle."""
    return [
        {"reflector": "lens", "radius_m": radius, "heading_deg": turn, "ahead": radius * 2.0 / math.sqrt(3.0)}
        for turn in (0, 120, 240)
    ]


def octahedral(diagonal: float) -> list[Table]:
    """Returns a reflector of crossed square plates of a diagonal [m], hung to catch rain."""
    return [{"reflector": "octahedral", "edge_m": diagonal / 2.0}]


def pattern(run: Run, parts: Sequence[Table], heel: float, frequency: float = 9.41e9) -> Floats:
    """Returns the cross-sections (144,) [m2] of reflectors by the bearing of the radar from the bow, heeled to starboard.

    Copies of it stand round the antenna, each with another heading; their echoes are compared with points of 1 m2.
    """
    radar = BARE | {"frequency_hz": frequency, "height_m": 10, "range_max_m": 2200, "bandwidth_hz": 10e6}
    sections_m2 = np.zeros((ASPECTS, TURNS))
    for turn in range(TURNS):
        bearings = ring(ASPECTS)
        aspect = np.rad2deg(bearings) + turn * 180.0 / ASPECTS
        bodies = [
            {"shape": "reflector"} | _set_up(part, heel, bow, bearing)
            for bearing, bow in zip(bearings.tolist(), (np.rad2deg(bearings) + 180.0 - aspect).tolist(), strict=True)
            for part in parts
        ]
        units = [{"shape": "point", "rcs_dbsm": 0, "position_m": placed(bearing, NM, 10.0)} for bearing in bearings.tolist()]
        scans = [run.simulator(radar, {}, each, fidelity="fast") for each in (bodies, units)]
        powers = [each.scan().power for each in scans]
        for k, bearing in enumerate(bearings.tolist()):
            echo, unit = (float(around(p, s, bearing, NM, 1, 0.0).max()) for p, s in zip(powers, scans, strict=True))
            sections_m2[k, turn] = echo / unit
    return sections_m2.ravel()


def _set_up(part: Table, heel: float, bow: float, bearing: float) -> Table:
    """A part of a reflector 1 NM off, its place and heading, and the heel of the whole as list and trim about its own heading."""
    turn = float(part.get("heading_deg", 0.0))
    ahead, heading = math.radians(turn), math.radians(bow + turn)
    east, north, up = placed(bearing, NM, 10.0)
    off = float(part.get("ahead", 0.0))
    tilt, side = math.radians(heel), math.radians(bow + 90.0)  # a stack leans over the starboard side
    lean, up = float(part.get("up", 0.0)) * math.sin(tilt), up + float(part.get("up", 0.0)) * math.cos(tilt)
    east, north = east + lean * math.sin(side), north + lean * math.cos(side)
    return {key: value for key, value in part.items() if key not in ("ahead", "up")} | {
        "position_m": [east + off * math.sin(heading), north + off * math.cos(heading), up],
        "heading_deg": (bow + turn + 180.0) % 360.0 - 180.0,
        "list_deg": heel * math.cos(ahead), "trim_deg": heel * math.sin(ahead),
    }  # fmt: skip


def nulls(weak: np.ndarray) -> tuple[float, float]:
    """Returns the widest null [degrees] and the azimuths that are none [degrees] in all, round the circle."""
    step, count = 360.0 / len(weak), len(weak)
    if weak.all():
        return 360.0, 0.0
    start = int(np.flatnonzero(~weak)[0])
    widest = run = 0
    for value in np.roll(weak, -start):
        run = run + 1 if value else 0
        widest = max(widest, run)
    return widest * step, float((~weak).sum()) * 360.0 / count


def meets(run: Run, parts: Sequence[Table], heel: float, frequency: float) -> tuple[float, float]:
    """Returns the widest null and the azimuths [degrees] with the cross-section that MSC.164(78) asks for."""
    return nulls(pattern(run, parts, heel, frequency) < REQUIRED[frequency])


def small_vessel_reflector(run: Run) -> list[Figure]:
    """Three lenses of 0.15 m, upright and heeled: azimuths with the required cross-section, and the widest null."""
    figures = []
    for frequency, section in REQUIRED.items():
        for heel in (0.0, 10.0, 20.0):
            widest, held = meets(run, tri_lens(0.15), heel, frequency)
            name = f"{section:g} m2, heel {heel:g}"
            figures += [
                Figure.least(f"{name}: azimuths", held, 280.0, "deg"),
                Figure.most(f"{name}: null", widest, 10.0, "deg"),
            ]
    return figures


MARKET: dict[str, list[Table]] = {
    "12 in": octahedral(0.305),
    "16 in": octahedral(0.406),
    "18 in": octahedral(0.457),
    "corner": [{"reflector": "corner", "edge_m": 0.3}],
    "tube, 4 in": [{"reflector": "octahedral", "edge_m": 0.05, "up": 0.08 * k, "heading_deg": 15 * k} for k in range(7)],
}


def on_the_market(run: Run) -> list[Figure]:
    """How many of the engine's reflectors of usual sizes meet the draft, heeled by 20 and 10 degrees; small lenses are three."""
    kinds = [*MARKET.values(), tri_lens(0.10)]
    counts = {}
    for heel in (20.0, 10.0):
        results = [meets(run, parts, heel, 9.41e9) for parts in kinds]
        counts[heel] = sum(widest <= 10.0 and held >= 280.0 for widest, held in results)
    return [Figure("meet it to 20 degrees", counts[20.0], 0, 0), Figure("meet it to 10 degrees", counts[10.0], 0, 1)]


BLIND = 2.0  # m2: a yacht with less is hardly tracked (row F04)


def octahedral_blind(run: Run) -> list[Figure]:
    """Azimuths in which an octahedral reflector of 16 in has less than 2 m2, upright and heeled by 15 degrees."""
    blind = {heel: 360.0 * float(np.mean(pattern(run, octahedral(0.406), heel) < BLIND)) for heel in (0.0, 15.0)}
    return [Figure.within("upright", blind[0.0], 120, 30, "deg"), Figure.within("heeled 15", blind[15.0], 180, 30, "deg")]


WAVES = {"multipath": True, "sea_state": 3, "seaway": True}


def ship_sections(run: Run, ship: Table, aspects: Floats, distance: float = 2000.0, air: Table = WAVES) -> Floats:
    """Returns the effective cross-sections (K,) [dBsm] of a ship seen at aspects from its bow [degrees], on a ring of copies."""
    bearings = ring(len(aspects))
    bodies = [
        ship
        | {"position_m": placed(bearing, distance, 0.0), "heading_deg": (math.degrees(bearing) - aspect) % 360.0 - 180.0}
        for bearing, aspect in zip(bearings.tolist(), aspects.tolist(), strict=True)
    ]
    return sections(run, BARE | {"range_max_m": distance + 1500.0, "bandwidth_hz": 50e6}, air, bodies)


BOW_AND_QUARTER = np.array([a for a in np.arange(4.0, 360.0, 12.0) if abs(a % 180.0 - 90.0) > 12.0])
SHIP_75 = {"shape": "hull", "hull_type": "cargo", "length_m": 75, "beam_m": 12.5, "height_m": 17}


def bow_and_quarter(run: Run) -> list[Figure]:
    """Medians of cargo ships in sea state 3 over aspects more than 12 degrees off broadside."""
    bands = ((SHIP_75, 30.0, 44.0), (CARGO, 35.0, 52.0))
    return [
        Figure(f"{ship['length_m']} m", float(np.median(ship_sections(run, ship, BOW_AND_QUARTER))), low, high, "dBsm")
        for ship, low, high in bands
    ]


def broadside(run: Run) -> list[Figure]:
    """The mean power within 2 degrees of broadside over the median of bow and quarter, of the same two ships."""
    abeam = np.concatenate([90.0 + np.linspace(-2, 2, 9), 270.0 + np.linspace(-2, 2, 9)])
    figures = []
    for ship in (SHIP_75, CARGO):
        median = float(np.median(ship_sections(run, ship, BOW_AND_QUARTER)))
        mean = 10.0 * np.log10(np.mean(10.0 ** (ship_sections(run, ship, abeam) / 10.0)))
        figures.append(Figure(f"{ship['length_m']} m", float(mean - median), 15.0, 25.0, "dB"))
    return figures


PERSON = 1.0  # m2 (Skolnik, Introduction to Radar Systems, table of cross-sections: man)
OUTBOARD = {"shape": "box", "material": "aluminium", "length_m": 0.4, "width_m": 0.35, "height_m": 0.7}


def median_section(run: Run, body: Table) -> float:
    """Returns the median cross-section [m2] of a boat over 16 aspects in free space."""
    return float(10.0 ** (np.median(ship_sections(run, body, np.arange(7.0, 367.0, 22.5), NM, {})) / 10.0))


def inflatable(run: Run) -> list[Figure]:
    """A hull of rubber of 4.8 m, its outboard engine as a box, and a man, summed."""
    section = median_section(run, RIB) + median_section(run, OUTBOARD) + PERSON
    return [Figure.by_factor("4.8 m with a man", section, 2.5, 2.5, 2.0, "m2")]


def boat_classes(run: Run) -> list[Figure]:
    """A small inflatable, its outboard engine and a man; yachts of fibreglass of 7 and 14 m and a crew of two; summed."""
    boats = {
        "inflatable": ([RIB | {"length_m": 3.0, "beam_m": 1.5, "height_m": 0.5}, OUTBOARD], 1, 1.0),
        "yacht, 7 m": ([YACHT | {"length_m": 7, "beam_m": 2.5, "height_m": 1.8}], 2, 5.0),
        "yacht, 14 m": ([YACHT | {"length_m": 14, "beam_m": 4.2, "height_m": 3}], 2, 10.0),
    }
    sections_m2 = {
        name: sum(median_section(run, part) for part in parts) + crew * PERSON for name, (parts, crew, _) in boats.items()
    }
    return [Figure.by_factor(name, sections_m2[name], low, low, 3.0, "m2") for name, (_, _, low) in boats.items()]


LAND_RANGE, LAND_HALF = 5000.0, 600.0  # m: middle of the land that is measured, and half of its depth
RELIEF_SLOPE, RELIEF_LENGTH = (
    math.radians(1.0),
    150.0,
)  # low relief: slopes below 2 degrees, less than 30 m high (Billingsley)


def low_relief(rise: float) -> Floats:
    """Returns heights (121, 121) [m], north to south: noise of slopes of 1 degree rms on a plane that rises by `rise` a metre."""
    rng, cells = np.random.default_rng(1), 121
    step = 2.0 * LAND_HALF / (cells - 1)
    frequency = np.hypot(*np.meshgrid(np.fft.fftfreq(cells, step), np.fft.fftfreq(cells, step)))
    spectrum = np.fft.fft2(rng.standard_normal((cells, cells))) * np.exp(-((np.pi * RELIEF_LENGTH * frequency) ** 2) / 2.0)
    noise = np.fft.ifft2(spectrum).real
    noise *= RELIEF_SLOPE / np.hypot(*np.gradient(noise, step)).std()
    return np.asarray(noise - noise.min() + 1.0 + rise * np.linspace(2.0 * LAND_HALF, 0.0, cells)[:, None])


def land_sigma0(run: Run, depression_deg: float, rise: float = 0.0) -> tuple[float, float]:
    """Returns mean sigma0 [dB] and the Weibull spread aw of cells of 1000 m2, of low relief seen at a depression angle."""
    heights = low_relief(rise)
    middle = float(heights[40:80, 40:80].mean())
    above = LAND_RANGE * math.tan(math.radians(depression_deg))
    ground = {
        "heightmap": run.height_map(f"relief-{depression_deg:g}-{rise:g}", heights),
        "extent_m": [2 * LAND_HALF, 2 * LAND_HALF],
    }
    radar: Table = BARE | {
        "azimuths": 2048, "beamwidth_deg": 0.75, "beamwidth_el_deg": 60, "range_max_m": 6500, "bandwidth_hz": 10e6,
        "power_w": 1e9, "height_m": max(middle + above, 1.0),
    }  # fmt: skip
    lift = max(0.0, 1.0 - middle - above)
    field = ground | {"position_m": [0, LAND_RANGE, lift], "material": "vegetation"}
    land = run.simulator(radar, {"earth": "flat"}, [field], sector=(-0.06, 0.06)).scan()
    point = {"shape": "point", "rcs_dbsm": 0, "position_m": [0, LAND_RANGE, radar["height_m"]]}
    unit = run.simulator(radar, {"earth": "flat"}, [point], sector=(-0.06, 0.06))
    cells = unit.scan()
    turn = 2.0 * np.pi / radar["azimuths"]
    of_one = float(np.nansum(cells.power.astype(np.float64) * cells.range)) * turn * unit.range_step
    near = np.abs(cells.range - LAND_RANGE) < 0.7 * LAND_HALF
    rows = np.abs(np.angle(np.exp(1j * land.azimuth))) < 0.05
    power = land.power[np.ix_(rows, near)].astype(np.float64) * (cells.range[near] / LAND_RANGE) ** 3
    seen = np.log(power[power > power.max() * 1e-9])
    return 10.0 * math.log10(power.mean() / of_one), float(seen.std() * math.sqrt(6.0) / math.pi)


def land(rows: Sequence[tuple[float, float, float, float]], run: Run) -> list[Figure]:
    """Mean and spread by depression angle. rows: depression [degrees], rise of the land, published mean [dB] and aw."""
    figures = []
    for depression, rise, mean, spread in rows:
        computed, aw = land_sigma0(run, depression, rise)
        name = f"{depression:g} degrees"
        figures += [Figure.within(f"{name}: mean", computed, mean, 5.0, "dB"), Figure.within(f"{name}: aw", aw, spread, 0.5)]
    return figures


LOW_RELIEF = ((0.125, 0.0, -33.0, 3.8), (1.1, 0.0, -30.0, 3.0))
FROM_BELOW = ((-0.125, 0.01, -31.0, 3.4), (-0.5, 0.02, -27.0, 3.3), (-1.5, 0.05, -26.0, 2.3))

MEASUREMENTS: dict[str, Measurement] = {
    "F01": small_vessel_reflector, "F03": on_the_market, "F06": octahedral_blind, "H03": bow_and_quarter, "H05": broadside,
    "B01": inflatable, "B03": boat_classes, "L01": partial(land, LOW_RELIEF), "L03": partial(land, FROM_BELOW),
}  # fmt: skip
