"""One run of the bench as plain data: its metrics, what each scan gave, and how the tracker failed where it did."""

import secrets
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from radar_service.bench.kept_plots import bench_digest, observed_run, program_version, source_digest
from radar_service.bench.plot_errors import GLINT_SHARE, ROLL_SHARE, lengths_of
from radar_service.bench.run import answered, extracted, pfa_of, threshold_kind
from radar_service.bench.scenario import PlotErrors, Scenario, load_scenario
from radar_service.bench.scores.events import events_of
from radar_service.bench.scores.judged_scan import JudgedScan, judged, nearest_distances
from radar_service.bench.scores.plot_scores import plot_metrics
from radar_service.bench.scores.scan_result import ScanResult
from radar_service.bench.scores.scoring import at_power_centroids, metrics_of
from radar_service.bench.scores.set_scores import allowed_distance
from radar_service.bench.trackers.json_lines import WORDS, LineTracker, TrackerError, TrackerHangs
from radar_service.bench.trackers.tracker import DataSheet, Tracker, TrackState, begin_run
from radar_service.bench.trackers.trackers import program_digest, tracker_for
from radar_service.bench.video import Video, VideoError, program_on_video, video_of
from radar_service.numerics import arithmetic
from radar_service.scene_file import load_scene
from radar_service.terminal import progress

SCHEMA = 5
UNIFORM, BEAM_SPLIT = 12.0**0.5, 15.0  # of an error of one cell at most; a centroid splits a beam so far even in clutter


def single_run(
    scenario: Scenario, seed: int, tracker_name: str, plots: Path, sealed: Sequence[str] | None = None
) -> dict[str, Any]:
    """Returns one run as plain data. A tracker that fails is a failed run, and has `failure`.

    plots: the folder that keeps plots and truth; sealed: as of a Blind, None for an open run. Plots are made before the tracker
    starts, which cannot tell the scenario by their time. Raises SceneError, OSError, and ImportError without Stone Soup.
    """
    made_of = same_for_all(tracker_name) | {"digest": scenario.digest}
    run = observed_run(None if sealed == () else plots, scenario, seed)
    name = f"{scenario.name}, seed {seed}: {tracker_name}"
    scans = progress(run.results, len(run.results), "scans", lambda _: name, within=True)
    header = header_of(scenario, seed if sealed is None else None)
    try:
        if scenario.input == "video":
            with video_of(scenario, seed, plots) as video:
                tracker = tracker_for(
                    program_on_video(tracker_name, scenario.answers), {**header, "video": video.header}, sealed
                )
                results, failed = _tracked(scans, tracker, video, scenario.answers)
        else:
            results, failed = _tracked(scans, tracker_for(tracker_name, header, sealed))
    except TrackerError as error:
        return {**made_of, "scenario": scenario.name, "seed": seed, **_failed(error, None)}
    of_plots, centred = scenario.answers == "plots", judged(at_power_centroids(results))
    metrics = {} if failed else plot_metrics(results) if of_plots else metrics_of(results, run.around, centred)
    return {
        **made_of, "scenario": scenario.name, "seed": seed,
        **(failed or {"failure": None, "metrics": metrics}),
        "remark": run.remark, "events": [] if of_plots else [asdict(event) for event in events_of(centred)],
        "scans": [_scan_data(scan) for scan in centred.scans],
    }  # fmt: skip


def header_of(scenario: Scenario, seed: int | None) -> dict[str, Any]:
    """Returns what a tracker gets before the first scan. seed: None for a blind run. Raises SceneError."""
    open_keys = {} if seed is None else {"scenario": scenario.name, "seed": seed}
    return {"schema": SCHEMA, "run": secrets.token_hex(8), **open_keys, "radar": asdict(data_sheet(scenario))}


def data_sheet(scenario: Scenario) -> DataSheet:
    """Returns what a tracker is told of the radar of a scenario. Raises SceneError."""
    scene = load_scene(scenario.scene, folder=scenario.folder).for_radar(scenario.radar)
    radar, errors = scene.radar, scenario.plot_errors or PlotErrors()
    kind = threshold_kind(scenario.plots, scene)
    cells = radar.azimuths * (radar.range_max - scenario.plots.nearest_m) / radar.range_step
    gyro = scene.errors.gyro.noise if scene.errors and scene.errors.gyro else 0.0
    bearings = [np.radians(errors.bearing_sd_deg), ROLL_SHARE * np.radians(errors.roll_deg) ** 2, gyro]
    lengths = [*lengths_of(scenario).values(), *(body.length for body in scene.bodies if body.name in scenario.tracked)]
    return DataSheet(
        rpm=60.0 / radar.rotation_period, beamwidth=radar.beamwidth, cell=radar.range_step, range_max=radar.range_max,
        range_error=float(np.hypot(errors.range_sd_m, np.hypot(errors.range_step_m, radar.range_step) / UNIFORM)),
        bearing_error=float(np.linalg.norm([*bearings, radar.beamwidth / BEAM_SPLIT])),
        glint=max(lengths, default=0.0) * GLINT_SHARE, false_plots=errors.others + cells * pfa_of(scenario.plots, kind),
        sensors=scenario.scene.get("errors", {}).get("profile", "none"),
    )  # fmt: skip


def scored_run(
    scenario: Scenario, seed: int, tracker_name: str, plots: Path, sealed: Sequence[str] | None = None
) -> dict[str, Any]:
    """Returns a run as single_run does, without its scans and events: what ranks trackers is small, and has no picture."""
    return {**single_run(scenario, seed, tracker_name, plots, sealed), "events": [], "scans": []}


def missed_limits(scenario: str, seed: int, tracker: Tracker, plots: Path = Path("bench-plots")) -> dict[str, float | None]:
    """Returns the limits that a tracker in this process misses, by metric, with its values: a test asserts that there is none.

    scenario: the name of a packaged one, or a scenario or scene file; tracker: a new one; plots: the folder that keeps plots
    and truth. Raises ScenarioError, SceneError, OSError, TrackerError, and what the tracker raises.
    """
    loaded = load_scenario(scenario)
    run = observed_run(plots, loaded, seed)
    begin_run(tracker, data_sheet(loaded))
    return loaded.missed(metrics_of(list(answered(run.results, tracker)), run.around))


def same_for_all(tracker: str) -> dict[str, Any]:
    """Returns what all runs of a tracker are made of."""
    return {
        "schema": SCHEMA, "tracker": tracker, "program": program_digest(tracker), "arithmetic": arithmetic(),
        "version": program_version(), "source": source_digest(), "bench": bench_digest(),
    }  # fmt: skip


def _tracked(
    observed: Iterable[ScanResult], tracker: Tracker, video: Video | None = None, answers: str = "tracks"
) -> tuple[list[ScanResult], dict[str, Any] | None]:  # fmt: skip
    """The scans that a tracker answered, and how it, or its video, failed; None where it did not."""
    results: list[ScanResult] = []
    line_tracker = tracker if isinstance(tracker, LineTracker) else None
    try:
        if line_tracker and answers == "plots":
            results.extend(extracted(observed, line_tracker))
        else:
            results.extend(answered(observed, tracker, video is not None))
        if video and (fault := video.fault()):
            raise VideoError(f"video: {fault}")
    except BaseException as error:
        if line_tracker:
            line_tracker.close()
        if not isinstance(error, TrackerError):
            raise
        if video and not isinstance(error, VideoError) and (fault := video.fault()):
            error = type(error)(f"video: {fault}; then {error}")
        status = line_tracker.status if line_tracker and line_tracker.end in str(error) else None  # others were ended here
        last = (status, line_tracker.last_line) if line_tracker else ()
        return results, _failed(error, len(results), *last)
    if line_tracker:
        line_tracker.finish()
    return results, None


def _failed(error: TrackerError, scan: int | None, status: int | None = None, last_line: str = "") -> dict[str, Any]:
    """What a failed run has in place of metrics. scan: that it failed at, None where it did not start."""
    failure = {
        "scan": scan, "message": str(error), "status": status, "stderr": last_line, "hangs": isinstance(error, TrackerHangs)
    }  # fmt: skip
    return {"failure": failure, "metrics": {}, "remark": None, "events": [], "scans": []}


def _scan_data(scan: JudgedScan) -> dict[str, Any]:
    """What a report draws of a scan: positions as own ship reports them; targets and tracks at its end, as they are judged."""
    result, nearest = scan.result, nearest_distances(scan)
    return {
        "scan": result.given.scan, "time": result.given.time, "own": [result.given.east, result.given.north],
        "plots": [[plot.east, plot.north] for plot in result.given.plots],
        "tracks": [{**_track_data(track), "stale": track.track not in scan.tracks} for track in result.tracks],
        "targets": [
            {
                "body": body, "position": truth.position, "track": scan.pairs.get(body), "nearest": nearest.get(body),
                "allowed": allowed_distance(truth.length),
            }
            for body, truth in scan.truths.items()
        ],
    }  # fmt: skip


def _track_data(track: TrackState) -> dict[str, Any]:
    """A track, without what it does not say of AIS and of its acquisition."""
    return {key: value for key, value in asdict(track).items() if value is not None or key not in ("mmsi", *WORDS)}
