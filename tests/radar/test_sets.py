"""Radar sets that are sold: the figures that are printed of them reach a scene's radar, and their limits are told."""

import tomllib

import numpy as np
import pytest

from radar_service.plots.thresholds import KnownThreshold
from radar_service.radar.parameters import Radar
from radar_service.radar.sets import TABLE, radar_sets
from radar_service.scene_file.load import load_scene
from radar_service.simulator import Simulator
from radar_service.world.error import SceneError

NM = 1852.0


def made(name: str, nautical: float | None = None, **keys: object) -> Radar:
    """The radar of a scene with a set at a scale [NM]."""
    scale = {} if nautical is None else {"range_max_m": nautical * NM}
    return load_scene({"radar": {"set": name, **scale, **keys}}).radar


@pytest.mark.parametrize("name", radar_sets())
def test_every_scale_of_every_set_is_a_valid_radar(name: str) -> None:
    for scale in radar_sets()[name].scales:
        radar = made(name, scale / NM)
        assert radar.range_max == scale and scale <= radar.bins * radar.range_step < scale * 1.1
        assert radar.scales == tuple(sorted(radar_sets()[name].scales))
    assert made(name).range_max == pytest.approx(6 * NM)


@pytest.mark.parametrize("name", radar_sets())
def test_each_number_of_a_set_has_a_source(name: str) -> None:
    table = tomllib.loads(TABLE.read_text(encoding="utf-8"))[name]
    numbers = {key for key, value in table.get("keys", {}).items() if not isinstance(value, bool | str)}
    told = {key for keys in table["sources"] for key in keys.split(", ")}
    assert numbers | {*table.get("columns", ["range_nm"])} <= told and all(table["sources"].values())


@pytest.mark.parametrize(
    ("name", "nautical", "pulse", "prf"),
    [
        ("furuno-1824c", 1.5, 80e-9, 2100), ("furuno-1824c", 2, 300e-9, 1200), ("furuno-1824c", 72, 800e-9, 600),
        ("furuno-far-2127", 2, 70e-9, 3000), ("furuno-far-2137s", 24, 500e-9, 1000), ("simrad-argus", 6, 250e-9, None),
        ("simrad-argus-boost", 6, 800e-9, None),
    ],
)  # fmt: skip
def test_pulse_and_its_rate_are_those_printed_of_a_scale(
    name: str, nautical: float, pulse: float, prf: float | None
) -> None:
    radar = made(name, nautical)
    assert (radar.pulse, radar.prf) == (pulse, prf)


def test_a_spoke_of_an_fmcw_dome_has_its_512_samples_on_every_scale() -> None:
    assert {made("navico-br24", scale / NM).bins for scale in radar_sets()["navico-br24"].scales} == {512}


def test_pulses_are_integrated_as_many_as_a_spoke_has() -> None:
    radar = made("furuno-far-2127", 6)
    assert radar.pulses_integrated == 1500 * 60 // (24 * 720)
    assert made("furuno-far-2127", 6, rpm=48).pulses_integrated == 2
    assert made("simrad-argus", 6).pulses_integrated == 1


def test_noise_of_a_scan_has_a_look_for_each_pulse_of_a_spoke_and_its_threshold_the_false_alarms() -> None:
    """Of 1.3 million cells, neighbours correlated."""
    scene = load_scene({"radar": {"set": "furuno-far-2127", "range_max_m": 24 * NM}, "environment": {"noise": True}})
    simulator = Simulator(scene, "fast")
    power = simulator.scan().power.astype(np.float64)
    assert power.mean() == pytest.approx(simulator.noise_power, rel=0.01)
    assert power.mean() ** 2 / power.var() == pytest.approx(scene.radar.pulses_integrated, rel=0.03)
    level = KnownThreshold(scene.radar, 1e-2).of(power.astype(np.float32))
    assert (power > level).mean() == pytest.approx(1e-2, rel=0.05)


def test_a_pulse_compression_set_sees_within_its_blind_range_by_a_short_pulse() -> None:
    near, last = made("humminbird-hb2124", 24).of_each_pulse
    assert near.range_max == pytest.approx(last.blind_range, rel=0.01) and near.pulse == 400e-9


def test_other_keys_replace_those_of_the_set() -> None:
    assert made("furuno-far-2127", power_w=12e3).power == 12e3


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"set": "furuno"}, r'radar\.set: "furuno" is not allowed; one of "furuno-1824c", .*; choose one of these'),
        ({"set": "simrad-argus", "range_max_m": 5000},
         r"radar\.range_max_m: 5000 m is no range scale .* 463, .* or remove set"),
        ({"set": "simrad-argus", "pulse_s": 1e-6}, r'radar\.pulse_s: 1e-06 beside set "simrad-argus", .*: remove one'),
        ({"integration": True}, r"radar\.integration: it needs a pulse repetition frequency; add prf_hz"),
    ],
)  # fmt: skip
def test_what_a_set_cannot_be_is_told(keys: dict[str, object], message: str) -> None:
    with pytest.raises(SceneError, match=message):
        load_scene({"radar": keys})


def test_a_range_between_scales_takes_the_next_longer_one() -> None:
    radar = made("furuno-1824c", 6)
    assert [radar.scale_for(d * NM) / NM for d in (0.01, 3, 3.02, 5, 200)] == pytest.approx([0.125, 3, 3, 6, 72])
    assert radar.longest_range == 72 * NM
