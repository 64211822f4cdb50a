"""Runs of a small scenario: what the tracker gets, what is true, and a bias that is seen with its size."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from radar_service.bench.run import answered, check_times, observed, rule_of, surroundings, threshold_of, tracker_input
from radar_service.bench.scenario import PlotSettings, Scenario
from radar_service.bench.scores.scan_result import ScanResult, as_reported
from radar_service.bench.trackers.json_lines import TrackerError
from radar_service.bench.trackers.tracker import AisTarget, TrackerInput, TrackState
from radar_service.plots.marine import MarineThreshold
from radar_service.plots.thresholds import CellAveraging, KnownThreshold, OrderedStatistic
from tests.bench.scores.test_scoring import given, track, truth
from tests.bench.test_scenario import SMALL
from tests.plots.test_detections import scan_of_power
from tests.scenes import scene


class Noted:
    """A tracker that keeps what it gets, and gives one track at the first plot."""

    def __init__(self) -> None:
        self.given: list[TrackerInput] = []

    def update(self, scan: TrackerInput) -> Sequence[TrackState]:
        self.given.append(scan)
        return [
            TrackState(track="1", time=p.time, east=p.east, north=p.north, velocity_east=0, velocity_north=0)
            for p in scan.plots[:1]
        ]


def results(**changes: object) -> list[ScanResult]:
    return list(answered(observed(Scenario(**{**SMALL, **changes}), 1), Noted()))


def test_each_scan_gives_the_plot_and_the_truth_of_the_target() -> None:
    made = results()
    assert [one.given.scan for one in made] == list(range(8)) and [one.given.time for one in made] == pytest.approx(
        2.5 * np.arange(1, 9)
    )
    for one in made:
        (plot,), (truth,) = one.given.plots, one.truths
        assert np.hypot(plot.east - truth.position[0], plot.north - truth.position[1]) < 1.0
        assert abs(plot.time - truth.time) < 0.01 and truth.visible and truth.body == "t"
        assert one.tracks[0].east == plot.east


def test_the_same_seed_gives_the_same_run() -> None:
    assert results() == results()


def biases(**errors: dict[str, float]) -> tuple[float, float]:
    """Mean error of range [m] and bearing [degrees] of the plots against the truth."""
    scene = {**SMALL["scene"], "errors": errors} if errors else SMALL["scene"]
    made = results(scene=scene)
    offsets = []
    for one in made:
        plot, truth = one.given.plots[0], one.truths[0]
        bearing = np.degrees(np.arctan2(truth.position[0], truth.position[1]))
        offsets.append((plot.range - np.hypot(*truth.position), np.degrees(plot.bearing) - bearing))
    return tuple(np.mean(offsets, axis=0))


@pytest.mark.parametrize(
    ("table", "degrees"), [({"gyro": {"bias_deg": 0.1}}, 0.1), ({"antenna": {"misalignment_deg": 0.7}}, 0.7)]
)
def test_a_bearing_error_on_purpose_is_seen_with_its_size(table: dict[str, dict[str, float]], degrees: float) -> None:
    """Within 10 %; gyro and misalignment look alike while own ship is at rest."""
    plain, biased = biases(), biases(**table)
    assert biased[1] - plain[1] == pytest.approx(degrees, rel=0.1) and abs(biased[0] - plain[0]) < 0.01


def test_plots_are_compared_with_the_azimuths_of_an_antenna_that_rolls() -> None:
    """The level bearing is over a degree off. Tolerance: a tenth of the beam of 4 degrees."""
    own_ship = {"roll_deg": 20, "roll_period_s": 9, "pitch_deg": 5, "pitch_period_s": 7}
    strong = SMALL["scene"]["body"][0] | {"rcs_dbsm": 5}
    made = results(scene=SMALL["scene"] | {"own_ship": own_ship, "body": [strong]})
    for one in made:
        (plot,), (truth,) = one.given.plots, one.truths
        assert truth.echo is not None and plot.bearing == pytest.approx(truth.echo[1], abs=np.radians(0.4))
    level = [np.arctan2(*one.truths[0].position) for one in made]
    assert max(abs(one.given.plots[0].bearing - bearing) for one, bearing in zip(made, level, strict=True)) > np.radians(1.0)


def test_own_ship_is_moved_on_to_the_end_of_the_scan() -> None:
    scan = scan_of_power(np.zeros((4, 5)), number=2)
    scan = replace(scan, speed=np.full(4, 3.0), course=np.full(4, np.pi / 2))
    made = tracker_input(scan.number, scan.time, scan, (), 4.0)
    assert made.time == 12.0 and made.east == pytest.approx(30.0 + 3.0 * (12.0 - 8.0)) and made.north == pytest.approx(20.0)


def test_plots_are_extracted_as_the_scenario_says() -> None:
    calm, rough = (scene(radar={"pulse_s": 1e-6}, environment=sea) for sea in ({}, {"sea_state": 2}))
    kinds = {name: type(threshold_of(PlotSettings(threshold=name), calm)) for name in ("auto", "ca", "os", "marine")}
    assert kinds == {"auto": KnownThreshold, "ca": CellAveraging, "os": OrderedStatistic, "marine": MarineThreshold}
    auto = [threshold_of(PlotSettings(), each) for each in (calm, rough)]
    assert auto == [KnownThreshold(calm.radar, 1e-7), MarineThreshold(rough.radar)]
    rule = rule_of(PlotSettings(split_db=20.0, gap_cells=5))
    assert (rule.split_db, rule.spokes, rule.cells) == (20.0, 2, 5)


HULL = {"name": "t", "shape": "hull", "length_m": 60, "beam_m": 12, "height_m": 8, "position_m": [800, 300, 0], "rcs_dbsm": 20,
        "course_deg": 90, "speed_kn": 20}  # fmt: skip


def test_a_hull_comes_with_where_her_power_lies() -> None:
    """Range and bearing of the centroid, and the same in the hull's frame; a point has neither, but is its own echo."""
    (hull,) = results(scene={**SMALL["scene"], "body": [HULL]}, scans=2, vary_m=0.0)[1].truths
    (point,) = results(scans=2, vary_m=0.0)[1].truths
    assert (
        hull.length == 60.0
        and hull.heading == pytest.approx(np.pi / 2)
        and hull.centroid is not None
        and hull.echo is not None
    )
    along, across = hull.centroid
    east, north = hull.position[0] + along, hull.position[1] - across
    assert hull.echo[1] == pytest.approx(np.arctan2(east, north), abs=1e-3) and abs(along) + abs(across) > 1.0
    assert point.centroid is None and point.echo is not None and point.echo[0] == pytest.approx(np.hypot(800, 300), abs=60.0)


def test_a_simulator_without_sources_gives_the_reference_point() -> None:
    (truth,) = results(scene={**SMALL["scene"], "body": [HULL]}, scans=1, fidelity="documented")[0].truths
    assert truth.centroid is None and truth.echo is not None


def test_near_plots_are_left_out_as_the_scenario_says() -> None:
    assert all(one.given.plots for one in results(scans=3)[1:])
    assert not any(one.given.plots for one in results(scans=3, plots={"nearest_m": 1200}))


def test_a_state_from_the_future_is_an_error() -> None:
    """The scan ends at 2.5 s; rounding is no error."""
    state = TrackState(track="a", time=2.5 + 1e-7, east=0.0, north=0.0, velocity_east=0.0, velocity_north=0.0)
    check_times([state], given(0))
    with pytest.raises(TrackerError, match="scan 0 has track 'a' at 2.6 s, after the end of the scan at 2.5 s"):
        check_times([replace(state, time=2.6)], given(0))


@pytest.mark.parametrize(
    ("mmsi", "words"),
    [
        ((4, None), "scan 1 has MMSI 4 on track 'a', which no AIS report has had"),
        ((5, 5), "MMSI 5 on track 'b' and on track 'a'"),
    ],
)
def test_an_mmsi_that_nobody_reported_or_that_is_on_two_tracks_is_an_error(mmsi: tuple[int | None, ...], words: str) -> None:
    """One that was reported in an earlier scan is none, nor that of a lost track."""
    target = AisTarget(time=0.0, mmsi=5, east=0.0, north=0.0, speed=0.0, course=0.0, station_class="A")
    results = [ScanResult(replace(given(scan), ais=(target,) * (1 - scan)), (), ()) for scan in (0, 1)]
    a, b = (replace(track(name, truth("t", 2.5, 0.0, 0.0)), mmsi=number) for name, number in zip("ab", mmsi, strict=True))
    assert list(answered(results, _Says({1: [replace(a, mmsi=5), replace(b, mmsi=5, lost=True)]})))
    with pytest.raises(TrackerError, match=words):
        list(answered(results, _Says({1: [a, b]})))


class _Says:
    def __init__(self, answers: dict[int, list[TrackState]]) -> None:
        self.answers = answers

    def update(self, scan: TrackerInput) -> list[TrackState]:
        return self.answers.get(scan.scan, [])


def test_own_ship_s_errors_come_with_the_truth() -> None:
    """0.5 degrees of gyro and 30 m of position: in the frame that she reports her target is where its plot is."""
    errors = {"gyro": {"bias_deg": 0.5}, "position": {"bias_m": [30.0, 0.0]}}
    for one in results(scene=SMALL["scene"] | {"errors": errors}, scans=4):
        (plot,), (truth,) = one.given.plots, one.truths
        assert truth.own_error == pytest.approx((30.0, 0.0)) and truth.azimuth_error == pytest.approx(np.radians(0.5))
        east, north = as_reported(truth).position
        assert np.hypot(plot.east - east, plot.north - north) < 1.0 < np.hypot(*np.subtract(truth.position, (east, north)))


def test_land_and_what_stands_there_is_where_tracks_are_not_false() -> None:
    cliff = {"name": "cliff", "shape": "box", "length_m": 200, "width_m": 100, "height_m": 9, "position_m": [0, 950, 0]}
    buoy = {"name": "buoy", "shape": "point", "position_m": [700, 0, 2], "rcs_dbsm": 1}
    body = [*SMALL["scene"]["body"], {**cliff, "heading_deg": 90, "material": "rock"}, buoy]
    scene = {**SMALL["scene"], "body": body, "environment": {"noise": True, "sea_state": 2}}
    around = surroundings(Scenario(**{**SMALL, "targets": ("t",), "scene": scene}))
    assert around.clutter == "sea" and (700.0, 0.0) in around.land
    on_land = {place for place in around.land if place != (700.0, 0.0)}
    assert {(-100.0, 950.0), (100.0, 1000.0), (0.0, 900.0)} <= on_land and max(abs(east) for east, _ in on_land) == 100.0
    assert surroundings(Scenario(**SMALL)).land == ()
    cell = {"noise": True, "rain_cell": [{"position_m": [0, 0], "radius_m": 500, "rain_mm_h": 5}]}
    assert surroundings(Scenario(**{**SMALL, "scene": {**SMALL["scene"], "environment": cell}})).clutter == "rain"
