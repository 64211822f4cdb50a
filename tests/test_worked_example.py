"""Section 8.1 of the specification: one target at 200 m and 45 degrees, 200 MSPS, each intermediate as printed and right."""

import numpy as np
import pytest

from radar_service.engine.documented import DocumentedEngine
from radar_service.numerics.constants import SPEED_OF_LIGHT
from radar_service.propagation.multipath import wavelength
from radar_service.radar.patterns import PATTERNS, printed_gain, printed_two_way
from radar_service.receive.chirp_sum import printed_phase, sample_delay
from radar_service.records.fidelity import PRESETS
from radar_service.scene_file.load import load_scene

RANGE, RATE, FREQUENCY = 200.0, 200e6, 9.41e9
DEGREE, BEAM = np.deg2rad(1.0), np.deg2rad(3.9)
PRINTED_LIGHT = 3e8  # m/s, the value of the example


@pytest.fixture(scope="module")
def chain() -> DocumentedEngine:
    position = [RANGE * np.sin(np.pi / 4), RANGE * np.cos(np.pi / 4), 10.0]
    return DocumentedEngine(
        load_scene(
            {
                "radar": {"sample_rate_hz": RATE, "range_max_m": 400, "height_m": 10, "rays": 1},
                "body": [{"name": "target", "shape": "point", "rcs_dbsm": 0, "position_m": position}],
            }
        ),
        PRESETS["documented"],
        seed=0,
    )


def test_step_1_delay() -> None:
    assert 2 * RANGE / PRINTED_LIGHT == pytest.approx(1.33e-6, abs=5e-9)  # printed 1.33 us, half the last digit
    assert 2 * RANGE / SPEED_OF_LIGHT * RATE == pytest.approx(266.85, abs=5e-3)  # right: between two samples
    assert sample_delay(np.array([RANGE]), RATE).tolist() == [267]  # printed 267


def test_step_2_phase() -> None:
    right = printed_phase(RANGE, wavelength(FREQUENCY))
    assert right == pytest.approx(78_888, abs=0.5)  # docs/specification.md, errata row 10, half the last digit
    assert right / (2 * np.pi) == pytest.approx(12_555.35, abs=5e-3)
    with_printed_light = printed_phase(RANGE, PRINTED_LIGHT / FREQUENCY)
    assert with_printed_light == pytest.approx(78_833, abs=0.6)  # what the printed formula and numbers give
    assert 78_873 / (2 * np.pi) == pytest.approx(12_553, abs=0.5)  # the printed pair agrees with itself only


def test_step_3_gain_one_degree_off() -> None:
    assert PATTERNS["sinc2"].gain(DEGREE, BEAM) == pytest.approx(0.841, abs=5e-4)  # right
    assert printed_gain(DEGREE, BEAM) == pytest.approx(0.122, abs=5e-4)  # the printed formula, where 0.67 is printed


def test_step_4_two_way() -> None:
    assert 0.67**4 == pytest.approx(0.20, abs=5e-3)  # printed, from the printed 0.67: also not the square that eq. 3 says
    assert printed_two_way(DEGREE, 0.0, BEAM, np.deg2rad(25)) == pytest.approx(0.0149, abs=5e-5)  # eq. 3 on eq. 2
    assert PATTERNS["sinc2"].gain(DEGREE, BEAM) ** 2 == pytest.approx(0.708, abs=5e-4)  # right, in power: -1.5 dB


def test_step_5_range_bin(chain: DocumentedEngine) -> None:
    power = chain.scan(0)[1]
    assert int(np.argmax(power[90])) == 267
    assert chain.range[267] == pytest.approx(200.11, abs=5e-3)  # printed 267 x 0.75 m = 200.25 m "about 200 m"
    assert chain.range[1] == pytest.approx(0.7495, abs=5e-5)


def test_step_6_azimuth_bin(chain: DocumentedEngine) -> None:
    power = chain.scan(0)[1]
    assert int(np.argmax(power[:, 267])) == 90  # printed: 45 / 0.5 = 90th, counted from 0


def test_the_whole_flow_carries_the_intermediates(chain: DocumentedEngine) -> None:
    boresight, one_degree_on = (chain.azimuth_field(0, index)[267] for index in (90, 92))
    assert np.abs(boresight) == pytest.approx(1 / (RANGE**2 + 1), rel=1e-6)  # eq. 8 on boresight; complex64
    assert np.abs(one_degree_on) / np.abs(boresight) == pytest.approx(0.0149, abs=5e-5)  # step 4 on the amplitude
    turns = printed_phase(RANGE, wavelength(FREQUENCY)) / (2 * np.pi)
    assert np.angle(boresight) / (2 * np.pi) % 1 == pytest.approx(turns % 1, abs=1e-6)  # complex64
