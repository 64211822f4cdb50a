"""A change of the rate of rotation: simulated time, positions and commands go on; scans are those of the new rate."""

import pytest

import radar_service as rs
from tests.scenes import everything, point, scene

RADAR = {"azimuths": 90, "beamwidth_deg": 6, "range_max_m": 900, "rpm": 40, "height_m": 12}


def steered(rpm: float = 40) -> rs.Scene:
    bodies = [point("a", 200, 300, steerable={"max_speed_kn": 40}), point("b", -150, -200, speed_kn=25, course_deg=0)]
    return scene(bodies, radar=RADAR | {"rpm": rpm}, own_ship={"steerable": {}}, environment={"noise": True})


def test_time_goes_on_with_the_first_scan_at_the_new_rate() -> None:
    sim = rs.Simulator(steered(), "fast", 1)
    *_, last = sim.spokes(3)
    for rpm, scan in ((25, 2), (80, 8)):  # from 4.5 s on: 2.4 s and 0.75 s a scan; from 7.2 s on the second time
        sim = sim.at_rpm(rpm)
        first, *_, last = sim.spokes(1)
        assert (first.scan, first.index, first.azimuth) == (scan if rpm == 25 else 10, 0, 0.0)
        assert first.time == first.scan * 60 / rpm >= 4.5
    assert last.time < sim.snapshot().time == pytest.approx(11 * 60 / 80)


def test_it_has_the_bytes_of_a_run_that_always_turned_at_that_rate() -> None:
    """Noise, clutter, fluctuation, aspects, shadows: nothing of the time before is left."""
    sim = rs.Simulator(everything(), "fast", 5)
    sim.scan()
    changed, scan = sim.at_rpm(31), round(31 / 60 * 60)
    assert changed.scan().field.tobytes() != sim.scan().field.tobytes()
    alone = rs.Simulator(everything(), "fast", 5).at_rpm(31)
    alone.skip_to(scan)
    changed.skip_to(scan)
    assert alone.scan().field.tobytes() == changed.scan().field.tobytes()


def test_a_sector_stays_a_sector() -> None:
    sim = rs.Simulator(steered(), "fast", 1, sector=(0.2, 0.4))
    assert [spoke.index for spoke in sim.at_rpm(25).spokes(1)] == [spoke.index for spoke in sim.spokes(1)]


def test_a_steered_run_goes_on_as_commanded() -> None:
    """The truth is that of a run at the old rate with the same commands; those to come act at their times."""
    sim = rs.Simulator(steered(), "fast", 1)
    sim.command("a", speed_kn=30, course_deg=40)
    sim.scan()
    sim.command(turn_rate_deg_s=-3, speed_kn=9)
    sim.command("a", time=2.9, position_m=[100, 100])
    sim.scan()
    slower = sim.at_rpm(25)
    assert [(command.time, command.spoke) for command in slower.commands] == [(0.0, 0), (1.5, 57), (2.9, 109)]
    later = slower.command("a", time=5.7, speed_kn=2)
    changed = slower.scan()
    sim.command("a", time=later.time, speed_kn=2)
    sim.scan()
    sim.scan()
    for time in (1.0, 2.0, 2.95, 3.5, 5.9):
        assert slower.truth(time) == sim.truth(time)
    sim = rs.Simulator(steered(25), "fast", 1)
    sim.replay(slower.commands)
    sim.skip_to(changed.number)
    assert sim.scan().field.tobytes() == changed.field.tobytes()
    still = rs.Simulator(steered(25), "fast", 1)
    still.skip_to(changed.number)
    assert still.scan().field.tobytes() != changed.field.tobytes()
