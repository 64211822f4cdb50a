"""Beacons from scene files: units, defaults, and what `check` says of them."""

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

import radar_service as rs
from radar_service.scene_file.describe import describe
from radar_service.stages.beacons.beacon import S_BAND, X_BAND, Racon, Sart
from radar_service.stages.beacons.effect import RaconModel, SartModel
from tests.scenes import point, scene

LIGHT = 299_792_458.0


def beacon(**keys: Any) -> Any:
    return scene([point("b", 0, 3000, **keys)]).bodies[0].effects.get("beacon")


def test_a_racon_with_its_defaults() -> None:
    """K has 9 dots: of 3704 m (2 NM) each has 411.6 m, 2.746 us."""
    made = beacon(racon={"letter": "K"})
    assert isinstance(made, Racon) and made.letters == "K" and made.bands == (X_BAND, S_BAND) and made.sweep is None
    assert made.dot == pytest.approx(3704 / 9 * 2 / LIGHT) and made.power == pytest.approx(1.0)
    assert made.sensitivity == pytest.approx(1e-8) and made.delay == 0.5e-6 and made.offset == (0.0, 0.0, 0.0)
    assert made.max_pulse is None and made.active(np.arange(100.0)).all()


def test_keys_of_a_racon() -> None:
    made = beacon(racon={"letter": "MO", "band": "s", "mode": "sweep", "sweep_s": 90, "dot_s": 2e-6, "power_dbm": 27.0,
                         "on_s": 12.0, "off_s": 36.0, "offset_m": [1, 2, 3], "max_pulse_s": 2e-6})  # fmt: skip
    assert (made.bands, made.sweep, made.dot, made.offset) == ((S_BAND,), 90.0, 2e-6, (1.0, 2.0, 3.0))
    assert (made.on, made.off, made.max_pulse) == (12.0, 36.0, 2e-6) and made.power == pytest.approx(0.501, abs=0.001)


def test_a_sart() -> None:
    made = beacon(sart={"start_s": 30.0, "end_s": 60.0})
    assert (
        isinstance(made, Sart) and (made.start, made.end) == (30.0, 60.0) and made.power == pytest.approx(0.398, abs=0.001)
    )


def test_on_a_mesh_it_stands_above_the_highest_point() -> None:
    box = {"name": "b", "shape": "box", "length_m": 30, "width_m": 8, "height_m": 5, "racon": {"letter": "T"}}
    made = scene([box]).bodies[0].effects.get("beacon")
    assert made is not None and made.offset[2] == 5.5


@pytest.mark.parametrize(
    "keys, message",
    [
        ({"racon": {}}, "racon.letter"),
        ({"racon": {"letter": "k"}}, "racon.letter"),
        ({"racon": {"letter": "K", "mode": "sweep", "tuning_error_hz": 1e6}}, "tuning_error_hz: this key is of mode"),
        ({"racon": {"letter": "K", "sweep_s": 60}}, "sweep_s: this key is of mode"),
        ({"racon": {"letter": "K", "dot_s": 5e-5}}, "dot_s: 5e-05 makes an answer longer than 200 us; give at most 2.2e-05"),
        ({"racon": {"letter": "K", "dot_s": 1e-6, "mark_m": 500}}, "dot_s: mark_m defines it too"),
        ({"racon": {"letter": "K", "on_s": 5}}, "on_s: it is never silent"),
        ({"sart": {"start_s": 5, "end_s": 4}}, "end_s: 4 is not after start_s 5"),
        ({"sart": {}, "racon": {"letter": "K"}}, "sart: a body has one beacon"),
    ],
)
def test_keys_that_do_not_fit(keys: dict[str, Any], message: str) -> None:
    with pytest.raises(rs.SceneError, match=message.replace("(", r"\(")):
        beacon(**keys)


def test_what_check_says() -> None:
    """25 kW and 30 dBi reach -50 dBm 126.8 km away: 74 + 30 + 50 = 153.98 dB of free space."""
    bodies = [
        point("tower", 0, 3000, racon={"letter": "K", "off_s": 40.0}),
        point("raft", 0, 2000, sart={"max_pulse_s": 1e-7}),
    ]
    text = describe(scene(bodies))
    assert 'racon: "K", dots of 412 m, agile, 20 s on and 40 s off; triggered within 127 km in free space' in text
    assert "sart: not triggered by this radar" in text
    plan = str(rs.Simulator(scene(bodies)).plan)
    assert "1 racon, 1 sart: one-way powers" in plan and "not triggered by this radar's carrier or pulse: raft" in plan
    assert "beacons" not in str(rs.Simulator(scene([point("p", 0, 3000)])).plan)


def test_defaults() -> None:
    """A fifth of 10 NM, -50 dBm at the antenna, a SART's 400 mW (M.628)."""
    racon, sart = RaconModel(letter="K"), SartModel()
    assert racon.mark_m == 0.2 * 10 * 1852 and racon.sensitivity_dbm == sart.sensitivity_dbm == -50.0
    assert 10 ** (sart.power_dbm / 10) == pytest.approx(400, rel=0.01)


@pytest.mark.parametrize("keys", [{"letter": "K", "color": 1}, {"letter": "ABCD"}, {"letter": "K", "delay_s": -1e-9}])
def test_what_is_refused(keys: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        RaconModel.model_validate(keys)
