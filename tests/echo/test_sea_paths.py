"""Paths of echoes by the sea: images by hand, at rest and at each azimuth of a run."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import radar_service as rs
from radar_service.echo.echoes import AzimuthTimes, BeamWeightedEchoes
from radar_service.echo.sea_paths import MAX_RISE, Paths, SeaPaths, range_and_factor
from radar_service.engine import preparation
from radar_service.engine.preparation import Prepared, prepare
from radar_service.numerics.frames import polar_from_map
from radar_service.propagation.radar_equation import radar_two_rays
from radar_service.radar.parameters import Radar
from radar_service.records.fidelity import PRESETS
from radar_service.scattering.model import ALL_PATHS, BOTH_WAYS, DIRECT, ONE_WAY, BodyEchoes, Instant
from radar_service.scattering.scatterer_set import ScattererSet
from radar_service.trace import line_of_sight
from tests.reference.compressed_pulse import sinc2_beam
from tests.reference.reflecting_ground import factor, water
from tests.scenes import point, scene
from tests.test_motion import SWAY

Floats = NDArray[np.float64]
EARTH = 4 / 3 * 6_371_000.0
RADAR = {"azimuths": 720, "beamwidth_deg": 4, "beamwidth_el_deg": 20, "height_m": 15, "range_max_m": 3500}
PATHS = ((DIRECT, 1.0), (ONE_WAY, 2.0), (BOTH_WAYS, 1.0))  # the amplitudes of a small point by path


class OtherPaths:
    """The models of a set, with the echoes of points in other forms."""

    by_aspect = False

    def __init__(self, model: Any, height_span: float | None) -> None:
        self._model, self._span = model, height_span
        self.key, self.scatterers = model.key, model.scatterers

    def echoes(self, antenna: Floats, instant: Instant) -> BodyEchoes:
        """Each echo by its three paths, or as an extent."""
        whole = self._model.echoes(antenna, instant)
        if self._span is not None:
            return BodyEchoes(whole.position, whole.amplitude, whole.body, whole.path, np.full(len(whole), self._span))
        parts = [
            BodyEchoes(whole.position, amplitude * whole.amplitude, whole.body, np.full(len(whole), path), whole.height_span)
            for path, amplitude in PATHS
        ]
        joined = BodyEchoes.joined(parts)
        return joined.chosen(np.argsort(joined.body, kind="stable"))

    def clear(self) -> None:
        return


def prepared(made: rs.Scene, monkeypatch: pytest.MonkeyPatch, height_span: float | None = None) -> Prepared:
    """A scene whose echoes come in other forms: by three paths, or as extents."""
    original = preparation.build_scatterers

    def build(*given: Any) -> ScattererSet:
        built = original(*given)
        return ScattererSet(built.bodies, built.key, tuple(OtherPaths(model, height_span) for model in built.models))  # type: ignore[misc]

    with monkeypatch.context() as patch:
        patch.setattr(preparation, "build_scatterers", build)
        return prepare(made, PRESETS["balanced"], 3)


def image_factor(distance: float, height: float, antenna: float, radar: Radar, flat: bool) -> complex:
    """F of the plain reference, times the root of the direct gain."""
    earth = np.inf if flat else EARTH

    def gain(elevation: float) -> float:
        return float(sinc2_beam(np.array(elevation), radar.beamwidth_el))

    direct = gain(float(np.arctan2(height - distance**2 / (2 * earth) - antenna, distance)))
    return np.sqrt(direct) * factor(distance, height, antenna, [water(distance)], earth, gain=gain)


def block_on_the_point(made: rs.Scene, scan: int, size: int = 16) -> AzimuthTimes:
    """The azimuths of a scan of which the middle one looks at a point due east."""
    number = scan * made.radar.azimuths + made.radar.azimuths // 4 - size // 2 + np.arange(size)
    return AzimuthTimes(number, *made.radar.schedule(number))


@pytest.mark.parametrize(("earth", "late"), [("flat", 20_000), ("curved", 0)])
def test_sea_reflection_is_exact_at_each_azimuth_of_an_approach(earth: str, late: int) -> None:
    """A point 8 m high at 40 kn from 3 km to 80 m, 5 antenna heights, as `auto` plans it: in blocks of 32 to 0.9 km, then of 16.
    Against images by hand at every azimuth of 58 scans, among them many nulls: -50 dB of the greatest F^2, 4 (the
    permittivity has three digits: 1e-3 of F)."""
    speed = 40 * 1852 / 3600
    start = 3025.0 + speed * 2.5 * late
    own: dict[str, Any] = {"multipath": True, **({"earth": "flat"} if earth == "flat" else {})}
    made = scene([point("t", start, 0, 8.0, course_deg=270, speed_kn=40)], radar=RADAR, environment=own)
    sim = rs.Simulator(made)
    assert sim.fidelity.azimuths_per_block == 16
    moving = prepare(made, sim.fidelity, 0).moving
    radar, worst, nulls, sizes = made.radar, 0.0, 0, []
    constant = np.sqrt(radar.power * radar.gain**2 * radar.wavelength**2 * 10.0 / (4 * np.pi) ** 3)
    for scan in range(late, late + 58):
        azimuths = block_on_the_point(made, scan, 32)
        sizes.append(moving.block_size(azimuths, 16))
        azimuths = azimuths if sizes[-1] == 32 else block_on_the_point(made, scan)
        echoes = moving.echoes(azimuths)
        assert len(echoes.range) == 1
        for k, time in enumerate(azimuths.time):
            distance = start - speed * float(time)
            drop = 0.0 if earth == "flat" else distance**2 / (2 * EARTH)
            slant = np.hypot(distance, 8.0 - drop - 15.0)
            weight = sinc2_beam(azimuths.boresight[k] - np.pi / 2, radar.beamwidth)
            factor = image_factor(distance, 8.0, 15.0, radar, earth == "flat") ** 2
            free = constant / slant**2 * weight
            expected = free * factor * np.exp(-4j * np.pi / radar.wavelength * slant)
            worst = max(worst, abs(echoes.amplitude[0, k] - expected) / (4.0 * free))
            nulls += abs(factor) < 0.04
    assert worst < 10 ** (-50 / 20)
    assert nulls > 10 and set(sizes) == {16, 32}


@pytest.mark.sample(6)
@pytest.mark.parametrize("moving", [False, True], ids=["at rest", "under way"])
@pytest.mark.parametrize("sway", [False, True])
@pytest.mark.parametrize("distance", [40.0, 333.0, 2500.0])
def test_three_paths_of_a_point_are_the_square_of_two_rays(
    distance: float, moving: bool, sway: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Amplitudes a, 2a, a by three paths against F^2 at one range: the sum of their fields, once the excess of the ranges is
    taken as phase alone. 2e-3: gains by parabolas and single precision."""
    body = point("t", distance, 3.0, 8.0, **({"course_deg": 250, "speed_kn": 20} if moving else {}))
    own = {"heading_deg": 40, **SWAY} if sway else {}
    made = scene([body], radar=RADAR, own_ship=own, environment={"multipath": True})
    split, whole = prepared(made, monkeypatch), prepare(made, PRESETS["balanced"], 3)
    if not moving and not sway:
        levels = [np.sum(one.resting.echoes.amplitude) for one in (split, whole)]
        assert len(split.resting.echoes.range) == 3
        assert levels[0] == pytest.approx(levels[1], rel=1e-9)
        return
    one, other = (each.moving.echoes(block_on_the_point(made, 0)) for each in (split, whole))
    assert len(one.range) == 3 and len(other.range) == 1
    np.testing.assert_allclose(
        one.amplitude.sum(axis=0), other.amplitude[0], rtol=0, atol=2e-3 * np.abs(other.amplitude).max()
    )


def test_an_echo_by_the_sea_has_the_length_of_its_own_path(monkeypatch: pytest.MonkeyPatch) -> None:
    """Flat sea, 300 m: the image is 23 m below; ranges at each azimuth to the parabola's 5 um and float32."""
    body = point("t", 300.0, 0, 8.0, course_deg=270, speed_kn=20)
    made = scene([body], radar=RADAR, environment={"multipath": True, "earth": "flat"})
    azimuths = block_on_the_point(made, 2)
    echoes = prepared(made, monkeypatch).moving.echoes(azimuths)
    ground = 300.0 - 20 * 1852 / 3600 * azimuths.time
    direct, sea = np.hypot(ground, 7.0), np.hypot(ground, 23.0)
    for ranges, path in zip(_ranges(echoes), (0, 1, 2), strict=True):
        np.testing.assert_allclose(ranges, ((2 - path) * direct + path * sea) / 2, rtol=0, atol=2e-5)


def _ranges(echoes: BeamWeightedEchoes) -> Floats:
    ranges = echoes.range[:, None] + echoes.range_migration.astype(np.float64)
    return ranges[np.argsort(echoes.range)]


@pytest.mark.parametrize("distance", [200.0, 900.0])
def test_an_extent_has_the_mean_of_its_heights(distance: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """The root of the mean of |F|^4 over 6 m of height, from points there one by one, at rest and at each azimuth: 3 %, as the
    phase is not quite linear in height."""
    span = 6.0
    for motion in ({}, {"course_deg": 270, "speed_kn": 20}):
        made = scene([point("t", distance, 0, 8.0, **motion)], radar=RADAR, environment={"multipath": True})
        extended, radar = prepared(made, monkeypatch, span), made.radar
        azimuths = block_on_the_point(made, 2)
        ground = distance - 20 * 1852 / 3600 * azimuths.time if motion else np.array([distance])
        free = prepared(made.with_world(environment=scene().environment), monkeypatch, span)
        sets = [one.moving.echoes(azimuths) if motion else one.resting.echoes for one in (extended, free)]
        factor = np.abs(sets[0].amplitude / sets[1].amplitude).reshape(-1)
        for k, d in list(enumerate(ground))[::4]:
            heights = 8.0 + span * np.linspace(-0.5, 0.5, 301)
            level = abs(image_factor(float(d), 8.0, 15.0, radar, False))
            assert level > 0
            gain = float(sinc2_beam(np.arctan2(8.0 - d**2 / (2 * EARTH) - 15.0, d), radar.beamwidth_el))
            mean = np.mean([abs(image_factor(float(d), h, 15.0, radar, False)) ** 4 for h in heights])
            assert factor[k] == pytest.approx(np.sqrt(mean) / gain, rel=0.03)


def test_nothing_is_received_beyond_the_horizon() -> None:
    """15 and 8 m: 27.6 km."""
    made = scene(radar=RADAR, environment={"multipath": True})
    position = np.array([[27_000.0, 0.0, 8.0], [28_500.0, 0.0, 8.0]])
    polar = polar_from_map(position, np.array([0.0, 0.0, 15.0]), EARTH)
    paths = Paths(np.array([ALL_PATHS, ALL_PATHS]), np.zeros(2))
    _, factor = range_and_factor(made.radar, made.environment, polar, position[:, 2], np.float64(15.0), paths)
    assert abs(factor[0]) > 0 and factor[1] == 0


@pytest.mark.parametrize(("part", "rise", "counts"), [(1, 0.9, False), (1, 1.1, True), (2, 1.1, True)])
def test_a_diffracted_echo_rises_with_its_height_or_that_of_the_antenna(part: int, rise: float, counts: bool) -> None:
    made = scene(radar={**RADAR, "range_max_m": 50_000}, environment={"multipath": True, "diffraction": True})
    site = np.array([28_000.0]), np.array([2.0]), np.array([15.0])
    moved = [value * (1.0 + rise * MAX_RISE * (k == part)) for k, value in enumerate(site)]
    rays, paths = radar_two_rays(made.radar, made.environment, *site), Paths(np.array([ALL_PATHS]), np.zeros(1))
    assert SeaPaths(rays, paths, 200.0).rises([site, site, (moved[0], moved[1], moved[2])]).tolist() == [counts]


@pytest.mark.sample(6)
@pytest.mark.parametrize(
    "own",
    [
        {},
        {**SWAY, "heave_m": 1.5, "heave_period_s": 7},
        {"roll_deg": 5, "roll_period_s": 15},
        {"course_deg": 90, "speed_kn": 30},
    ],
    ids=["anchored", "heaving", "rolling", "under way"],
)
@pytest.mark.parametrize("distance", [9_000.0, 10_300.0, 15_000.0, 21_800.0, 28_000.0, 48_000.0])
def test_a_diffracted_echo_is_exact_at_each_azimuth(
    own: dict[str, Any], distance: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A point 2 m high before the joint, in it, this side of the horizon of 21.8 km, there, and beyond, at 40 kn. Its amplitudes
    over those of empty space are the square of the field at each azimuth's distance and height of the antenna (sway leans
    the mast): -50 dB, as in `test_sea_reflection_is_exact_at_each_azimuth_of_an_approach`."""
    body = point("t", distance, 0, 2.0, course_deg=270, speed_kn=40)
    over = {"radar": {**RADAR, "range_max_m": 50_000}, "own_ship": own}
    made = scene([body], **over, environment={"multipath": True, "diffraction": True})
    azimuths = block_on_the_point(made, 1)
    echoes = prepare(made, PRESETS["balanced"], 3).moving.echoes(azimuths)
    monkeypatch.setattr(line_of_sight, "beyond_horizon", lambda distance, *_: np.zeros(len(distance), dtype=np.bool_))
    plain = prepare(scene([body], **over), PRESETS["balanced"], 3).moving.echoes(azimuths)
    antenna = made.antenna(azimuths.time)
    ground = distance - 40 * 1852 / 3600 * azimuths.time - antenna[:, 0]
    polar = polar_from_map(np.stack([ground, -antenna[:, 1], np.full(16, 2.0)], axis=-1), np.array([0, 0, 15.0]), EARTH)
    assert plain.amplitude.shape == (1, 16)
    rays = radar_two_rays(made.radar, made.environment, polar.distance, np.full(16, 2.0), antenna[:, 2])
    field = 1.0 + rays.ratio * np.exp(-2j * np.pi / made.radar.wavelength * rays.geometry.excess)
    error = echoes.amplitude[0] / plain.amplitude[0] - field**2
    assert np.abs(error).max() < 10 ** (-50 / 20) * np.abs(field**2).max()
