"""Rows of the sea: mean reflectivity from scans of clutter alone, sea states, and detection in clutter."""

import math
from functools import partial

import numpy as np

from radar_service.believed.run import BARE, NM, SHORT, Figure, Measurement, NotExpressed, Run, S, Table, X, db, placed, ring
from radar_service.believed.targets import PFA, beside, detected, local_level

STATES = (1, 2, 3, 4, 5)
FREQUENCIES = {"X": 9.3e9, "S": 3.0e9}
# Nathanson's tables, by polarization and grazing angle [degrees]: sigma0 [dB] at sea states 1 to 5.
NATHANSON: dict[str, tuple[str, float, dict[str, tuple[float | None, ...]]]] = {
    "N01": ("h", 0.1, {"X": (-71, -59, -53, -48, -42), "S": (-80, -75, -68, -63, -63)}),
    "N03": ("h", 1.0, {"X": (-51, -46, -40, -36, -34), "S": (-66, -55, -48, -45, -42)}),
    "N05": ("h", 10.0, {"X": (-51, -43, -37, -34, -30), "S": (None, -51, -46, -40, -38)}),
    "N06": ("v", 0.1, {"X": (-65, -56, -51, -48, -44), "S": (-80, -75, -75, -67, -63)}),
    "N08": ("v", 1.0, {"X": (-50, -44, -39, -37, -33), "S": (-56, -53, -48, -42, -38)}),
    "N09": ("v", 3.0, {"X": (-45, -41, -38, -35, -33), "S": (-52, -49, -43, -38, -35)}),
    "N10": ("v", 10.0, {"X": (-42, -36, -32, -29, -25), "S": (-40, -38, -34, -31, -28)}),
}
CELL_DB, MEAN_DB = 5.0, 3.0  # the tolerance of these rows: of a cell, and of the mean of all
SEA_RANGE, SEA_SPAN = 3000.0, 150.0  # m: slant range at which the sea is measured, and half of the ranges that are averaged


def reflectivity(run: Run, frequency: float, polarization: str, grazing_deg: float, state: int) -> float:
    """Returns mean sigma0 [dB] over a scan of the sea alone: its power over what 1 m2 of sea would return, beam and pulse summed.

    The mean of power over all directions is that of the wind; 1 m2 is a point on the water in the same cells, without multipath.
    """
    height = SEA_RANGE * np.sin(np.deg2rad(grazing_deg))
    radar = BARE | {
        "frequency_hz": frequency, "polarization": polarization, "height_m": height, "range_max_m": 3600, "power_w": 1e9,
        "bandwidth_hz": 10e6, "beamwidth_el_deg": 60,
    }  # fmt: skip
    sea = run.simulator(radar, {"earth": "flat", "sea_state": state, "sea_texture_shape": 1000}, fidelity="fast").scan()
    point = {"shape": "point", "rcs_dbsm": 0, "position_m": placed(0.0, float(np.sqrt(SEA_RANGE**2 - height**2)), 0.01)}
    unit = run.simulator(radar, {"earth": "flat"}, [point], fidelity="fast")
    cells = unit.scan()
    near = np.abs(cells.range - SEA_RANGE) < SEA_SPAN
    area = cells.range[near] * unit.range_step * 2.0 * np.pi / len(cells.azimuth)  # m2 of each cell
    of_one = float((cells.power[:, near].astype(np.float64) * area).sum())  # W m2: 1 m2 anywhere in beam and pulse
    level = sea.power[:, near].astype(np.float64) * (cells.range[near] / SEA_RANGE) ** 3
    return db(float(level.mean()) / of_one)


def nathanson(row: str, run: Run) -> list[Figure]:
    """The cells of a table by sea state, in two bands, and the mean of their differences."""
    polarization, grazing, bands = NATHANSON[row]
    figures = [
        Figure.within(
            f"{band}, state {state}",
            reflectivity(run, FREQUENCIES[band], polarization, grazing, state),
            level,
            CELL_DB,
            "dB",
        )
        for band, levels in bands.items()
        for state, level in zip(STATES, levels, strict=True)
        if level is not None
    ]
    mean = float(np.mean([figure.computed - 0.5 * (figure.low + figure.high) for figure in figures]))
    return [*figures, Figure.within("mean difference", mean, 0.0, MEAN_DB, "dB")]


JRC_WAVES = (0.6, 0.9, 1.2, 2.0, 3.0, 4.0)  # m


def wave_heights(run: Run, states: tuple[int, ...] = (1, 2, 3, 4, 5, 6)) -> list[float]:
    """Returns the significant wave heights [m] of sea states: four standard deviations of a body that floats on the sea."""
    heights = []
    for state in states:
        raft = {
            "shape": "point",
            "rcs_dbsm": 0,
            "position_m": [0, 300, 1],
            "hull": {"length_m": 0.5, "beam_m": 0.5, "draught_m": 0.1},
        }
        simulator = run.simulator(BARE, {"sea_state": state, "seaway": {"period_s": 12}}, [raft])
        motion = simulator.scene.bodies[0].motion
        heights.append(4.0 * float(np.std(motion.pose(np.arange(0.0, 7200.0, 1.3)).position[:, 2])))
    return heights


def sea_states(run: Run) -> list[Figure]:
    """Wave heights of JRC's six sea states as states of the engine's scale, between whose heights they are interpolated."""
    computed = wave_heights(run)
    return [
        Figure.within(
            f"our state of {wave:g} m", float(np.interp(np.log(wave), np.log(computed), np.arange(1.0, 7.0))), state, 1.0
        )
        for state, wave in enumerate(JRC_WAVES, 1)
    ]


# JRC's classes of detection, by the middle of the two sea states of a column: band, cross-section [m2], range [NM], classes.
CLASSES = {"V": (0.8, 1.0), "V-M": (0.5, 1.0), "M-NV": (0.0, 0.8), "NV": (0.0, 0.5)}
IN_CLUTTER = {
    "C01": (X, 5.0, 0.7, ("V", "V-M", "M-NV", "NV")),
    "C02": (X, 10.0, 0.7, ("V", "V", "V", "V-M")),
    "C03": (S, 0.5, 0.4, ("V", "V", "V-M", "M-NV")),
}
COLUMNS = ((0.6, 0.9), (0.9, 1.2), (1.2, 2.0), (2.0, 3.0))  # m: significant heights of the two states of each column
CLUTTER_POINTS, CLUTTER_SCANS, CALIBRATION_SCANS = 24, 10, 5


def detection_in_clutter(row: str, run: Run) -> list[Figure]:
    """The share of scans that detect a point in clutter, in waves of the mean height of a column."""
    radar, section, nautical, classes = IN_CLUTTER[row]
    figures = []
    for column, name in enumerate(classes):
        wave = math.sqrt(COLUMNS[column][0] * COLUMNS[column][1])
        beside = [CLASSES[classes[k]] for k in range(max(0, column - 1), min(len(classes), column + 2))]  # one column
        low, high = min(each[0] for each in beside), max(each[1] for each in beside)
        share = seen_in_clutter(run, radar, section, nautical * NM, wave)
        figures.append(Figure(f"{name}, waves of {wave:.3g} m", share, low, high))
    return figures


def seen_in_clutter(
    run: Run, radar: Table, section: float, distance: float, wave: float, scans: int = CLUTTER_SCANS
) -> float:  # fmt: skip
    """Returns the share of scans in which points round the antenna exceed a threshold that PFA of the cells of sea alone do."""
    short = radar | SHORT | {"range_max_m": 2500}
    air = {"noise": True, "multipath": True, "wave_height_m": wave}
    sea = run.simulator(short, air, fidelity="fast")
    middle = int(distance / sea.range_step)
    powers = [sea.scan().power for _ in range(CALIBRATION_SCANS)]
    ratio = [p[:, c] / p[:, beside(c)].mean(axis=1) for p in powers for c in range(middle - 20, middle + 21)]
    level = partial(local_level, factor=float(np.quantile(np.concatenate(ratio), 1.0 - PFA)))
    places = [placed(bearing, distance, 2.0) for bearing in ring(CLUTTER_POINTS)]
    bodies = [{"shape": "point", "rcs_dbsm": db(section), "swerling": 1, "position_m": place} for place in places]
    return float(detected(run, short, air, bodies, scans, level).mean())


def no_wave_age(run: Run) -> list[Figure]:
    """Raises NotExpressed: the level of clutter follows the sea state alone."""
    raise NotExpressed("clutter follows the sea state in its level; wind and waves of different ages cannot be given apart")


MEASUREMENTS: dict[str, Measurement] = {
    **{row: partial(nathanson, row) for row in NATHANSON},
    **{row: partial(detection_in_clutter, row) for row in IN_CLUTTER},
    "S01": sea_states,
    "W02": no_wave_age,
}
