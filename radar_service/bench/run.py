"""One run of the test bench: the plots and the truth of a scenario and a seed, and what a tracker makes of them."""

from collections.abc import Callable, Iterable, Iterator, Sequence, Set
from dataclasses import replace
from time import perf_counter

import numpy as np

from radar_service.bench.few_tiles import TOGETHER, FewTiles, has_few
from radar_service.bench.plot_errors import lengths_of, with_errors
from radar_service.bench.recorded import recorded_scans
from radar_service.bench.scenario import PlotSettings, Scenario
from radar_service.bench.scores.acquisition import with_orders
from radar_service.bench.scores.scan_result import ScanResult, Surroundings, TargetTruth
from radar_service.bench.trackers.json_lines import LineTracker, TrackerError
from radar_service.bench.trackers.tracker import Tracker, TrackerInput, TrackState
from radar_service.engine.preparation import Prepared
from radar_service.numerics import BLAS_LIMIT, Floats
from radar_service.plots import PFA as MARINE_PFA
from radar_service.plots import ClusterRule, Plot, PlotExtractor, ScanPlots, Threshold, in_clutter, threshold
from radar_service.records import Crossing, Kinematics, OwnShipTruth, Readings
from radar_service.scans import Scan
from radar_service.scene_file import load_scene
from radar_service.simulator import Simulator
from radar_service.trace import LandMask
from radar_service.world import Scene, pose_at

PFA, DEFAULT_PFA = 1e-7, {"marine": MARINE_PFA}  # where a scenario sets none
LAND_STEP = 50.0  # m between places of land, within which tracks may be false
ROUNDING = 1e-6  # s: no state is from the future by less


def answered(results: Iterable[ScanResult], tracker: Tracker, on_video: bool = False) -> Iterator[ScanResult]:
    """Yields scans with what a tracker answers to each. on_video: it gets no plots, and the time of its answers, in which the
    video is made, does not count. Raises TrackerError, and what the tracker raises."""
    reported, tracks = set[int](), tuple[TrackState, ...]()
    for ordered in results:
        result = replace(ordered, given=with_orders(ordered, ordered.orders, tracks)) if ordered.orders else ordered
        reported.update(report.mmsi for report in result.given.ais or ())
        began = perf_counter()
        tracks = tuple(tracker.update(replace(result.given, plots=()) if on_video else result.given))
        seconds = 0.0 if on_video else perf_counter() - began
        check_times(tracks, result.given)
        check_associations(tracks, result.given.scan, reported)
        memory = tracker.memory if isinstance(tracker, LineTracker) else None
        yield replace(result, tracks=tracks, seconds=seconds, memory=memory)


def extracted(results: Iterable[ScanResult], extractor: LineTracker) -> Iterator[ScanResult]:
    """Yields scans with the plots that an extractor answers to the video of each. Raises TrackerError."""
    for result in results:
        plots = extractor.plots(replace(result.given, plots=()))
        check_times(plots, result.given)
        yield replace(result, given=replace(result.given, plots=plots))


def check_times(records: Sequence[TrackState | Plot], given: TrackerInput) -> None:
    """Raises TrackerError for a state or a plot from the future."""
    for record in records:
        if record.time > given.time + ROUNDING:
            name = f"track {record.track!r}" if isinstance(record, TrackState) else "a plot"
            raise TrackerError(
                f"tracker: the answer to scan {given.scan} has {name} at {record.time:.6g} s, after the end of the scan at "
                f"{given.time:.6g} s; give the time at which the beam met it, or of a state the end of the scan"
            )


def check_associations(tracks: Sequence[TrackState], scan: int, reported: Set[int]) -> None:
    """Raises TrackerError for an MMSI that is not `reported` so far, or on two tracks."""
    owner: dict[int, str] = {}
    for track in tracks:
        if track.mmsi is None or track.lost:
            continue
        begin = f"tracker: the answer to scan {scan} has MMSI {track.mmsi} on track {track.track!r}"
        if track.mmsi not in reported:
            raise TrackerError(f"{begin}, which no AIS report has had so far; give one that was received, or none")
        if track.mmsi in owner:
            raise TrackerError(f"{begin} and on track {owner[track.mmsi]!r}; an AIS target is one ship")
        owner[track.mmsi] = track.track


def surroundings(scenario: Scenario) -> Surroundings:
    """Returns of what tracks of a scenario may be false. Raises SceneError."""
    scene = load_scene(scenario.scene, folder=scenario.folder)
    still = [body for body in scene.bodies if body.name not in scenario.tracked and body.at_rest]
    places = [pose_at(body, 0.0).position[None, :2] for body in still]
    if mask := LandMask.of(still):
        rows, columns = np.nonzero(mask.material)
        places.append(mask.corner + mask.cell * np.stack([columns, rows], axis=1))
    coarse = np.unique(np.round(np.concatenate([np.empty((0, 2)), *places]) / LAND_STEP), axis=0) * LAND_STEP
    environment = scene.environment
    clutter = "rain" if environment.rain_mm_h or environment.attenuators else "sea" if environment.sea_state else "noise"
    return Surroundings(tuple((float(east), float(north)) for east, north in coarse), clutter)


def simulator_of(scenario: Scenario, seed: int) -> Simulator:
    """Returns the simulator of a scenario and a seed, before its first scan. Raises SceneError."""
    scene = load_scene(scenario.scene_for(seed), folder=scenario.folder).for_radar(scenario.radar)
    return Simulator(scene, scenario.fidelity, seed)


def observed(
    scenario: Scenario,
    seed: int,
    tell: Callable[[str], None] | None = None,
    shared: tuple[Simulator, Prepared] | None = None,
) -> Iterator[ScanResult]:
    """Yields the plots and the truth of each scan, without tracks. tell: as of a PlotExtractor; shared: with other seeds. Raises
    SceneError, and ScenarioError for a recording that is not whole."""
    if scenario.recorded:
        yield from recorded_scans(scenario)
        return
    simulator, prepared = shared or (simulator_of(scenario, seed), None)
    scene = simulator.scene
    extractor = extractor_of(scenario.plots, scene, tell)
    few = FewTiles(simulator, extractor.threshold, prepared) if has_few(simulator, extractor.threshold) else None
    lengths, together = lengths_of(scenario), TOGETHER if few else 1
    for first in range(0, scenario.scans, together):
        numbers = range(first, min(first + together, scenario.scans))
        all_tiles = ((extractor.add(scan), scan.time, scan) for scan in (simulator.scan() for _ in numbers))
        ended: Iterable[tuple[ScanPlots, Floats, Readings | Scan]] = few.plots(numbers, extractor) if few else all_tiles
        for (plots, time, own), truths in zip(ended, truths_of(simulator, numbers, scenario.tracked), strict=True):
            heading = float(own.heading[-1])
            erring = with_errors(plots.plots, truths, scenario.plot_errors, heading, seed, plots.scan, lengths)
            yield ScanResult(
                tracker_input(plots.scan, time, own, erring, scene.radar.rotation_period), (), truths, plots.flood
            )


def extractor_of(settings: PlotSettings, scene: Scene, tell: Callable[[str], None] | None = None) -> PlotExtractor:
    """Returns a new extractor of a scene's radar, as a scenario asks for it. tell: as of a PlotExtractor."""
    return PlotExtractor(
        scene.radar, threshold_of(settings, scene), rule=rule_of(settings), max_plots=settings.max_plots,
        nearest=settings.nearest_m, tell=tell, land=LandMask.of(scene.bodies),
    )  # fmt: skip


def threshold_of(settings: PlotSettings, scene: Scene) -> Threshold:
    """Returns the threshold that a scenario asks for in a scene."""
    kind = threshold_kind(settings, scene)
    return threshold(kind, scene.radar, pfa_of(settings, kind), settings.guard_m, settings.window_m)


def threshold_kind(settings: PlotSettings, scene: Scene) -> str:
    """Returns the kind of threshold: what "auto" stands for in a scene."""
    return settings.threshold if settings.threshold != "auto" else "marine" if in_clutter(scene) else "known"


def pfa_of(settings: PlotSettings, kind: str) -> float:
    """Returns the false alarm probability of a cell, for a kind of threshold."""
    return settings.pfa or DEFAULT_PFA.get(kind, PFA)


def rule_of(settings: PlotSettings) -> ClusterRule:
    """Returns the rule of clusters that a scenario asks for."""
    return ClusterRule(settings.gap_spokes, settings.gap_cells, settings.split_db)


def tracker_input(
    number: int, time: Floats, own: Readings | Scan, plots: Sequence[Plot], rotation_period: float
) -> TrackerInput:
    """Returns what a tracker gets of a scan of that number. time, own: of its last spokes (K,), moved on to its end."""
    end, course, speed = (number + 1) * rotation_period, float(own.course[-1]), float(own.speed[-1])
    way = (end - float(time[-1])) * speed * np.array([np.sin(course), np.cos(course)])
    east, north = (own.position[-1] + way).tolist()
    return TrackerInput(
        scan=number, time=end, east=east, north=north, heading=float(own.heading[-1]), course=course, speed=speed,
        plots=tuple(plots),
    )  # fmt: skip


@BLAS_LIMIT.held()
def truths_of(simulator: Simulator, scans: range, targets: Sequence[str]) -> list[tuple[TargetTruth, ...]]:
    """Returns each target at its last crossing in some scans, or at the end of a scan where it has none.

    Where a target is no point, its power is measured, as far as the simulation can.
    """
    bodies = [body for body in simulator.scene.bodies if body.name in targets]
    measured = any(body.length for body in bodies) and simulator.fidelity.name != "documented"
    crossings = simulator.crossings(scans.start, radiometric=measured, count=len(scans))
    latest = {(crossing.scan, crossing.body): _crossed(crossing) for crossing in crossings}
    for scan in scans:
        if any((scan, body.name) not in latest for body in bodies):
            snapshot = simulator.snapshot(scan)
            latest = {(scan, body.body): _truth(body, snapshot.own_ship) for body in snapshot.bodies} | latest
    return [tuple(latest[scan, body.name] for body in bodies) for scan in scans]


def _crossed(crossing: Crossing) -> TargetTruth:
    """A target at its crossing, with where its power lies: of a point at the point itself."""
    truth = _truth(crossing, crossing.own_ship)
    if not crossing.length or crossing.centroid_range is None or crossing.centroid_bearing is None:
        return replace(truth, echo=(crossing.range, crossing.boresight))
    along, across = crossing.centroid_along or 0.0, crossing.centroid_across or 0.0
    return replace(truth, echo=(crossing.centroid_range, crossing.centroid_bearing), centroid=(along, across))


def _truth(body: Kinematics, own: OwnShipTruth) -> TargetTruth:
    reported = own.reported
    east, north = (0.0, 0.0) if reported is None else np.subtract(reported.position, own.position)[:2].tolist()
    return TargetTruth(
        body=body.body, time=body.time, position=body.position[:2], velocity=body.velocity[:2], own_position=own.position[:2],
        own_velocity=own.velocity[:2], visible=body.visible, heading=body.heading, length=body.length,
        own_error=(east, north), azimuth_error=reported.azimuth_error if reported else 0.0,
    )  # fmt: skip
