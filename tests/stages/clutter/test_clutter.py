"""Clutter as it arrives in the profiles: level by the radar equation, laws and correlations by closed forms."""

from typing import Any, NamedTuple

import numpy as np
import pytest
import scipy.special
import scipy.stats
from numpy.typing import NDArray
from scipy.integrate import quad

import radar_service as rs
from radar_service.engine.pipeline import contributions, tile_azimuths
from radar_service.engine.preparation import prepare
from radar_service.numerics.frames import effective_earth_radius
from radar_service.numerics.result_cache import Revision
from radar_service.receive.compression import compression_for
from radar_service.records.fidelity import PRESETS
from radar_service.stages.clutter.azimuth_rows import (
    BLOCK,
    CHUNK,
    AzimuthRowCache,
    beam_weights,
    weight_rows,
)
from radar_service.stages.clutter.clutter import RAIN_HEIGHT, beam_height, prepare_clutter, reflectivity
from radar_service.stages.clutter.effect import RAIN, SEA
from radar_service.stages.clutter.resolution_cell import received_share, resolution_cell
from radar_service.stages.clutter.sea import (
    SHAPE_LIMITS,
    beyond_measured_shapes,
    mean_sigma0,
    peak_wave_period,
    swell_factor,
    texture_length,
    texture_shape,
    wind_factor,
)  # fmt: skip
from radar_service.stages.clutter.sea_clutter import Sea, sea_power
from radar_service.stages.clutter.stage import ClutterStage
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.world.seaway import drawn_waves
from tests.alone import clutter_of
from tests.reference.compressed_pulse import compressed_pulse, sinc2_beam
from tests.scenes import scene

Floats = NDArray[np.float64]
LEVEL = 1e-4  # of each statistical test; seeds are fixed, so a test either always passes or never
EARTH = 4 / 3 * 6_371_000.0
WAVELENGTH = 299_792_458 / 9.41e9

# 20 m bins and azimuths two beamwidths apart, a revolution a minute: texture (6 to 12 m, 4 s) is new in every cell of every
# scan, and speckle from every third bin to the next.
APART = {
    "range_max_m": 9000, "bandwidth_hz": 5e6, "pulse_s": 4e-6, "azimuths": 45, "beamwidth_deg": 4, "rpm": 1,
    "coarse_azimuths": True,
}  # fmt: skip


def sea(radar: dict[str, Any], shape: float | None = None, **environment: Any) -> rs.Scene:
    """Open sea of state 4 with the wind from 070."""
    texture = {} if shape is None else {"sea_texture_shape": shape}
    return scene([], radar=radar, environment={"sea_state": 4, "wind_from_deg": 70, **texture, **environment})


def cell_by_hand(made: rs.Scene, range_step: float) -> tuple[float, float]:
    """Two-way width [rad] of a sinc^2 beam, 2/3 of a beamwidth / 0.8859, and length [m] of the Hamming pulse's power, summed
    over the closed form at the bins, as the engine receives it."""
    radar = made.radar
    delay = np.arange(-2000, 2001) / radar.sample_rate
    pulse = np.abs(compressed_pulse(delay, radar.bandwidth, radar.pulse, (0.54, 0.46))) ** 2
    return 2 / 3 * radar.beamwidth / 0.885893, float(pulse.sum()) * range_step


class Instant(NamedTuple):
    """What of a scan its mean power depends on."""

    range: Floats
    azimuth: Floats
    range_step: float


def grazing_by_hand(made: rs.Scene, r: Floats) -> Floats:
    """Grazing angle [rad] at the sea, on the parabola z = -d^2 / (2 ae)."""
    d = np.sqrt(np.maximum(r**2 - (made.radar.height + r**2 / (2 * EARTH)) ** 2, 0))
    return np.asarray(np.arcsin(np.minimum((made.radar.height + d**2 / (2 * EARTH)) / r, 1)) - d / EARTH)


def mean_by_hand(made: rs.Scene, scan: rs.Scan | Instant) -> Floats:
    """Mean power (A, N) [W]: Pt G^2 lambda^2 sigma0 A G_el^2 L / ((4 pi)^3 R^4), A = R x width x length."""
    radar, r = made.radar, scan.range
    width, length = cell_by_hand(made, scan.range_step)
    psi = grazing_by_hand(made, r)
    elevation = -psi - r * np.cos(psi) / EARTH
    sigma = mean_sigma0(psi, radar.frequency, made.environment.sea_state, "h") * r * width * length
    sigma = sigma * wind_factor((scan.azimuth - made.environment.wind_from)[:, None], psi, WAVELENGTH)
    loss = 10 ** (-0.2 * made.environment.gas_db_per_km * r / 1000)
    gain = sinc2_beam(elevation, radar.beamwidth_el) ** 2
    return np.asarray(radar.power * 1e6 * WAVELENGTH**2 * sigma * gain * loss / ((4 * np.pi) ** 3 * r**4))


def normalised(made: rs.Scene, scans: int, seed: int = 1) -> Floats:
    """Power over its mean (scans, A, n), every third bin from 0.5 to 9 km."""
    sim = rs.Simulator(made, seed=seed)
    taken = [sim.scan() for _ in range(scans)]
    return np.stack([(s.power / mean_by_hand(made, s))[:, 25::3] for s in taken])


def k_survival(threshold: Floats, shape: float) -> Floats:
    """P(intensity > threshold) of the K distribution of unit mean: 2 / Gamma(nu) (nu t)^(nu/2) K_nu(2 sqrt(nu t)) (Ward)."""
    t = np.asarray(threshold, dtype=np.float64)
    bessel = scipy.special.kv(shape, 2 * np.sqrt(shape * t))
    return np.asarray(2 / scipy.special.gamma(shape) * (shape * t) ** (shape / 2) * bessel)


def test_mean_power_by_hand_at_every_range() -> None:
    """From under the antenna to past the horizon, through a vertical beam of 5 degrees that looks level: the cell's width
    and length, and with them the power, by hand to 2e-3 (what the sampled band cuts off a chirp of only 20 cycles)."""
    made = sea(APART | {"range_max_m": 18_000, "beamwidth_el_deg": 5}, gas_db_per_km=0.1)
    radar = made.radar
    cell = resolution_cell(lambda x: sinc2_beam(x, radar.beamwidth), compression_for(radar, 6), radar.range_step)
    assert (cell.width, cell.length) == pytest.approx(cell_by_hand(made, radar.range_step), rel=2e-3)
    distance = (np.arange(radar.bins, dtype=np.float64) + 0.5) * radar.range_step
    upwind = Instant(distance, np.array([made.environment.wind_from]), radar.range_step)
    by_hand = mean_by_hand(made, upwind)[0] / wind_factor(np.array(0.0), grazing_by_hand(made, distance), WAVELENGTH)
    power = sea_power(made, distance, cell, EARTH)
    assert power[0] == 0.0  # 10 m, with the antenna 15 m up
    np.testing.assert_allclose(power[1:], by_hand[1:], rtol=2e-3, atol=1e-30)


@pytest.mark.parametrize("shape", [0.5, 1.0, 5.0])
def test_moments_and_law_are_those_of_k(shape: float) -> None:
    """<I^2>/<I>^2 = 2 (1 + 1/nu) to 5 sigma, the whole law by Kolmogorov-Smirnov."""
    ratio = normalised(sea(APART, shape), 12).ravel()
    second = 2 * (1 + 1 / shape)
    fourth = 24 * scipy.stats.gamma(shape, scale=1 / shape).moment(4)
    assert np.mean(ratio**2) == pytest.approx(second, abs=5 * np.sqrt((fourth - second**2) / ratio.size))
    assert scipy.stats.kstest(k_survival(ratio, shape), "uniform").pvalue > LEVEL


# Threshold over mean for a false alarm probability of 1e-4 [dB], printed to two places.
THRESHOLDS = {0.5: 16.28, 1.0: 14.53, 5.0: 11.56}


@pytest.mark.sample(2)
@pytest.mark.parametrize("shape", THRESHOLDS)
def test_false_alarms_at_the_printed_thresholds(shape: float) -> None:
    """Share of 360 000 cells above the 1e-4 threshold: 5 sigma of the binomial law."""
    ratio = normalised(sea(APART, shape), 56).ravel()
    count = int(np.sum(ratio > 10 ** (THRESHOLDS[shape] / 10)))
    expected = ratio.size * 1e-4
    assert abs(count - expected) < 5 * np.sqrt(expected)


def test_without_a_shape_texture_follows_grazing_and_cell() -> None:
    """Ward's shape at 0.5 to 0.7 km and at 6 to 9 km: <I^2>/<I>^2 - 2 = 2/nu, 5 sigma of K of the mean shape."""
    made = sea(APART)
    ratio = normalised(made, 24)
    width, length = cell_by_hand(made, made.radar.range_step)
    r = ((np.arange(made.radar.bins, dtype=np.float64) + 0.5) * made.radar.range_step)[25::3]
    nu = texture_shape(np.arcsin(15 / r) - r / (2 * EARTH), r * width * length, "h")
    for part in (slice(0, 4), slice(90, 140)):
        some = ratio[:, :, part]
        law = scipy.stats.gamma(nu[part].min(), scale=1 / nu[part].min())
        error = np.sqrt(24 * law.moment(4) / some.size)
        assert np.mean(some**2) == pytest.approx(np.mean(2 + 2 / nu[part]), abs=5 * error)


CLOSE = {"range_max_m": 3000, "bandwidth_hz": 10e6, "pulse_s": 4e-6, "azimuths": 240, "beamwidth_deg": 6}


def fields(made: rs.Scene, scans: int) -> NDArray[np.complex128]:
    """Fields (scans, A, n) over the root of their mean power, from 0.5 km on."""
    sim = rs.Simulator(made, seed=3)
    taken = [sim.scan() for _ in range(scans)]
    return np.stack([(s.field / np.sqrt(mean_by_hand(made, s)))[:, 50:] for s in taken])


def test_speckle_has_the_beams_and_the_pulses_correlation() -> None:
    """Shape 1000 is Rayleigh. Along azimuth: the overlap of the beam with itself shifted (by quadrature), times
    exp(-(t / 7 ms)^2) for the 4.2 ms from spoke to spoke, across north and from scan to scan as anywhere else. Along range: the
    pulse's. Both 5 sigma of the independent cells."""
    made = sea(CLOSE | {"rpm": 60}, 1000.0)
    field = fields(made, 4)
    sigma = 1 / np.sqrt(field.size / (7 * 2.5))  # 7 azimuths, 2.5 bins to an independent cell
    beam = made.radar.beamwidth

    def overlap(lag: float) -> float:
        x = np.linspace(-0.5, 0.5, 20_001)
        changed = np.exp(-((lag / (2 * np.pi) / (7e-3 * made.radar.wavelength / 0.032)) ** 2))  # one revolution a second
        return float(np.sum(sinc2_beam(x, beam) * sinc2_beam(x - lag, beam)) * changed)

    whole = field.reshape(-1, field.shape[2])
    for steps in (1, 2, 4, 6, 9):
        expected = overlap(steps * np.deg2rad(1.5)) / overlap(0.0)
        result = np.mean(whole[steps:] * np.conj(whole[:-steps]))
        assert abs(result - expected) < 5 * sigma
    seam = np.mean(field[1:, 0] * np.conj(field[:-1, -1]))
    assert abs(seam - overlap(np.deg2rad(1.5)) / overlap(0.0)) < 5 / np.sqrt(3 * field.shape[2] / 2.5)
    assert abs(np.mean(field[1:] * np.conj(field[:-1]))) < 5 * sigma  # new at every revolution
    delay = np.arange(-4000, 4001) / made.radar.sample_rate
    pulse = compressed_pulse(delay, 10e6, 4e-6, (0.54, 0.46))
    for lag in (1, 2, 3, 5):
        expected_range = np.sum(pulse[lag:] * np.conj(pulse[:-lag])) / np.sum(np.abs(pulse) ** 2)
        assert abs(np.mean(field[:, :, lag:] * np.conj(field[:, :, :-lag])) - expected_range) < 5 * sigma


def test_texture_lives_on_from_scan_to_scan_and_speckle_does_not() -> None:
    """At 60 rpm waves of sea state 6 (10.2 s) keep their place: powers of following scans correlate, fields do not."""
    made = sea(CLOSE | {"rpm": 60}, 0.5, sea_state=6)
    field = fields(made, 2)
    log_power = np.log(np.abs(field) ** 2)
    log_power -= log_power.mean()
    share = np.mean(log_power[0] * log_power[1]) / np.mean(log_power**2)
    far = fields(made, 25)[[0, 24]]
    log_far = np.log(np.abs(far) ** 2) - np.log(np.abs(far) ** 2).mean()
    assert share > 0.3  # 0.5 is texture's part of the variance of log power at this shape: psi'(0.5) of psi'(0.5) + psi'(1)
    assert abs(np.mean(log_far[0] * log_far[1]) / np.mean(log_far**2)) < 0.05


def test_no_clutter_unless_requested_nor_beyond_the_horizon_nor_under_the_antenna() -> None:
    assert rs.Simulator(scene([], radar=CLOSE)).scan().power.max() == 0.0
    far = rs.Simulator(sea({"range_max_m": 20_000, "bandwidth_hz": 1e6, "azimuths": 16, "beamwidth_deg": 40})).scan()
    assert (far.power[:, far.range > 15_964] == 0).all() and (far.power[:, far.range < 15] == 0).all()
    assert np.isfinite(far.power).all() and far.power.max() > 0


def test_no_sea_where_there_is_land() -> None:
    """A disc of land 800 m across, 600 m east: nothing on it nor behind it (a cell of its edge aside), sea before it."""
    land = {"name": "l", "shape": "cylinder", "radius_m": 400, "height_m": 30, "position_m": [1000, 0, 0], "rcs_dbsm": -99}
    radar = CLOSE | {"beamwidth_deg": 2, "azimuths": 720}
    power = rs.Simulator(scene([land], radar=radar, environment={"sea_state": 4})).scan()
    east = power.power[180]
    assert (east[power.range > 612] < 1e-9 * east[power.range < 590].max()).all()
    assert np.median(east[(power.range > 400) & (power.range < 590)]) > 0


def test_rain_power_is_the_radar_equation_of_its_volume() -> None:
    """Pt G^2 lambda^2 eta V L / ((4 pi)^3 R^4), V = R^2 x two-way beam in both planes (by quadrature) x length; eta 5.077e-7
    at 4 mm/h; loss 0.0556 dB/km one way (P.838). Exponential power, 5 sigma."""
    made = sea(APART | {"range_max_m": 6000}, sea_state=0, rain_mm_h=4)
    sim = rs.Simulator(made, seed=2)
    scans = [sim.scan() for _ in range(12)]
    r = scans[0].range
    width, length = cell_by_hand(made, scans[0].range_step)
    floor = -np.arcsin(np.minimum(15 / r + r / 2 / EARTH, 1))
    top = np.arcsin(np.minimum(2985 / r, 1) - r / 2 / EARTH)

    def two_way(elevation: float) -> float:
        return float(sinc2_beam(np.array(elevation), made.radar.beamwidth_el)) ** 2

    height = np.array([quad(two_way, low, high, limit=200)[0] for low, high in zip(floor, top, strict=True)])
    loss = 10 ** (-0.2 * 0.0556 * r / 1000)
    mean = made.radar.power * 1e6 * WAVELENGTH**2 * 5.077e-7 * r**2 * width * height * length * loss
    mean /= (4 * np.pi) ** 3 * r**4
    ratio = np.stack([(s.power / mean)[:, 3::3] for s in scans])
    assert ratio.mean() == pytest.approx(1.0, abs=5 / np.sqrt(ratio.size) + 1e-3)  # 1e-3: printed digits of eta and loss
    assert scipy.stats.kstest(ratio.ravel(), "expon").pvalue > LEVEL
    for part in np.array_split(ratio, 5, axis=2):
        assert part.mean() == pytest.approx(1.0, abs=5 / np.sqrt(part.size) + 1e-3)


SEEDS = 3  # 5 sigma are 16 % of the power; a part that is left out lacks half of it


def test_sea_and_rain_add_their_powers() -> None:
    both, only_sea, only_rain = (
        np.mean([rs.Simulator(sea(APART, 5.0, **e), seed=s).scan().power for s in range(SEEDS)], axis=0)
        for e in ({"rain_mm_h": 30}, {}, {"rain_mm_h": 30, "sea_state": 0})
    )  # fmt: skip
    made = sea(APART, 5.0)
    attenuation = 10 ** (-0.2 * 0.7625 * rs.Simulator(made).range / 1000)  # P.838 at 30 mm/h, H
    for part in (slice(30, 100), slice(200, 400)):
        total = (only_sea * attenuation + only_rain)[:, part].sum()
        assert both[:, part].sum() / total == pytest.approx(1.0, abs=5 * np.sqrt(2 * 1.4 / (SEEDS * 45 * 20)))


def test_clutter_below_the_noise_is_left_out() -> None:
    """With noise 30 dB too strong for any clutter the profiles are those of noise alone, bit for bit."""
    quiet = {"range_max_m": 1200, "azimuths": 16, "beamwidth_deg": 40, "power_w": 1e-9}
    with_sea = rs.Simulator(sea(quiet, noise=True)).scan()
    alone = rs.Simulator(scene([], radar=quiet, environment={"noise": True})).scan()
    np.testing.assert_array_equal(with_sea.field, alone.field)


@pytest.mark.parametrize("pulse", [{"pulse_s": 4e-6}, {"modulation": "none", "pulse_s": 0.25e-6, "bandwidth_hz": None}])
@pytest.mark.parametrize("rain", [{}, {"sea_state": 0, "rain_mm_h": 20}], ids=["sea", "rain"])
def test_an_eclipsed_radar_receives_less_clutter(pulse: dict[str, Any], rain: dict[str, Any]) -> None:
    """One antenna: an echo that begins while the radar still sends loses that part; past c T / 2 nothing is lost."""
    radar = {key: value for key, value in (CLOSE | pulse).items() if value is not None}
    not_eclipsed, eclipsed = (
        rs.Simulator(sea(radar | {"eclipsing": e}, 1000.0, **rain), seed=1).scan() for e in (False, True)
    )
    past = not_eclipsed.range > 299_792_458 * radar["pulse_s"] / 2 + 60
    np.testing.assert_allclose(eclipsed.power[:, past], not_eclipsed.power[:, past], rtol=2e-3)
    near = (not_eclipsed.range > 16) & (not_eclipsed.range < 299_792_458 * radar["pulse_s"] / 8)
    if near.any():
        assert eclipsed.power[:, near].sum() < 0.5 * not_eclipsed.power[:, near].sum()


@pytest.mark.parametrize("range_max_m", [3000, 3077, 9000])
def test_clutter_ends_where_it_no_longer_matters(range_max_m: float) -> None:
    """At 10 mW the sea sinks below the noise within 1 km, at any bin of a cell; added to noise drawn alike it
    changes the near bins and none beyond the last at which the mean upwind, by hand, is 15 dB below the noise."""
    radar = {"range_max_m": range_max_m, "bandwidth_hz": 10e6, "pulse_s": 4e-6, "azimuths": 32, "beamwidth_deg": 20}
    made = sea(radar | {"power_w": 0.01}, noise=True)
    both = rs.Simulator(made, seed=1).scan()
    alone = rs.Simulator(scene([], radar=radar, environment={"noise": True}), seed=1).scan()
    changed = np.flatnonzero((both.field != alone.field).any(axis=0))
    mean = mean_by_hand(made, both).max(axis=0)
    mattering = np.flatnonzero(mean > rs.Simulator(made).noise_power * 10**-1.5)
    assert 0 < mattering[-1] < both.field.shape[1] - 20
    assert changed[-1] == pytest.approx(mattering[-1], abs=3)  # a cell of two bins


# clutter: rain clutter's physics by hand.
def test_reflectivity_by_hand() -> None:
    """4 mm/h: Z = 200 x 4^1.6 = 1837.9 mm^6/m^3 = 32.64 dBZ; eta = pi^5 x 0.93 x 1.8379e-15 / 0.0318589^4 = 5.077e-7/m."""
    assert reflectivity(4.0, 0.0318589) == pytest.approx(5.077e-7, rel=1e-3)  # four printed digits
    assert reflectivity(16.0, 0.0318589) / reflectivity(4.0, 0.0318589) == pytest.approx(4**1.6, rel=1e-12)
    assert reflectivity(0.0, 0.0318589) == 0.0
    with pytest.raises(ValueError, match="rain_mm_h: -1 is not allowed"):
        reflectivity(-1.0, 0.0318589)


def test_rain_reaches_from_the_sea_to_its_height() -> None:
    """With a gain of 1 everywhere it is the angle between the two; at 10 km on a flat earth asin(0.0015) + asin(0.2985); on
    the bent one both are seen lower by R/(2 ae); past the horizon the sea's edge, sqrt(2 h / ae) down, is the floor."""
    elevation = np.linspace(-np.pi / 2, np.pi / 2, 200_001)
    gain = np.ones_like(elevation)
    at = np.array([10_000.0, 30_000.0])
    flat = beam_height(at, 15.0, np.inf, elevation, gain)
    assert flat[0] == pytest.approx(np.arcsin(15 / 10_000) + np.arcsin((RAIN_HEIGHT - 15) / 10_000), abs=1e-8)
    bent = beam_height(at, 15.0, EARTH, elevation, gain)
    top = np.arcsin((RAIN_HEIGHT - 15) / 30_000 - 30_000 / (2 * EARTH))
    assert bent[1] == pytest.approx(top + np.sqrt(2 * 15 / EARTH), abs=1e-8)
    assert beam_height(np.array([400_000.0]), 15.0, EARTH, elevation, gain)[0] == 0.0  # all rain below the horizon


# effect: sea and rain as sources of a scene, in the open and behind a mast.
RADAR = {"azimuths": 90, "beamwidth_deg": 8, "range_max_m": 2000}
MAST = {"name": "mast", "bearing_deg": 20, "width_m": 1.0, "distance_m": 4}


def powers(environment: dict[str, Any], **radar: Any) -> dict[int, float]:
    """The power of all sources in the first tile [W]."""
    prepared = prepare(scene(radar=RADAR | radar, environment=environment), PRESETS["fast"], 0)
    fields = contributions(prepared, tile_azimuths(prepared, 0, 0)).added.fields
    return {number: float(power.sum()) for field in fields for number, power in field.powers().items()}


@pytest.mark.parametrize(
    ("environment", "sources"),
    [
        ({}, set()),
        ({"sea_state": 4}, {SEA}),
        ({"rain_mm_h": 4.0}, {RAIN}),
        ({"sea_state": 4, "rain_mm_h": 4.0}, {SEA, RAIN}),
    ],
)
def test_sea_and_rain_are_each_their_own_source(environment: dict[str, Any], sources: set[int]) -> None:
    open_air, behind = powers(environment), powers(environment, structure=[MAST])
    assert {number for number, power in open_air.items() if power > 0.0} == sources
    assert all(0.0 < behind[number] < 0.9 * open_air[number] for number in sources)


# stage: what clutter adds to tiles, and its lines of the plan.
def test_clutter_below_its_floor_adds_nothing() -> None:
    made = scene(radar=RADAR | {"power_w": 1e-12}, environment={"noise": True, "sea_state": 1})
    prepared = prepare(made, PRESETS["fast"], 0)
    assert clutter_of(prepared) is None and not contributions(prepared, tile_azimuths(prepared, 0, 0)).added


def test_the_specification_names_only_clutter_that_is_requested() -> None:
    def lines(name: str, **environment: Any) -> dict[str, bool]:
        made: rs.Scene = scene(environment=environment)
        return {item.what: item.modelled for item in ClutterStage.plan(made, PRESETS[name], None)}

    assert lines("balanced", rain_mm_h=4.0) == {"sea clutter": False, "rain clutter": True}
    assert lines("documented", rain_mm_h=4.0) == {"rain clutter": True} and lines("documented") == {}


def test_the_plan_says_where_the_texture_is_extrapolated_and_that_waves_show() -> None:
    def how(**keys: Any) -> str:
        made = scene(radar=RADAR, environment={"sea_state": 3, **keys})
        return next(iter(ClutterStage.plan(made, PRESETS["balanced"], None))).how

    assert "(Ward), extrapolated to cells 1.58 to 210 m across (measured: 100 to 800 m)" in how() and "waves" not in how()
    assert "shape 4, in the rows of the waves that move ships" in how(seaway=True, sea_texture_shape=4)


# sea_clutter: the texture of a sea with waves: the slope of the waves that move ships, of unit variance in the beam, everywhere.
WAVE_RADAR = {"range_max_m": 2500, "azimuths": 360, "beamwidth_deg": 1.5, "rpm": 24, "height_m": 15}


def sea_of(seed: int = 0, spread: float = 1.0, **own_ship: Any) -> Sea:
    environment = {"sea_state": 4, "seaway": {"seed": seed, "spread": spread, "from_deg": 40}}
    made = scene([], radar=WAVE_RADAR, environment=environment, own_ship=own_ship)
    clutter = prepare_clutter(made, OcclusionScene((), effective_earth_radius(4 / 3)), compression_for(made.radar, 6), 1, 1)
    assert clutter is not None and clutter.sea is not None
    return clutter.sea


def gaussian(sea: Sea, number: NDArray[np.int64]) -> NDArray[np.float32]:
    first, stop, weights = sea.texture_beam.at(number)
    return weight_rows(weights, sea.texture.span(first, stop))


@pytest.mark.parametrize("scan", [0, 3])
def test_rows_are_the_slope_of_the_waves_that_move_ships(scan: int) -> None:
    """Along one line 600 to 1100 m off, upwind, at the row's time: the texture has the correlation 0.9 or more with the slope of
    the elevation that lifts ships, averaged over the 3.7 m of the cell; without the beam, and for own ship under way."""
    sea = sea_of(speed_kn=10, course_deg=90)
    row = round(40 / 360 * sea.texture.rows_per_scan)
    line = sea.texture.span(scan * sea.texture.rows_per_scan + row, scan * sea.texture.rows_per_scan + row + 1)[0]
    time, bearing = 2.5 * (scan + row / sea.texture.rows_per_scan), row * 2 * np.pi / sea.texture.rows_per_scan
    step = sea.column_bins * 299_792_458 / 150e6
    far = np.arange(600.0, 1100.0, step)
    made = scene([], environment={"sea_state": 4, "seaway": {"from_deg": 40}})
    assert made.environment.seaway is not None
    waves = drawn_waves(made.environment.seaway)
    line_of_sight = np.array([np.sin(bearing), np.cos(bearing)])
    place = np.array([10 * 1852 / 3600 * time, 0.0]) + far[:, None] * line_of_sight
    higher = waves.elevation(place + 0.5 * line_of_sight, np.full(len(far), time))
    slope = higher - waves.elevation(place - 0.5 * line_of_sight, np.full(len(far), time))
    seen = np.interp(far, (np.arange(len(line)) + 0.5) * step, line)
    assert np.corrcoef(seen, slope)[0, 1] > 0.9


def test_the_beams_sum_has_unit_variance_at_every_range_and_bearing() -> None:
    """Over 6 seas: 5 sigma of their independent draws, sqrt(2 / 60), for means over a third of the range and 10 bearings; 0.05
    for the table."""
    number = np.arange(0, 360, 36)
    seas = [sea_of(seed) for seed in range(1, 7)]
    drawn = np.stack([np.concatenate([gaussian(sea, number[k : k + 1]) for k in range(10)]) for sea in seas])
    for third in np.array_split(drawn, 3, axis=2):
        assert np.mean(third.astype(np.float64) ** 2) == pytest.approx(1.0, abs=0.15)


# azimuth_rows: rows over the turn: the same however they are asked for, and weighted as the beam is.
def numbered(turn: int) -> AzimuthRowCache:
    """Rows that hold their own number, counted from the start."""
    return AzimuthRowCache(turn, lambda scan, start, stop: (scan * turn + np.arange(start, stop, dtype=np.float64))[:, None])


@pytest.mark.parametrize("turn", [4, 16, 37, 64, 200, 2 * CHUNK + 5])
def test_any_span_is_there_across_north_and_before_the_start(turn: int) -> None:
    rows = numbered(turn)
    for first in (-3, 0, 5, turn - 1, turn, 3 * turn - 2):
        for count in (1, 7, 2 * turn + 1):
            np.testing.assert_array_equal(rows.span(first, first + count)[:, 0], np.arange(first, first + count))


def test_blocks_are_computed_once_while_they_are_in_use_and_never_cross_north() -> None:
    requested = []

    def make(scan: int, start: int, stop: int) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
        requested.append((scan, start, stop))
        return np.zeros((stop - start, 1))

    half = BLOCK // 2
    rows = AzimuthRowCache(5 * half, make)
    for first in range(0, 50 * half + 1, half):
        rows.span(first, first + 2 * half + half // 2)
    blocks = [(scan, start, min(start + BLOCK, 5 * half)) for scan in range(11) for start in (0, BLOCK, 2 * BLOCK)]
    assert requested == blocks[: len(requested)]
    assert len(requested) == 32  # the last row is in the 32nd block


def test_weights_are_the_pattern_within_reach() -> None:
    """Rows 10 degrees apart, boresights 358 and 361 degrees, reach 25: rows 34 to 38, each weighted by its offset."""
    first, stop, weight = beam_weights(np.deg2rad([358.0, 361.0]), 36, lambda x: 1.0 - np.abs(x), np.deg2rad(25.0))
    assert (first, stop) == (34, 39)
    offset = np.deg2rad([[18, 8, -2, -12, -22], [21, 11, 1, -9, -19]])
    np.testing.assert_allclose(weight, 1.0 - np.abs(offset), rtol=1e-12)
    _, _, cut = beam_weights(np.deg2rad([0.0, 10.0]), 36, np.ones_like, np.deg2rad(10.0))
    np.testing.assert_array_equal(cut, [[1, 1, 1, 0], [0, 1, 1, 1]])


def test_rows_are_made_anew_after_a_change() -> None:
    level, revision = [1.0], Revision()
    rows = AzimuthRowCache(8, lambda scan, start, stop: np.full((stop - start, 1), level[0]), revision=revision)
    assert rows.span(0, 4).tolist() == [[1.0]] * 4
    level[0] = 2.0
    assert rows.span(0, 4).tolist() == [[1.0]] * 4
    revision.change()
    assert rows.span(0, 4).tolist() == [[2.0]] * 4


# sea: sea clutter's physics against printed values and by hand.
# Reference values of the NRL 2012 model at 9.41 GHz by sea state 0 to 6 [dB], printed to two places (origin: computed from
# the report's coefficients by an independent program and confirmed against a public implementation).
TABLE = {
    ("h", 1.0): (-66.48, -56.55, -49.38, -43.74, -39.12, -35.25, -31.98),
    ("h", 0.3): (-72.24, -61.97, -54.52, -48.63, -43.81, -39.77, -36.35),
    ("v", 1.0): (-60.71, -52.36, -46.33, -41.58, -37.69, -34.44, -31.68),
}


@pytest.mark.parametrize(("polarization", "grazing_deg"), TABLE)
def test_sigma0_is_the_table_to_the_printed_digit(polarization: str, grazing_deg: float) -> None:
    grazing = np.deg2rad(np.array([grazing_deg]))
    for sea_state, printed in enumerate(TABLE[polarization, grazing_deg]):
        level_db = 10 * np.log10(mean_sigma0(grazing, 9.41e9, sea_state, polarization)[0])
        assert round(float(level_db), 2) == printed


def test_sigma0_ends_at_the_horizon_and_holds_beyond_its_fit() -> None:
    """No sea at or below the horizon; steeper than 60 degrees as 60, higher than sea state 6 as 6."""
    at = np.deg2rad([-1.0, 0.0, 60.0, 90.0])
    sigma0 = mean_sigma0(at, 9.41e9, 6, "v")
    assert sigma0[0] == sigma0[1] == 0.0
    assert sigma0[2] == pytest.approx(sigma0[3], rel=1e-12)
    np.testing.assert_array_equal(mean_sigma0(at, 9.41e9, 9, "v"), sigma0)
    assert np.all(np.isfinite(mean_sigma0(np.array([1e-9, 1e-300]), 9.41e9, 3, "h")))
    with pytest.raises(ValueError, match='polarization: "x" is not one of h, v'):
        mean_sigma0(np.ones(1), 9.41e9, 3, "x")


@pytest.mark.parametrize("frequency", [3.05e9, 9.41e9, 16e9])
def test_wind_factor_is_a_mean_of_one_strongest_upwind(frequency: float) -> None:
    """Mean over directions 1 to rounding (a periodic mean is exact); X band by hand at grazing 0: a = 0.2 x
    (0.03186 + 0.015)^-0.4 = 0.6802, I0(a) = 1.1191, so upwind +2.465 dB and downwind 20 a log10(e) = 5.908 dB below that."""
    angle = np.arange(64, dtype=np.float64) * (2 * np.pi / 64)
    factor = wind_factor(angle, np.deg2rad(np.array(0.5)), 299_792_458 / frequency)
    assert factor.mean() == pytest.approx(1.0, abs=1e-12)
    assert np.argmax(factor) == 0 and np.argmin(factor) == 32
    if frequency == 9.41e9:
        up, down = 10 * np.log10(wind_factor(np.array([0.0, np.pi]), np.array(0.0), 0.0318589))
        assert up == pytest.approx(2.465, abs=5e-3) and up - down == pytest.approx(
            5.908, abs=5e-3
        )  # half a printed digit x 10


def test_texture_shape_by_hand() -> None:
    """1 degree, 100 m^2: log10 nu = 5/8 x 2 - 2.09 = -0.84 (H) or -0.14 (V); 8 degrees add 2/3 log10 8 = 0.602."""
    one, eight = np.deg2rad([1.0]), np.deg2rad([8.0])
    area = np.array([100.0])
    assert np.log10(texture_shape(one, area, "h")[0]) == pytest.approx(-0.84, abs=1e-12)
    assert np.log10(texture_shape(one, area, "v")[0]) == pytest.approx(-0.14, abs=1e-12)
    assert np.log10(texture_shape(eight, area, "v")[0]) == pytest.approx(0.462060, abs=1e-6)
    assert texture_shape(np.array([-0.1, 1.5]), np.array([0.0, 1e9]), "h").tolist() == list(SHAPE_LIMITS)


def test_waves_along_the_line_of_sight_make_spikes() -> None:
    """Ward's swell term: log10 nu - 1/3 along the waves, either way, and + 1/3 across them."""
    assert np.log10(swell_factor(np.array([0.0, np.pi / 2, np.pi]))) == pytest.approx([-1 / 3, 1 / 3, -1 / 3], abs=1e-12)


def test_shapes_beyond_their_measured_cells_are_told() -> None:
    """Ward's cells are 4.2 m long, and 100 to 800 m across."""
    assert beyond_measured_shapes(4.2, (100.0, 800.0)) == ""
    told = beyond_measured_shapes(12.0, (0.2, 131.0))
    assert told == ", extrapolated to cells 12 m long (measured: 4.2 m), 0.2 to 131 m across (measured: 100 to 800 m)"


def test_texture_length_and_life_by_hand() -> None:
    """Sea state 3, wind 3.16 x 3^0.8 = 7.610 m/s: (pi/2) 57.91/9.80665 = 9.276 m across the wind and twice that along it; waves
    of 48 m and 5.56 s: 7.610/0.877 = 8.677 m/s, 2 pi 8.677/9.80665."""
    assert texture_length(np.array([0.0, np.pi / 2, np.pi]), 3) == pytest.approx([18.552, 9.276, 18.552], abs=1e-3)
    assert peak_wave_period(3) == pytest.approx(5.560, abs=1e-3)


# resolution_cell: the share that one antenna receives; the cell itself is held by `test_mean_power_by_hand_at_every_range`.
HAMMING = (0.54, 0.46)


def test_the_received_share_is_the_energy_of_the_truncated_echo() -> None:
    """The closed form of an echo whose first T - 2R/c is eclipsed; 1.5 %: 64 ranges are interpolated, and sidelobes before
    range 0 are missing. Beyond c T / 2 the share is 1."""
    made = scene(radar={"pulse_s": 4e-6, "range_max_m": 1200, "eclipsing": True})
    share = received_share(made, compression_for(made.radar, 6))
    delays = np.arange(-2000, 2001) / made.radar.sample_rate
    whole = np.sum(np.abs(compressed_pulse(delays, made.radar.bandwidth, 4e-6, HAMMING)) ** 2)
    for column in (30, 75, 150, 200, 260):
        late = (column + 0.5) / made.radar.sample_rate
        received = compressed_pulse(delays, made.radar.bandwidth, 4e-6, HAMMING, 2e-6 - late)
        assert share[column] == pytest.approx(np.sum(np.abs(received) ** 2) / whole, abs=0.015)
    assert (share[303:] == 1.0).all() and share[0] < 1e-3
