"""The short modules of radar, each under its name."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import radar_service as rs
from radar_service.display.video import Controls
from radar_service.numerics.types import Complexes, Flags, Floats, Indices
from radar_service.radar.antenna import AntennaPattern, azimuth_oversampling, grid_rows, interpolated_gain
from radar_service.radar.aperture import ChangedPattern, aperture_of
from radar_service.radar.crossing_times import CrossingSearch
from radar_service.radar.description import far_field, radar_lines, two_way_beamwidth
from radar_service.radar.parameters import horizon
from radar_service.radar.patterns import PATTERNS, Table, Taylor, line_source
from radar_service.service.codecs.native import messages
from radar_service.service.feed_request import View
from radar_service.service.spokes import Epoch, SpokeBatch
from tests.scenes import radar, scene


# description: what `check` says of a radar.
def test_the_two_way_beam() -> None:
    squared = scene(radar={"pattern": "gaussian", "beamwidth_deg": 2}).radar
    assert two_way_beamwidth(squared) == pytest.approx(math.radians(2) / math.sqrt(2))
    assert two_way_beamwidth(scene(radar={"pattern": "taylor"}).radar) is None


def test_nonlinear_chirps_and_inverse_filters_are_described() -> None:
    settings = {"modulation": "nlfm", "compression": "inverse", "window": "nuttall"}
    text = "\n".join(radar_lines(scene(radar=settings).radar))
    assert "10 us, 50 MHz, nonlinear chirp, product 500, compressed by the inverse filter" in text
    assert "before the window (nuttall) widens it" in text


def test_nearer_pulses_are_described() -> None:
    pulses = [{"modulation": "none", "pulse_s": 8e-8, "range_max_m": 1500}, {"bandwidth_hz": 20e6}]
    text = "\n".join(radar_lines(scene(radar={"pulses": pulses, "eclipsing": True}).radar))
    assert "pulse     10 us, 20 MHz, product 200, eclipsed to 1499 m" in text
    assert "nearer    to 1500 m: 0.08 us, 15 MHz, not modulated, eclipsed to 12 m" in text


def test_it_is_said_where_the_far_field_begins() -> None:
    """3.9 degrees: D = 0.8859 x 31.859 mm / 0.068068 = 0.41465 m, 2 D^2 / lambda = 10.79 m."""
    assert far_field(radar()) == pytest.approx(10.79, abs=0.01)
    assert far_field(radar(beamwidth_deg=90, beamwidth_el_deg=3.9)) == pytest.approx(10.79, abs=0.01)
    text = "\n".join(radar_lines(radar()))
    assert "far field begins at 10.8 m" in text and "two-way 2.808 (sinc2)" in text


# parameters: what follows from a radar's parameters, against the textbook's figures.
EARTH = 4.0 / 3.0 * 6_371_000.0
LIGHT = 299_792_458.0


def test_range_resolution_and_blind_range() -> None:
    """50 MHz resolve 3 m; a pulse of 1 us is 300 m long, and its echoes from 150 m arrive as it ends (c = 3e8 to 0.1 %)."""
    made = radar(bandwidth_hz=50e6, pulse_s=1e-6)
    assert made.range_resolution == pytest.approx(3.0, rel=1e-3)
    assert made.blind_range == pytest.approx(150.0, rel=1e-3)


def test_the_horizon_is_where_the_curved_sea_blocks_the_path() -> None:
    """4.12 km x (sqrt(15) + sqrt(h)) with h in metres (Skolnik 2001: 4.12 is sqrt(2 ae) in three digits); under the sea as on
    it, and without end on a flat earth."""
    height = np.array([0.0, 10.0, 100.0, -3.0])
    expected = 4120.0 * (np.sqrt(15.0) + np.sqrt(np.maximum(height, 0.0)))
    np.testing.assert_allclose(horizon(height, 15.0, EARTH), expected, rtol=1e-3)
    assert np.isinf(horizon(height, 15.0, np.inf)).all()


def test_a_scene_knows_its_horizon() -> None:
    made = scene(radar={"height_m": 20})
    assert made.horizon(10.0) == horizon(10.0, 20.0, EARTH)
    assert scene(environment={"earth": "flat"}).horizon() == np.inf


def test_the_first_spoke_and_scan_not_before_a_time_are_exact() -> None:
    """At the time of each spoke, and one rounding before and after it; a period of 1/11 s is not a binary number."""
    made = radar(azimuths=120, rpm=60 / 11 / 120 * 60)
    for number in (0, 1, 7, 119, 120, 12345, 10**9 + 7):
        time = made.time_of_spokes(float(number))
        before, after = math.nextafter(time, -math.inf), math.nextafter(time, math.inf)
        assert [made.first_spoke(each) for each in (before, time, after)] == [number, number, number + 1]
        assert [made.first_scan(each) for each in (time, after)] == [-(-number // 120), number // 120 + 1]


# antenna: gain tables and azimuth sampling of antenna patterns.
BEAM = np.deg2rad(3.9)
TABLE = Table(((0.0, 1.0), (0.02, 0.1), (0.10, 0.001)))


def test_a_pattern_without_an_aperture_width_cannot_be_made() -> None:
    class Narrow(AntennaPattern):
        name = "narrow"

        def gain(self, offset: Floats | float, beamwidth: float) -> Floats:
            return np.exp(-np.abs(np.asarray(offset) / beamwidth))

    with pytest.raises(TypeError, match="aperture_width"):
        Narrow()


@pytest.mark.parametrize("pattern", [*PATTERNS.values(), Taylor(40.0, 6), TABLE])
def test_the_table_of_gains_is_the_pattern(pattern: AntennaPattern) -> None:
    """3e-6, as interpolated_gain promises, at offsets on both sides of boresight."""
    offset = np.random.default_rng(1).uniform(-np.pi, np.pi, 5000)
    np.testing.assert_allclose(interpolated_gain(offset, BEAM, pattern), pattern.gain(offset, BEAM), atol=3e-6)


def test_a_sinc2_beam_has_its_band_in_grid_rows() -> None:
    """sinc^2 of half-power width b has spatial frequencies up to 2 x 0.8859 / (2 b) per radian each side: 0.564 b / step."""
    assert azimuth_oversampling(BEAM, 720) == pytest.approx(0.564 * BEAM / (2 * np.pi / 720), rel=1e-3)
    rows = 720
    offset = (np.arange(rows) * 2 * np.pi / rows + np.pi) % (2 * np.pi) - np.pi
    spectrum = np.abs(np.fft.fft(PATTERNS["sinc2"].gain(offset, BEAM)))
    band = rows / azimuth_oversampling(BEAM, rows) / 2
    order = np.abs(np.fft.fftfreq(rows) * rows)
    assert spectrum[order > band + 2].max() < 1e-3 * spectrum[0] < spectrum[order < 0.9 * band].min()


@pytest.mark.parametrize(
    ("azimuths", "beamwidth_deg", "multiple"), [(720, 3.9, 1), (720, 1.0, 3), (2048, 0.9, 2), (360, 0.4, 13)]
)
def test_grid_rows_are_the_minimum_that_leaves_two_thirds_of_the_band(
    azimuths: int, beamwidth_deg: float, multiple: int
) -> None:
    beamwidth = np.deg2rad(beamwidth_deg)
    rows = grid_rows(azimuths, beamwidth)
    assert rows == multiple * azimuths
    assert azimuth_oversampling(beamwidth, rows) >= 2.9
    assert multiple == 1 or azimuth_oversampling(beamwidth, rows - azimuths) < 2.9


# aperture: apertures against the patterns that they make, and patterns less what is taken from them.
WAVELENGTH, BEAMWIDTH = 0.0319, np.radians(1.0)
LINE_SOURCES = [pattern for pattern in (*PATTERNS.values(), Taylor(25.0, 6)) if line_source(pattern) is not None]


@pytest.mark.parametrize("pattern", LINE_SOURCES, ids=lambda pattern: pattern.description)
def test_an_aperture_makes_its_pattern(pattern: AntennaPattern) -> None:
    """The square of its field is the gain, and so is that of elements with its illumination (to the rounding of 400 of them)."""
    aperture = aperture_of(pattern, BEAMWIDTH, WAVELENGTH)
    assert aperture is not None
    offset = np.linspace(0.0, 4.0, 41) * BEAMWIDTH
    cycles = aperture.length / WAVELENGTH * offset
    np.testing.assert_allclose(aperture.pattern(cycles) ** 2, pattern.gain(offset, BEAMWIDTH), rtol=1e-9, atol=1e-12)
    place = ((np.arange(400) + 0.5) / 400 - 0.5) * aperture.length
    field = aperture.illumination(place) / 400 @ np.exp(2j * np.pi * np.outer(place / aperture.length, cycles))
    np.testing.assert_allclose(
        field, aperture.pattern(cycles), atol=3e-4
    )  # midpoint rule at 7 cycles: (pi 7 / 400)^2 / 6 of 0.4


def test_patterns_without_an_aperture_have_none() -> None:
    table = Table(((0.0, 1.0), (0.1, 0.01)))
    assert [aperture_of(each, BEAMWIDTH, WAVELENGTH) for each in (PATTERNS["gaussian"], PATTERNS["printed"], table)] == [
        None
    ] * 3


class Pane:
    """Takes a share of the field on the starboard side."""

    def __init__(self, share: float, extent: float) -> None:
        self.share, self.extent = share, extent

    def subtract(self, field: Complexes, from_bow: Floats, offset: Floats) -> None:
        field -= np.where((np.sin(from_bow) > 0.0) & (np.abs(offset) < self.extent), self.share * field, 0.0)

    def reaches(self, from_bow: Floats) -> Flags:
        return np.sin(from_bow) > 0.0


def test_changes_take_from_the_field_one_after_the_other() -> None:
    """Two panes leave 0.9 x 0.8 of the field to starboard, two ways its square, and all of it to port; 1e-5: of the table."""
    aperture = aperture_of(PATTERNS["cosine"], BEAMWIDTH, WAVELENGTH)
    assert aperture is not None
    pattern = ChangedPattern(aperture, WAVELENGTH, [Pane(0.1, 0.01), Pane(0.2, 0.02)])
    from_bow, offset = np.array([1.0, 1.0, 4.0]), np.array([0.002, 0.015, 2.0 * np.pi - 0.002])
    plain = np.sqrt(PATTERNS["cosine"].gain(np.abs(np.array([0.002, 0.015, 0.002])), BEAMWIDTH))
    np.testing.assert_allclose(np.abs(pattern.one_way(from_bow, offset)), plain * [0.72, 0.8, 1.0], atol=1e-5)
    change = pattern.two_way_change(from_bow, offset)
    np.testing.assert_allclose(change, plain**2 * [0.72**2 - 1.0, 0.8**2 - 1.0, 0.0], atol=1e-5)
    assert pattern.reaches(from_bow).tolist() == [True, True, False] and pattern.extent == 0.02
    assert pattern.loss_db(1.0) == pytest.approx(-40.0 * np.log10(0.72)) and pattern.loss_db(4.0) == pytest.approx(0.0)


# blind_sectors: blind sectors: one rule decides for the engine and for the feed.
DEGREE = math.pi / 180


@pytest.mark.parametrize(
    ("sector", "inside", "outside"),
    [
        ([80, 100], [80, 90, 100], [79, 101, 270]),
        ([350, 10], [350, 0, 10, 360], [349, 11, 180]),
        ([-10, 10], [350, 0, 10], [349, 11, 180]),
        ([0, 360], [0, 90, 359], []),
        ([-180, 180], [0, 90, 180, 359], []),
        ([-360, 360], [0, 90, 180, 359], []),
        ([-299.9, 60.1], [0, 60.1, 180, 300], []),  # a full turn but for rounding in radians
    ],
)
def test_a_sector_runs_clockwise_and_holds_both_its_ends(
    sector: list[float], inside: list[float], outside: list[float]
) -> None:
    silent = radar(blind_sectors_deg=[sector]).is_blind(np.array(inside + outside) * DEGREE)
    assert silent.tolist() == [True] * len(inside) + [False] * len(outside)


@pytest.mark.parametrize(("sector", "count"), [([0, 360], 36), ([350, 10], 3)])
def test_engine_and_feed_are_silent_at_the_same_azimuths(sector: list[float], count: int) -> None:
    """36 azimuths 10 degrees apart, own ship heading 070. Noise fills every spoke that is not silent."""
    settings = {
        "azimuths": 36, "beamwidth_deg": 12, "range_max_m": 300, "pulse_s": 1e-6, "blind_sectors_deg": [sector],
    }  # fmt: skip
    echo = {"name": "p", "shape": "sphere", "radius_m": 5, "position_m": [20, 0, 15], "rcs_dbsm": 40}
    scene = rs.load_scene({"radar": settings, "own_ship": {"heading_deg": 70}, "body": [echo]})
    engine = rs.Simulator(scene)
    scan = engine.scan()
    heading = scene.own_ship.pose(scan.time).heading
    silent = scene.blind(scan.time, scan.azimuth)
    marked: list[bool] = []
    epoch = Epoch("e", engine, None)
    for block in rs.Simulator(scene).blocks(scans=1):
        message = messages.spokes(SpokeBatch(epoch, block.first, block, Controls()), View("f32"))
        marked += message.get("blind", [False] * len(block))
    assert marked == silent.tolist()
    assert marked == scene.radar.is_blind(scan.azimuth - heading).tolist()
    assert sum(marked) == count == int(np.sum(np.abs(scan.field).max(axis=1) == 0.0))


def test_a_sector_without_width_is_refused() -> None:
    with pytest.raises(rs.SceneError) as fault:
        radar(blind_sectors_deg=[[0, 10], [90, 90]])
    message = str(fault.value)
    for part in ("radar.blind_sectors_deg[1]: [90, 90] is not allowed", "from -360 to 360", "remove the sector"):
        assert part in message


# crossing_times: closed forms, a slow search from spoke to spoke, and the border between two scans.
PERIOD, SPOKES = 2.5, 720


class Straight:
    """Points on straight courses, relative to the antenna."""

    def __init__(self, position: Floats, velocity: Floats) -> None:
        self.position, self.velocity = np.asarray(position, dtype=float), np.asarray(velocity, dtype=float)

    def __call__(self, points: Indices, time: Floats) -> Floats:
        return np.asarray(self.position[points] + self.velocity[points] * time[:, None])

    def search(self) -> CrossingSearch:
        return CrossingSearch(self, len(self.position), PERIOD, SPOKES)

    def ahead(self, point: int, time: Floats) -> Floats:
        """How far the boresight is ahead at times (...), -pi to pi."""
        east, north = (self.position[point, k] + self.velocity[point, k] * time for k in (0, 1))
        return np.asarray((2 * np.pi * time / PERIOD - np.arctan2(east, north) + np.pi) % (2 * np.pi) - np.pi)

    def slow_crossings(self, point: int, scan: int, steps: int = 20_000) -> list[float]:
        """By a fine search for changes of sign, each refined by Brent's method."""
        times = (scan + np.arange(steps + 1) / steps) * PERIOD
        ahead = self.ahead(point, times)
        changes = np.flatnonzero((ahead[:-1] * ahead[1:] < 0) & (np.abs(ahead[:-1]) < 1))
        return [brentq(lambda t: self.ahead(point, t), times[k], times[k + 1], xtol=1e-14) for k in changes]


def test_points_at_rest_are_crossed_when_the_boresight_points_at_them() -> None:
    angles = np.deg2rad([0.0, 0.1, 90.0, 180.0, 270.0, 359.9])
    found = Straight(1000 * np.stack([np.sin(angles), np.cos(angles)], axis=1), np.zeros((6, 2))).search().within(7)
    np.testing.assert_array_equal(found.point, np.arange(6))
    np.testing.assert_allclose(found.time, (7 + angles / (2 * np.pi)) * PERIOD, rtol=1e-15)  # rounding


@pytest.mark.parametrize("scan", [0, 400])
def test_points_under_way_agree_with_a_slow_search(scan: int) -> None:
    """Drawn courses: far ones, and some that pass within metres of the antenna during the scan. Tolerance: rounding of
    the time, 1e-13 s at t = 1000 s, and of a bearing that turns by up to 30 rad/s, both times ten."""
    rng = np.random.default_rng(20261122 + scan)
    velocity = rng.uniform(-25, 25, (40, 2))
    distance = np.geomspace(2, 20_000, 40)[:, None]
    heading = rng.uniform(0, 2 * np.pi, 40)
    middle = distance * np.stack([np.sin(heading), np.cos(heading)], axis=1)
    points = Straight(middle - velocity * (scan + 0.5) * PERIOD, velocity)
    found = points.search().within(scan)
    assert (np.diff(found.time) >= 0).all()
    for point in range(40):
        times = found.time[found.point == point]
        np.testing.assert_allclose(times, points.slow_crossings(point, scan), atol=1e-11, rtol=0)
    both, later = points.search().within(scan, 2), points.search().within(scan + 1)
    for together, *alone in zip(both, found, later, strict=True):
        np.testing.assert_array_equal(together, np.concatenate(alone))


@pytest.mark.parametrize(("drift", "counts"), [(25.0, {0, 1}), (-25.0, {1, 2})], ids=["with the beam", "against it"])
def test_a_target_near_north_is_crossed_never_once_or_twice_in_a_scan(drift: float, counts: set[int]) -> None:
    """It passes north slowly; over all scans it is crossed as often as the boresight overtakes it."""
    points = Straight([[-drift * 25.0 * PERIOD, 3000.0]], [[drift, 0.0]])
    per_scan = [points.search().within(scan).time for scan in range(50)]
    assert {len(times) for times in per_scan} == counts
    every = np.concatenate(per_scan)
    ends = [math.atan2(*(points.position[0] + points.velocity[0] * t)) for t in (0.0, 50 * PERIOD)]
    assert len(every) == 50 - math.floor(ends[1] / (2 * math.pi)) + math.floor(ends[0] / (2 * math.pi))
    assert (np.diff(every) > 0.9 * PERIOD).all()


@pytest.mark.parametrize("east", [0.0, -1e-18, 1e-18, -1e-10])
@pytest.mark.parametrize("scan", [0, 1, 12_345])
def test_a_target_exactly_north_belongs_to_one_scan(east: float, scan: int) -> None:
    points = Straight([[east, 1000.0]], [[0.0, 0.0]])
    counts = [len(points.search().within(number).time) for number in (scan, scan + 1)]
    assert counts == [1, 1]


def test_without_points_there_is_nothing() -> None:
    found = Straight(np.zeros((0, 2)), np.zeros((0, 2))).search().within(0)
    assert len(found.point) == len(found.time) == 0
