"""Detection of points in sea and rain: by an ideal threshold, the quantile of the clutter, and by the extractor in force.

Each target of a scenario stands at each range upwind, across and downwind, on a spoke and in the middle of a range cell. The same
scene without targets, with draws of its own, gives the clutter's quantiles and the false plots.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.stats import beta, chi2

from radar_service.batch.jobs import Executor, Job, Progress, run
from radar_service.bench.detection.detection import Target, ground_distance, spoke_gains
from radar_service.bench.run import extractor_of
from radar_service.bench.scenario import Scenario, ScenarioError
from radar_service.numerics import NAUTICAL_MILE, Flags, Floats, Indices, wrap_angle
from radar_service.plots import Plot
from radar_service.radar import radar_sets
from radar_service.receive import receiver_noise_power
from radar_service.scene_file import load_scene
from radar_service.simulator import Simulator
from radar_service.world import Scene

SCHEMA = 1
BANDS = {"x": 9.41e9, "s": 3.05e9}  # Hz
DIRECTIONS = {"upwind": 0.0, "across": 90.0, "downwind": 180.0}  # from the wind's origin [degrees]
SECTOR = np.radians(20.0)  # to each side of a direction: its clutter counts there, and its targets stand there
CELLS = 5  # to each side of a target's, whose clutter counts, each over its own mean
CONFIDENCE = 0.95
FEWEST = 5  # false alarms from which a rate is known well enough for a quantile
SCANS_PER_JOB = 50
BEYOND = 1.5  # times the farthest range: where a scan of a study ends at most


@dataclass(frozen=True)
class ClutterCase:
    """One sea, and how detections count.

    sea_state, rain_mm_h: as of an environment. pfa: of a cell, for the quantile and for the extractor. needed, of: scans of N
    in which a target must be detected. swerling, band, polarization: None as in the scenario. ranges: [m].
    """

    sea_state: float
    rain_mm_h: float
    ranges: tuple[float, ...]
    pfa: float = 1e-4
    needed: int = 1
    of: int = 1
    swerling: int | None = None
    band: str | None = None
    polarization: str | None = None

    def __post_init__(self) -> None:
        if not 0.0 < self.pfa < 0.1:
            raise ValueError(f"pfa: {self.pfa:g} is not allowed; above 0 and below 0.1, as 1e-4")
        if not 1 <= self.needed <= self.of:
            raise ValueError(f"looks: {self.needed} of {self.of} is not allowed; 1 or more of as many or more, as 8/10")


class TargetPowers(NamedTuple):
    """What S scans gave of a target, at R ranges in D directions. power: (S, R, D, K) of its cell on the spokes of the beam [W];
    plotted: (S, R, D) whether a plot is at it."""

    power: Floats
    plotted: Flags


class Background(NamedTuple):
    """What S scans gave without targets. power: (S, R, D, n) about the places of a target [W]; alarms: (S, R, D) cells of these
    that exceed the extractor's threshold; plots: (S, R, D) false ones in the part of a scan that the place stands for."""

    power: Floats
    alarms: Indices
    plots: Indices


def clutter_study(
    scenario: Scenario, cases: Sequence[ClutterCase], scans: int, executor: Executor | None = None,
    progress: Progress = lambda parts, count: parts, seed: int = 0,
) -> dict[str, Any]:  # fmt: skip
    """Returns the study of a scenario in some cases as plain data. Arguments and errors as of `detection_study`."""
    for case in cases:
        clutter_scene(scenario, case, None)  # refused now
    shares = [min(SCANS_PER_JOB, scans - k) for k in range(0, scans, SCANS_PER_JOB)]
    named = {"no target": None, **{target.name: target for target in clutter_targets(scenario)}}
    jobs = [
        Job(f"{scenario.name}, case {n}, {name}, seed {seed + k}", (scenario, case, target, seed + k, share))
        for n, case in enumerate(cases) for name, target in named.items() for k, share in enumerate(shares)
    ]  # fmt: skip
    parts = iter(run(sampled, jobs, executor, progress=progress))
    series = []
    for case in cases:
        scanned = [[next(parts) for _ in shares] for _ in named]
        background, *hits = [type(some[0])(*map(np.concatenate, zip(*some, strict=True))) for some in scanned]
        series.append(_series(scenario, case, background, dict(zip([*named][1:], hits, strict=True))))
    about = {"scenario": scenario.name, "question": scenario.question, "source": scenario.source, "scans": scans}
    return {"schema": SCHEMA, **about, "confidence": CONFIDENCE, "series": series}


def clutter_targets(scenario: Scenario) -> list[Target]:
    """Returns the points of a scenario. Raises ScenarioError where there is none."""
    targets = [
        Target.of(scenario, body)
        for body in scenario.scene.get("body", ())
        if body["name"] in scenario.tracked and body.get("shape") == "point" and "rcs_dbsm" in body
    ]
    if not targets:
        raise ScenarioError(f"{scenario.name}: no target is a point with rcs_dbsm; give one")
    return targets


def clutter_scene(scenario: Scenario, case: ClutterCase, target: Target | None) -> Scene:
    """Returns the scene of a case, with a target at each range in each direction. Raises SceneError and ScenarioError."""
    air = {**scenario.scene.get("environment", {}), "sea_state": case.sea_state, "rain_mm_h": case.rain_mm_h}
    air.pop("wave_height_m", None)
    if not isinstance(scenario.scene.get("radar", {}), Mapping):
        raise ScenarioError(f"{scenario.name}: radar: detection in clutter is of one radar; leave one")
    radar = dict(scenario.scene.get("radar", {}))
    radar |= {"frequency_hz": BANDS[case.band]} if case.band else {}
    radar |= {"polarization": case.polarization} if case.polarization else {}
    if not radar.get("pulses"):  # farther cells cost time; a set has the scale that its range control takes
        known = radar_sets().get(str(radar.get("set")))
        farthest = min(float(radar.get("range_max_m", np.inf if known else 3000.0)), BEYOND * max(case.ranges))
        radar["range_max_m"] = next((scale for scale in known.scales if scale >= farthest), farthest) if known else farthest
    content = {**scenario.scene, "name": scenario.name, "own_ship": {}, "environment": air, "radar": radar, "body": []}
    scene = load_scene(content)
    step = scene.radar.range_step
    if not CELLS < min(case.ranges) / step <= max(case.ranges) / step < scene.radar.bins - CELLS - 1:
        raise ScenarioError(
            f"{scenario.name}: ranges: {', '.join(f'{r / NAUTICAL_MILE:.3g}' for r in case.ranges)} NM are not all between the "
            f"{CELLS + 1}th cell and range_max_m; give others"
        )
    if target is None:
        return scene
    cells, spokes = places(scene, case)
    swerling = target.swerling if case.swerling is None else case.swerling
    bodies = []
    for (r, d), spoke in np.ndenumerate(spokes):
        slant, angle = np.array([(cells[r] + 0.5) * step]), float(spoke * scene.radar.azimuth_step)
        ground = float(ground_distance(slant, target.height, scene.radar, scene.environment)[0])
        place = [ground * float(np.sin(angle)), ground * float(np.cos(angle)), target.height]
        bodies.append({
            "name": f"{r} {d}", "shape": "point", "rcs_dbsm": target.rcs_dbsm, "swerling": swerling, "position_m": place,
        })  # fmt: skip
    return load_scene({**content, "body": bodies})


def places(scene: Scene, case: ClutterCase) -> tuple[Indices, Indices]:
    """Returns the cells (R,) and the spokes (R, D) of a target: those of one direction lie apart in its sector."""
    radar, count = scene.radar, len(case.ranges)
    beside = SECTOR * (2.0 * (np.arange(count) + 0.5) / count - 1.0)
    angle = scene.environment.wind_from + np.radians([*DIRECTIONS.values()]) + beside[:, None]
    return (np.array(case.ranges) / radar.range_step).astype(np.int64), np.rint(angle / radar.azimuth_step).astype(
        np.int64
    ) % radar.azimuths


def sampled(
    scenario: Scenario, case: ClutterCase, target: Target | None, seed: int, scans: int
) -> TargetPowers | Background:
    """Returns what some scans of a case give, after one that begins the plots. Raises as `clutter_scene`."""
    scene = clutter_scene(scenario, case, target)
    simulator = Simulator(scene, scenario.fidelity, 2 * seed + (target is None))
    settings = scenario.plots.model_copy(update={"pfa": case.pfa, "max_plots": 10_000})
    extractor, (cells, spokes) = extractor_of(settings, scene, lambda flood: None), places(scene, case)
    half = len(spoke_gains(scene.radar)) // 2
    beam = (spokes[..., None] + np.arange(-half, half + 1)) % scene.radar.azimuths
    extractor.add(simulator.scan())
    rows: list[tuple[NDArray[Any], ...]] = []
    for _ in range(scans):
        scan = simulator.scan()
        plots = extractor.add(scan).plots
        if target is None:
            alarms = _about(scene, case, scan.power > extractor.threshold.of(scan.power)).sum(axis=2)
            rows.append((_about(scene, case, scan.power), alarms, _counted(plots, scene, case)))
        else:
            rows.append((scan.power[beam, cells[:, None, None]], _plotted(plots, scene, cells, spokes)))
    power, *others = map(np.stack, zip(*rows, strict=True))
    return (TargetPowers if target else Background)(power.astype(np.float64), *others)


def _about(scene: Scene, case: ClutterCase, values: NDArray[Any]) -> NDArray[Any]:
    """Values (A, N) about each range in each direction: (R, D, n)."""
    sectors = [_sector(scene, degrees) for degrees in DIRECTIONS.values()]
    columns = [int(distance / scene.radar.range_step) + np.arange(-CELLS, CELLS + 1) for distance in case.ranges]
    return np.array([[values[np.ix_(sector, column)].ravel() for sector in sectors] for column in columns])


def _sector(scene: Scene, degrees: float) -> Indices:
    """The spokes of a direction, as many in each."""
    radar = scene.radar
    half = int(SECTOR / radar.azimuth_step)
    middle = round((scene.environment.wind_from + np.radians(degrees)) / radar.azimuth_step)
    return np.asarray((middle + np.arange(-half, half + 1)) % radar.azimuths)


def _plotted(plots: Sequence[Plot], scene: Scene, cells: Indices, spokes: Indices) -> Flags:
    """Whether a plot lies within a half-power beam and two cells of each place (R, D)."""
    radar = scene.radar
    distance, bearing = np.array([(plot.range, plot.bearing) for plot in plots]).reshape(-1, 2).T
    away = np.abs(distance - (cells[:, None, None] + 0.5) * radar.range_step)
    turned = np.abs(wrap_angle(bearing - spokes[..., None] * radar.azimuth_step))
    return np.asarray(((away <= 2.0 * radar.range_step) & (turned <= radar.beamwidth / 2.0)).any(axis=2))


def _counted(plots: Sequence[Plot], scene: Scene, case: ClutterCase) -> Indices:
    """Plots (R, D) by the nearest range, by logarithm, and within SECTOR of a direction."""
    result = np.zeros((len(case.ranges), len(DIRECTIONS)), dtype=np.int64)
    for plot in plots:
        r = int(np.abs(np.log(np.array(case.ranges) / max(plot.range, 1.0))).argmin())
        for d, degrees in enumerate(DIRECTIONS.values()):
            result[r, d] += bool(
                np.abs(wrap_angle(plot.bearing - scene.environment.wind_from - np.radians(degrees))) <= SECTOR
            )
    return result


def _series(
    scenario: Scenario, case: ClutterCase, background: Background, hits: Mapping[str, TargetPowers]
) -> dict[str, Any]:
    noise = receiver_noise_power(clutter_scene(scenario, case, None).radar)
    rows = [
        _row(case, background, target, measured, (r, d), noise)
        for target, measured in hits.items() for r in range(len(case.ranges)) for d in range(len(DIRECTIONS))
    ]  # fmt: skip
    names = ("sea_state", "rain_mm_h", "pfa", "needed", "of", "swerling", "band", "polarization")
    return {**{name: getattr(case, name) for name in names}, "rows": rows}


def _row(
    case: ClutterCase, background: Background, target: str, hits: TargetPowers, place: tuple[int, int], noise: float
) -> dict[str, Any]:
    """A target at a place: index of its range and of its direction."""
    r, d = place
    clutter, alarms = background.power[:, r, d], background.alarms[:, r, d].sum()
    by_cell = clutter.reshape(-1, 2 * CELLS + 1)
    own = by_cell.mean(axis=0)  # the mean falls with range
    level, rate = float(own[CELLS]), float(alarms / clutter.size)
    quantile, same = (float(np.quantile(by_cell / own, 1.0 - pfa)) * level for pfa in (case.pfa, rate))
    peak = hits.power[:, r, d].max(axis=1)
    return {
        "target": target, "range_nm": case.ranges[r] / NAUTICAL_MILE, "direction": [*DIRECTIONS][d],
        "clutter_to_noise_db": float(10.0 * np.log10(max(level / noise - 1.0, 1e-3))),
        "threshold_over_mean_db": float(10.0 * np.log10(quantile / level)),
        "quantile": _share(peak > quantile, case), "extractor": _share(hits.plotted[:, r, d], case), "extractor_pfa": rate,
        "quantile_at_extractor_pfa": _share(peak > same, case) if alarms >= FEWEST else None,
        "false_plots": _rate(int(background.plots[:, r, d].sum()), len(clutter)),
    }  # fmt: skip


def _share(hits: Flags, case: ClutterCase) -> dict[str, float]:
    """Pd, with its exact interval: hits (S,) scan by scan, of which `needed` in `of` count. Windows overlap, those that count in
    the interval do not."""
    windows = sliding_window_view(hits, case.of).sum(axis=1) >= case.needed
    return binomial_interval(float(windows.mean()), len(hits) // case.of)


def binomial_interval(share: float, count: int) -> dict[str, float]:
    """Returns a share with its interval of CONFIDENCE in `count` trials (Clopper and Pearson 1934)."""
    k, tail = share * count, (1.0 - CONFIDENCE) / 2.0
    low = float(beta.ppf(tail, k, count - k + 1.0)) if k > 0.0 else 0.0
    high = float(beta.ppf(1.0 - tail, k + 1.0, count - k)) if k < count else 1.0
    return {"value": share, "low": low, "high": high}


def _rate(count: int, scans: int) -> dict[str, float]:
    """Plots a scan with their interval of CONFIDENCE (Garwood 1936)."""
    tail = (1.0 - CONFIDENCE) / 2.0
    low = float(chi2.ppf(tail, 2 * count)) / 2.0 if count else 0.0
    return {"value": count / scans, "low": low / scans, "high": float(chi2.ppf(1.0 - tail, 2 * count + 2)) / 2.0 / scans}


def clutter_summary(study: Mapping[str, Any]) -> str:
    """Returns the tables of a study as text."""
    lines = []
    for series in study["series"]:
        looks = f"{series['needed']} of {series['of']} scans"
        lines += [
            f"sea state {series['sea_state']:g}, rain {series['rain_mm_h']:g} mm/h, Pfa {series['pfa']:g}, {looks}",
            f"{'target':28}{'NM':>6} {'direction':9}{'C/N':>6}{'thr':>6}{'Pd by quantile':>20}{'Pd by extractor':>20}"
            f"{'false plots a scan':>22}",
        ]
        for row in series["rows"]:
            parts = [_interval(row[name]) for name in ("quantile", "extractor", "false_plots")]
            lines.append(
                f"{row['target'][:27]:28}{row['range_nm']:6.2f} {row['direction']:9}{row['clutter_to_noise_db']:6.1f}"
                f"{row['threshold_over_mean_db']:6.1f}{parts[0]:>20}{parts[1]:>20}{parts[2]:>22}"
            )
    return "\n".join([*lines, "C/N: clutter to noise, thr: threshold of the quantile over the mean, both in dB"]) + "\n"


def _interval(part: Mapping[str, float]) -> str:
    return f"{part['value']:.2f} ({part['low']:.2f} to {part['high']:.2f})"
