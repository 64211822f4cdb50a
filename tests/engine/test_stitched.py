"""Several pulses by range: each part of a profile is that of a radar with this pulse alone, at the noise of the last pulse."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.engine.pipeline import Engine
from radar_service.engine.preparation import Prepared, prepare
from radar_service.engine.stitched import StitchedEngine, near_seed, pulse_gain, pulse_scenes
from radar_service.records.fidelity import PRESETS
from radar_service.sources.labels import LabellingEngine, LabellingStitchedEngine
from radar_service.world.body import MATERIALS
from tests.alone import clutter_of
from tests.scenes import point, scene

SHORT: dict[str, Any] = {"modulation": "none", "pulse_s": 8e-8, "bandwidth_hz": 15e6}
MIDDLE: dict[str, Any] = {"pulse_s": 1e-6, "bandwidth_hz": 20e6, "window": "taylor"}
FILTER = {"modulation": "nlfm", "window": "nuttall", "compression": "inverse"}
LONG: dict[str, Any] = {**FILTER, "pulse_s": 4e-6, "bandwidth_hz": 20e6}
REST: dict[str, Any] = {
    "azimuths": 64, "beamwidth_deg": 8, "range_max_m": 1500, "eclipsing": True, "prf_hz": 20_000, "second_time_around": True,
    "height_m": 30,
}  # fmt: skip
RATE = 30e6  # of all pulses: 1.5 times the widest band
SHIP = {"name": "ship", "shape": "hull", "length_m": 60, "beam_m": 12, "height_m": 14, "position_m": [-200, 610, 0]}
BODIES = [
    point("near", 150, 100), point("at the first seam", 0, 240, 10), point("far", 0, 1200, swerling=1),
    point("beyond", 0, 8100, 30, 60), {**SHIP, "material": "wood", "speed_kn": 10, "course_deg": 20},
    {**SHIP, "name": "quay", "material": "concrete", "position_m": [400, 0, 0]},
]  # fmt: skip


def stitched(environment: dict[str, Any], **radar: Any) -> rs.Scene:
    """The bodies as a radar with all three pulses has them."""
    pulses = [{**SHORT, "range_max_m": 240}, {**MIDDLE, "range_max_m": 640}, LONG]
    return scene(BODIES, radar={**REST, "pulses": pulses, **radar}, environment=environment)


def alone(pulse: dict[str, Any], end: float, environment: dict[str, Any], labels: bool = False) -> rs.Simulator:
    """A radar with one of the pulses alone, out to the end of its ranges."""
    radar = {**REST, **pulse, "sample_rate_hz": RATE, "range_max_m": end}
    return rs.Simulator(scene(BODIES, radar=radar, environment=environment), labels=labels)


@pytest.mark.parametrize("environment", [{}, {"multipath": True, "gas_db_per_km": 0.1}], ids=["free space", "over the sea"])
def test_each_part_is_that_of_a_radar_with_this_pulse_alone(environment: dict[str, Any]) -> None:
    """To the bit, with plain and chirped pulses, eclipsed echoes, second-time-around echoes, and bodies at rest and under way."""
    sim, singles = rs.Simulator(stitched(environment)), [alone(*pulse, environment) for pulse in
                                                         ((SHORT, 240), (MIDDLE, 640), (LONG, 1500))]  # fmt: skip
    for _ in range(2):
        whole, parts = sim.scan(), [single.scan() for single in singles]
        ends = [0, *(part.field.shape[1] for part in parts)]
        assert ends == [0, 49, 129, 301] and whole.field.shape[1] == 301
        for part, single, first, stop in zip(parts, singles, ends[:-1], ends[1:], strict=True):
            gain = np.float32(np.sqrt(sim.noise_power / single.noise_power))
            assert np.abs(part.field[:, first:stop]).max() > 0
            np.testing.assert_array_equal(whole.field[:, first:stop], gain * part.field[:, first:stop])
        np.testing.assert_array_equal(whole.power, whole.field.real**2 + whole.field.imag**2)
        np.testing.assert_array_equal(whole.range, parts[-1].range)
    assert sim.noise_power == singles[-1].noise_power


def test_the_last_part_has_the_noise_and_clutter_of_a_radar_with_this_pulse_alone() -> None:
    environment = {"noise": True, "sea_state": 4, "rain_mm_h": 4}
    made = scene(BODIES, radar={**REST, **LONG, "sample_rate_hz": RATE}, environment=environment)
    whole, last = (rs.Simulator(each, seed=7).scan() for each in (stitched(environment), made))
    np.testing.assert_array_equal(whole.field[:, 129:], last.field[:, 129:])


def test_noise_has_one_level_and_parts_are_independent() -> None:
    """1000 scans of 4 azimuths: a cell's mean scatters by 1/63, 5 sigma. Products of two cells in the first azimuth, where parts
    would begin with the same random numbers, scatter by 1/32; the largest of those of 49 x 252 pairs is below 5.5 sigma."""
    pulses = [{**SHORT, "range_max_m": 240}, LONG]
    sim = rs.Simulator(
        scene(radar={**REST, "azimuths": 4, "beamwidth_deg": 90, "pulses": pulses}, environment={"noise": True})
    )
    field = np.stack([sim.scan().field for _ in range(1000)]) / np.sqrt(sim.noise_power)
    assert np.abs((np.abs(field) ** 2).mean(axis=(0, 1)) - 1.0).max() < 5 / np.sqrt(4000)
    products = np.abs(field[:, 0, :49].T @ field[:, 0, 49:].conj()) / 1000
    assert products.max() < 5.5 / np.sqrt(1000)


@pytest.mark.parametrize("far", [1500, 20_000], ids=["equal tiles", "larger tiles of the short pulse"])
def test_sectors_and_threads_change_no_byte(far: float) -> None:
    """Profiles of 4003 bins are computed by 16 azimuths, shorter ones by 32."""
    radar = {"range_max_m": far, "second_time_around": False, "prf_hz": 2000}
    made = stitched({"noise": True, "sea_state": 3}, **radar)
    whole = rs.Simulator(made).scan().field
    np.testing.assert_array_equal(rs.Simulator(made, threads=3).scan().field, whole)
    part = rs.Simulator(made, sector=(1.8, 2.4)).scan().field
    inside = ~np.isnan(part[:, 0])
    assert 0 < inside.sum() < 20
    np.testing.assert_array_equal(part[inside], whole[inside])


def test_parts_in_tiles_of_other_azimuths_are_joined_by_azimuth() -> None:
    """Tiles of 5 and of 16 azimuths, all of them and those of a sector that begins and ends within tiles."""
    made = stitched({"noise": True})

    def prepared(scene: rs.Scene, noise_seed: int, tile: int = 5) -> Prepared:
        return replace(prepare(scene, PRESETS["balanced"], 0, noise_seed=noise_seed), tile=tile)

    near_ones = (prepared(near, near_seed(0, k)) for k, near in enumerate(pulse_scenes(made)))
    pulses = [*near_ones, prepared(made, 0, 16)]
    engine = StitchedEngine([Engine(pulse) for pulse in pulses])
    whole = np.concatenate([field for _, field, _ in engine.tiles(0)])
    assert whole.shape == (64, 301)
    for pulse, end in zip(pulses, (49, 129), strict=False):
        near = Engine(pulse)
        alone = np.concatenate([field for _, field, _ in near.tiles(0)])
        gain = np.float32(pulse_gain(near.prepared.scene.radar, made.radar))
        np.testing.assert_array_equal(whole[:, end - 40 : end], gain * alone[:, end - 40 : end])
    requested = np.zeros(64, dtype=np.bool_)
    requested[17:19] = True
    (start, field, power), *more = engine.tiles(0, requested)
    assert (start, more) == (16, [])
    np.testing.assert_array_equal(field, whole[16:32])
    np.testing.assert_array_equal(power, field.real**2 + field.imag**2)
    labelling = LabellingStitchedEngine([LabellingEngine(pulse) for pulse in pulses])
    labels = np.concatenate([labels for *_, labels in labelling.labelled_tiles(0)])
    for pulse, first, stop in zip(pulses, (0, 49, 129), (49, 129, 301), strict=True):
        alone = np.concatenate([labels for *_, labels in LabellingEngine(pulse).labelled_tiles(0)])
        np.testing.assert_array_equal(labels[:, first:stop], alone[:, first:stop])
    ((start, field, power, part),) = labelling.labelled_tiles(0, requested)
    np.testing.assert_array_equal(part, labels[16:32])
    np.testing.assert_array_equal(field, whole[16:32])


def test_labels_and_powers_of_each_part_are_those_of_a_radar_with_this_pulse_alone() -> None:
    """The mean of noise has one level everywhere; speckle of a near pulse is its own, so there is no sea."""
    environment = {"noise": True, "multipath": True}
    sim = rs.Simulator(stitched(environment), labels=True)
    whole, powers, plain = sim.scan(), sim.source_powers(), rs.Simulator(stitched(environment)).scan()
    np.testing.assert_array_equal(whole.field, plain.field)
    assert whole.labels is not None and {0, 4, 16 + list(MATERIALS).index("concrete"), 256, 260} <= set(
        np.unique(whole.labels)
    )
    for pulse, first, stop in ((SHORT, 0, 49), (MIDDLE, 49, 129), (LONG, 129, 301)):
        single = alone(pulse, {49: 240, 129: 640, 301: 1500}[stop], environment, labels=True)
        np.testing.assert_array_equal(whole.labels[:, first:stop], single.scan().labels[:, first:stop])
        gain, separate = np.float32(sim.noise_power / single.noise_power), single.source_powers()
        for number in powers.keys() | separate.keys():
            nothing = np.zeros(whole.labels.shape, dtype=np.float32)
            got, expected = powers.get(number, nothing), separate.get(number, nothing)
            np.testing.assert_allclose(got[:, first:stop], gain * expected[:, first:stop], rtol=1e-6, err_msg=str(number))


def test_speckle_of_a_near_pulse_is_its_own_and_the_sea_is_shared() -> None:
    made = stitched({"noise": True, "sea_state": 4})
    near, number = pulse_scenes(made), np.arange(8)
    assert [one.radar.bins for one in near] == [49, 129] and all(one.radar.near_pulses == () for one in near)
    seeds = 3, near_seed(3, 0), near_seed(3, 1)
    own = [clutter_of(prepare(near[0], PRESETS["balanced"], 3, noise_seed=seed)) for seed in seeds]
    speckle = [each.speckle.span(0, 8) for each in own if each is not None]
    assert len(speckle) == 3 and not any(np.allclose(speckle[a], speckle[b]) for a, b in ((0, 1), (0, 2), (1, 2)))
    sea = [each.sea.amplitude(number, each.sea.level(number), 40) for each in own if each is not None and each.sea]
    np.testing.assert_array_equal(sea[1:], [sea[0]] * 2)
