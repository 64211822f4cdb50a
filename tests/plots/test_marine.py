"""The threshold of a ship's radar: false alarms in noise and in K-distributed clutter drawn here, and what it lets through."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.special import gammainccinv

import radar_service as rs
from radar_service.plots.extractor import PlotExtractor, in_clutter
from radar_service.plots.false_alarms import effective_looks
from radar_service.plots.marine import BESIDE_LAND, MEAN_RATIO, LandCells, MarineThreshold
from radar_service.plots.plot_report import labelled_plots
from radar_service.plots.thresholds import KnownThreshold
from radar_service.radar.parameters import Radar
from radar_service.receive.compression import receiver_noise_power
from radar_service.scene_file.document import scene_content
from radar_service.trace.land_mask import LandMask
from tests.plots.test_detections import scan_of_power
from tests.scenes import SHIPPED, averaging, radar, scene

SET = {
    "azimuths": 360,
    "beamwidth_deg": 3.0,
    "range_max_m": 6000.0,
    "pulse_s": 1e-6,
    "bandwidth_hz": 20e6,
    "sample_rate_hz": 30e6,
}


QUAY = {"name": "quay", "shape": "box", "length_m": 100.0, "width_m": 100.0, "height_m": 5.0, "position_m": [1000.0, 0.0, 0.0],
        "material": "concrete"}  # fmt: skip


@pytest.fixture(scope="module")
def ship() -> Radar:
    return radar(**SET)


def clutter(ship: Radar, shape: float, ratio_db: float, seed: int, cells: int = 1200, pulses: int = 1) -> np.ndarray:
    """Power (A, cells) [W] of noise and of clutter that falls as R^-3: speckle of the beam's autocorrelation in azimuth, gamma
    texture that two cells and a beam share, and that ratio to noise in cell 300. Nothing here is the engine's."""
    rng = np.random.default_rng(seed)
    spokes = ship.azimuths
    white = rng.standard_normal((2, spokes, cells))
    offset = (np.arange(spokes) + spokes // 2) % spokes - spokes // 2
    gain = ship.azimuth_gain(offset * ship.azimuth_step)
    spectrum = np.fft.fft(gain / np.sqrt(np.sum(gain**2)))
    speckle = np.fft.ifft(np.fft.fft(white[0] + 1j * white[1], axis=0) * spectrum[:, None], axis=0) / np.sqrt(2.0)
    texture = np.repeat(np.repeat(rng.gamma(shape, 1.0 / shape, (spokes // 6, cells // 2)), 6, axis=0), 2, axis=1)
    mean = 10.0 ** (ratio_db / 10.0) * (300.0 / (np.arange(cells) + 30.0)) ** 3
    noise = rng.standard_normal((2, spokes, cells)) / np.sqrt(2.0)
    field = speckle * np.sqrt(texture * mean) + (noise[0] + 1j * noise[1]) / np.sqrt(pulses)
    power = np.abs(field) ** 2 + rng.standard_gamma(pulses - 1, field.shape) / pulses
    return (power * receiver_noise_power(ship)).astype(np.float32)


@pytest.mark.parametrize("shape", [0.3, 1.0, 30.0])
@pytest.mark.parametrize("ratio_db", [-60.0, 0.0, 25.0])
def test_false_alarms_are_as_stated_within_a_factor_of_three(ship: Radar, shape: float, ratio_db: float) -> None:
    """In noise, in a mixture, and in clutter of any shape: the K law is exact, but for what the regions mix. A known threshold
    has 100 to 1000 times too many in clutter."""
    pfa = 1e-3
    power = [clutter(ship, shape, ratio_db, seed) for seed in range(2)]
    rate = np.mean([(each > MarineThreshold(ship, pfa).of(each)).mean() for each in power])
    assert pfa / 3.0 < rate < 3.0 * pfa
    if ratio_db > 0.0:
        assert (power[0] > KnownThreshold(ship, pfa).of(power[0])).mean() > 100.0 * pfa


@pytest.mark.parametrize("pulses", [5, 10])
@pytest.mark.parametrize("ratio_db", [-60.0, 0.0, 25.0])
def test_averaged_pulses_keep_that_rate_and_lower_the_threshold_in_noise(ratio_db: float, pulses: int) -> None:
    pfa, ship = 1e-3, radar(**averaging(SET, pulses))
    power = clutter(ship, 1.0, ratio_db, 3, pulses=pulses)
    threshold = MarineThreshold(ship, pfa).of(power)
    assert pfa / 3.0 < (power > threshold).mean() < 3.0 * pfa
    if ratio_db < 0.0:  # 2 to 4 dB of the thresholds of a mean of 5 spokes; a cell shows by its mean, so compare medians
        single = MarineThreshold(radar(**SET), pfa).of(power)
        assert 10.0 * np.log10(np.median(single / threshold)) > 1.5


def test_looks_of_a_beam_are_those_of_drawn_speckle(ship: Radar) -> None:
    """Mean squared over variance of the mean over 3 and 7 spokes of pure speckle."""
    power = np.concatenate([clutter(ship, 1e4, 90.0, seed, 300) for seed in range(4)], axis=1)
    power = power / power.mean(axis=0)
    for spokes in (3, 7):
        mean = np.mean([np.roll(power, k, axis=0) for k in range(spokes)], axis=0)
        assert effective_looks(ship, spokes) == pytest.approx(1.0 / mean.var(), rel=0.05)


def test_a_pulse_of_another_radar_is_rejected_and_a_weak_steady_echo_is_integrated(ship: Radar) -> None:
    """Two spokes of 40 dB with one between them, and 9 dB over noise in three spokes, each below the threshold of one look."""
    power = clutter(ship, 1.0, -60.0, 5)
    noise = receiver_noise_power(ship)
    power[[100, 102], 600] = 1e4 * noise
    power[199:202, 700] = 8.5 * noise
    exceeded = power > MarineThreshold(ship, 1e-4).of(power)
    assert not exceeded[[100, 102], 600].any() and exceeded[200, 700]
    assert power[200, 700] < KnownThreshold(ship, 1e-4).of(power)[0, 0]


def test_missing_cells_have_no_part_in_a_level(ship: Radar) -> None:
    """A spoke that is missing, and half the circle beyond cell 400: elsewhere the threshold changes little, there it is NaN."""
    power = clutter(ship, 1.0, 20.0, 9)
    whole = MarineThreshold(ship).of(power)
    power[300] = np.nan
    power[:180, 400:] = np.nan
    holed = MarineThreshold(ship).of(power)
    assert np.isnan(holed[300]).all() and np.isnan(holed[10:170, 400:]).all()
    quiet = np.abs(10.0 * np.log10(holed[200:290] / whole[200:290]))
    assert np.median(quiet) < 1.0


def test_land_and_a_beamwidth_about_it_are_masked_from_where_own_ship_is() -> None:
    made = scene([QUAY], radar=SET)
    land, ship = LandMask.of(made.bodies), made.radar
    assert land is not None
    cells = LandCells(land, ship)
    step = 10.0
    for east in (0.0, 600.0):
        scan = scan_of_power(np.ones((360, 300)))
        azimuth = np.arange(360) * ship.azimuth_step
        scan = replace(
            scan,
            position=np.tile([east, 0.0], (360, 1)),
            range=(np.arange(300) + 0.5) * step,
            range_step=step,
            azimuth=azimuth,
        )
        row, cell = np.nonzero(np.isnan(cells.without(scan)))
        assert (cell.min(), cell.max()) == (
            int((950 - east) / step) - BESIDE_LAND,
            int((1050 - east) / step) - 1 + BESIDE_LAND + (np.hypot(1050.0 - east, 50.0) > 1050.0 - east + step),
        )
        turned = row - 90  # from east
        edge = np.degrees(np.arctan2(50.0, 950.0 - east))
        assert np.ceil(edge) + 2 <= turned.max() <= np.ceil(edge) + 4 and turned.min() == -turned.max()


def test_lengths_are_checked(ship: Radar) -> None:
    for name in ("guard", "window"):
        with pytest.raises(ValueError, match=f"{name}: 0.0 is not allowed; a length above 0 m"):
            MarineThreshold(ship, **{name: 0.0})


def test_land_at_the_end_of_the_range_covers_no_cell_at_its_start() -> None:
    made = scene([QUAY], radar=SET)
    scan, land = scan_of_power(np.ones((360, 100))), LandMask.of(made.bodies)
    assert land is not None
    azimuth = np.arange(360) * made.radar.azimuth_step
    at = {"position": np.zeros((360, 2)), "range": (np.arange(100) + 0.5) * 10.0, "range_step": 10.0}
    scan = replace(scan, azimuth=azimuth, **at)
    covered = np.isnan(LandCells(land, made.radar).without(scan)).any(axis=0)
    assert np.flatnonzero(covered).tolist() == [93, 94, 95, 96, 97, 98, 99]


def test_a_scene_decides_which_threshold_it_has() -> None:
    """Sea, rain or land: the marine one; else the noise is known, as before."""
    for made, marine in (
        (scene(radar=SET), False), (scene(radar=SET, environment={"sea_state": 1}), True),
        (scene(radar=SET, environment={"rain_mm_h": 4.0}), True), (scene([QUAY], radar=SET), True),
        (scene(radar=SET, environment={"rain_cell": [{"position_m": [0, 0], "radius_m": 500, "rain_mm_h": 9}]}), True),
    ):  # fmt: skip
        assert in_clutter(made) is marine
        assert isinstance(PlotExtractor.for_scene(made).threshold, MarineThreshold if marine else KnownThreshold)


CELL = {"position_m": [2500, -3000], "radius_m": 900, "rain_mm_h": 100, "course_deg": 60, "speed_kn": 20}


@pytest.mark.parametrize(
    ("name", "weather", "unseen"), [("open-sea", {}, "yacht"), ("harbour", {"rain_cell": [CELL]}, "reflector")]
)
def test_shipped_seas_do_not_flood(name: str, weather: dict[str, Any], unseen: str) -> None:
    """Sea state 3: at most 20 plots of sea and rain a scan, ships and buoys held; 1e-4 of a CFAR for noise gives 1,500 and more,
    a cell without a level of its own 75. Reflectors stand on land."""
    source = dict(scene_content(SHIPPED / f"{name}.toml"))
    made = rs.load_scene(source | {"environment": source["environment"] | weather}, folder=SHIPPED)
    report = labelled_plots(rs.Simulator(made, "balanced", 2, labels=True), PlotExtractor.for_scene(made), 2)
    assert sum(plot.source in ("sea", "rain") for plot in report.plots) / report.scans <= 20.0
    assert [
        body.name for body in report.bodies if body.pd != 1.0 and unseen not in body.name
    ] == [] and report.remark is None
    assert np.mean([plot.plot.correlated for plot in report.plots if plot.kind == "ship"]) > 0.9


@pytest.mark.parametrize(("noise", "rain", "state"), [(True, 4, 3), (False, 0, 2)])
def test_a_spiky_sea_in_rain_or_without_noise_does_not_flood(noise: bool, rain: float, state: float) -> None:
    """Some 8 and 3 plots of spikes a scan, by the quantile 0.95 alone 34 and 37; both points are held."""
    table = {"azimuths": 1024, "beamwidth_deg": 1.5, "range_max_m": 2400, "pulse_s": 8e-8, "rpm": 24, "modulation": "none"}
    points = [{"name": name, "shape": "point", "position_m": [east, north, 10], "rcs_dbsm": 15}
              for name, east, north in (("near", 600, 1200), ("far", -900, 1700))]  # fmt: skip
    air = {"noise": noise, "sea_state": state, "seaway": True, "rain_mm_h": rain}
    made = rs.load_scene({"name": "rain", "radar": table, "environment": air, "body": points})
    report = labelled_plots(rs.Simulator(made, "balanced", 1, labels=True), PlotExtractor.for_scene(made), 4)
    assert sum(plot.source == "sea" for plot in report.plots) <= 4 * 15 and [body.pd for body in report.bodies] == [1.0, 1.0]


def test_rain_alone_keeps_the_level_of_its_speckle(ship: Radar) -> None:
    """The gamma law of three spokes at rest, within 0.8 dB: 0.27 dB is the loss of 100 reference cells, and twice 0.25 dB the
    standard error of the factor, the median of nine regions. Laws of spikes in uniform clutter were 1.2 dB above it."""
    power, looks = clutter(ship, 1e4, 60.0, 6, cells=600), effective_looks(ship, 3)
    mean = (power + np.roll(power, 1, axis=0) + np.roll(power, -1, axis=0)) / 3.0
    level = (MarineThreshold(ship).of(power) * mean / power)[:, 100:500] / mean[:, 100:500].mean(axis=0)
    assert abs(10.0 * np.log10(np.median(level) * looks / gammainccinv(looks, MarineThreshold(ship).pfa))) < 0.8


def test_cells_of_rain_have_a_level_of_their_own(ship: Radar) -> None:
    """20 dB of clutter in a disc, whose edges along the beam are shorter than the guard: of 144,000 cells few exceed; by the
    curve alone 598 do."""
    power = np.random.default_rng(3).exponential(1.0, (ship.azimuths, 400)).astype(np.float32)
    row, cell = np.ogrid[: ship.azimuths, :400]
    power[((row - 150) / 45.0) ** 2 + ((cell - 200) / 50.0) ** 2 < 1.0] *= 100.0
    assert np.count_nonzero(power > MarineThreshold(ship).of(power)) <= 10


def test_a_spiky_sea_has_a_steadier_level_than_the_cells_of_one_beam(ship: Radar) -> None:
    """120 cells of one beam with 60 textures of shape 0.5 have by the K law a mean of variance 0.051. Five beams to each side
    share 4 textures of a cell, so a quarter of it is left, and as much for the curve and for the shape that is measured."""
    mean = 10.0**2.5 * (300.0 / (np.arange(200, 600) + 30.0)) ** 3 * receiver_noise_power(ship)
    looks, spread = effective_looks(ship, 3), []
    for seed in range(2):
        power = clutter(ship, 0.5, 25.0, seed)
        integral = (power + np.roll(power, 1, axis=0) + np.roll(power, -1, axis=0)) / 3.0
        spread.append(np.log((MarineThreshold(ship, 1e-3).of(power) * integral / power)[:, 200:600] / mean))
    one_beam = (1.0 / 0.5) / 60.0 + (1.0 + 1.0 / 0.5) / looks / 120.0
    assert np.var(spread) < 0.75 * one_beam


def test_a_shadow_keeps_a_level_of_its_own_to_its_edge(ship: Radar) -> None:
    """Half the circle has 20 dB of clutter: on both sides of the edge the threshold is that of the middle, within the ratio at
    which sides pass for alike; a mean of both would be 3.7 dB below."""
    power = np.random.default_rng(4).exponential(1.0, (ship.azimuths, 1200)) * receiver_noise_power(ship)
    power[:180] *= 100.0
    mean = (power + np.roll(power, 1, axis=0) + np.roll(power, -1, axis=0)) / 3.0
    level = np.median((MarineThreshold(ship).of(power.astype(np.float32)) * mean / power)[:, 200:1000], axis=1)
    for edge, middle in ((range(171, 179), 90), (range(181, 189), 270)):
        assert np.abs(np.log(level[edge] / np.median(level[middle - 40 : middle + 40]))).max() < np.log(MEAN_RATIO)
