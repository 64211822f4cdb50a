"""The PPI behind the tracks of a report: echoes stand where they are."""

import json

import numpy as np

import radar_service as rs
from radar_service.bench.ppi_picture import SIZE, image_of, ppi_at, ppi_of
from radar_service.bench.run import simulator_of
from radar_service.bench.scenario import Scenario
from radar_service.display.ppi import image_position
from tests.bench.test_scenario import SMALL
from tests.scenes import point, scene

RADAR = {"azimuths": 180, "beamwidth_deg": 4, "range_max_m": 1500, "bandwidth_hz": 10e6}


def test_an_echo_stands_at_its_bearing_and_range() -> None:
    scan = rs.Simulator(scene([point("p", 600, -800)], radar=RADAR), "fast").scan()
    ppi = json.loads(json.dumps(ppi_of(scan), allow_nan=False))
    image = image_of(ppi)
    assert image.shape == (SIZE, SIZE) and image.max() == 1.0
    row, column = (index.mean() for index in np.nonzero(image == 1.0))
    expected = image_position(np.array(1000.0), np.arctan2(600.0, -800.0), SIZE, ppi["range"])
    assert (
        np.hypot(row - expected[0], column - expected[1]) * 2.0 * ppi["range"] / SIZE < 20.0
    )  # m; a spoke is 35 m wide there


def test_a_scan_without_echoes_is_black() -> None:
    scan = rs.Simulator(scene([point("p", 600, -800, start_s=1000.0)], radar=RADAR), "fast").scan()
    assert image_of(ppi_of(scan)).max() == 0.0


def test_a_later_scan_alone_is_that_of_the_run() -> None:
    simulator = simulator_of(Scenario(**SMALL), 2)
    scans = [ppi_of(simulator.scan()) for _ in range(3)]
    assert ppi_at(Scenario(**SMALL), 2, 2) == scans[2] != scans[1]
