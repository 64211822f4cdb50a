"""The truth of false echoes against what is received, and by hand."""

import json

import numpy as np
import pytest

import radar_service as rs
from radar_service.radar_feed import crossing_from_line
from radar_service.stages.structures.stage import StructureTruth
from tests.scenes import point, scene

RADAR = {
    "azimuths": 512,
    "beamwidth_deg": 2.0,
    "range_max_m": 1500,
    "pattern": "cosine2",
    "pulse_s": 2e-7,
    "bandwidth_hz": 30e6,
}
FUNNEL = {"name": "funnel", "bearing_deg": 0, "distance_m": 6, "width_m": 1.0}
MULTIPLE = {"own_rcs_dbsm": 40, "range_m": 600, "orders": 3}


def test_an_echo_of_a_ship_astern_stands_ahead_by_twice_the_way_to_the_funnel() -> None:
    """180 degrees off the funnel: farther by twice 5.5 m, in its bearing; level by the power of the tube, -33 dB two ways."""
    made = scene([point("t", 0, -800)], radar=RADAR | {"structure": [FUNNEL]}, own_ship={"heading_deg": 0})
    truth = StructureTruth(made)
    (echo,) = truth.false_echoes(0, 800.0, np.pi, 0.0)
    assert (echo.kind, echo.by, echo.range) == ("indirect", "funnel", pytest.approx(811.0, abs=0.01))
    assert echo.bearing == pytest.approx(0.0, abs=1e-6) or echo.bearing == pytest.approx(2 * np.pi, abs=1e-6)
    assert truth.false_echoes(0, 800.0, 0.1, 0.0) == []  # ahead it is behind the funnel


def test_what_the_truth_says_is_received() -> None:
    """Peaks of the cells labelled as indirect and as multiple: range within a cell, bearing within a beam, level within 1 dB."""
    body = point("t", -290, -390, rcs_dbsm=60.0)
    radar = RADAR | {"structure": [FUNNEL], "multiple_echoes": MULTIPLE}
    sim = rs.Simulator(scene([body], radar=radar, own_ship={"speed_kn": 8, "course_deg": 20}), "balanced", labels=True)
    scan, (crossing,) = sim.scan(), sim.crossings(0)
    assert crossing.false_echoes is not None and scan.labels is not None
    assert [echo.kind for echo in crossing.false_echoes] == [
        "indirect",
        "multiple",
        "multiple",
    ]  # the fourth trace is too far
    direct = scan.power[scan.labels == 256].max()
    step = sim.scene.radar.range_step
    for label, echo in zip((7, 8, 8), crossing.false_echoes, strict=True):
        column = round(echo.range / step - 0.5)
        window = np.where(scan.labels == label, scan.power, 0.0)[:, column - 6 : column + 7]
        row, peak = np.unravel_index(int(window.argmax()), window.shape)
        assert abs((peak + column - 6 + 0.5) * step - echo.range) < 1.5 * step
        off = (row * 2 * np.pi / 512 - echo.bearing + np.pi) % (2 * np.pi) - np.pi
        assert abs(np.degrees(off)) < 3.0
        assert 10 * np.log10(window.max() / direct) == pytest.approx(echo.level_db, abs=1.0)
    assert crossing_from_line(json.loads(json.dumps(crossing.as_dict()))) == crossing


def test_scenes_without_them_have_no_keys() -> None:
    sim = rs.Simulator(scene([point("t", 0, 500)], radar=RADAR), "fast")
    assert not {"false_echoes", "structure_db"} & sim.crossings(0)[0].as_dict().keys()
