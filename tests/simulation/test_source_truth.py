"""The power of sources and radiometric truth of runs with commands: computed from what was commanded at each time."""

import numpy as np
import pytest

import radar_service as rs
from tests.scenes import point

SCENE = {
    "name": "steered",
    "radar": {"azimuths": 128, "beamwidth_deg": 6, "range_max_m": 900, "pulse_s": 1e-6, "rpm": 60},
    "environment": {"noise": True},
    "body": [{**point("runner", 0, 400, 5, 10), "steerable": {"max_speed_kn": 60}}, point("fixed", -300, -300, 5, 10)],
}


def test_a_steered_body_is_measured_where_it_was_steered_to() -> None:
    """The centroid lies on the crossing within a fiftieth of a spoke and 5 cm, as the 20 dB gate cuts at whole cells."""
    sim = rs.Simulator(rs.load_scene(SCENE), "balanced")
    sim.scan()
    sim.command("runner", course_deg=90, speed_kn=40)
    for _ in range(3):
        sim.scan()
    for scan in (1, 2, 3):
        for crossing in sim.crossings(scan, radiometric=True):
            assert crossing.rcs_dbsm == pytest.approx(10.0, abs=0.05), (scan, crossing.body)
            assert crossing.centroid_range == pytest.approx(crossing.range, abs=0.05)
            off = (crossing.centroid_bearing - crossing.bearing + np.pi) % (2 * np.pi) - np.pi
            assert abs(np.degrees(off)) < 2.8 / 50
    ranges = [c.range for scan in (1, 3) for c in sim.crossings(scan) if c.body == "runner"]
    assert len(ranges) >= 2 and ranges[-1] > ranges[0] + 0.5


def test_powers_follow_commands_given_later() -> None:
    sim = rs.Simulator(rs.load_scene(SCENE), "balanced")
    sim.scan()
    before = sim.source_powers(0)
    sim.command("runner", present=False)
    sim.scan()
    assert {sim.label_names[number] for number in sim.source_powers(0)} == {"noise", "runner", "fixed"}
    assert {sim.label_names[number] for number in sim.source_powers(1)} == {"noise", "fixed"}
    np.testing.assert_array_equal(before[257], sim.source_powers(0)[257])


def test_several_pulses_follow_commands_too() -> None:
    """The runner stands at the seam between two pulses; each part of it is measured where it was steered to."""
    pulses = [{"modulation": "none", "pulse_s": 8e-8, "bandwidth_hz": 15e6, "range_max_m": 400}, {"pulse_s": 1e-6}]
    radar = {key: value for key, value in SCENE["radar"].items() if key != "pulse_s"} | {"pulses": pulses}
    sim = rs.Simulator(rs.load_scene({**SCENE, "radar": radar}), "balanced", labels=True)
    sim.scan()
    sim.command("runner", course_deg=90, speed_kn=4)
    scan = [sim.scan() for _ in range(3)][-1]
    seen = [each for number in (1, 2, 3) for each in sim.crossings(number, radiometric=True)]
    assert len(seen) >= 6 and {each.body for each in seen} == {"runner", "fixed"}
    for crossing in seen:
        assert crossing.rcs_dbsm == pytest.approx(10.0, abs=0.05), (crossing.scan, crossing.body)
    power = sim.source_powers()[256]
    seam = int(400 / sim.range_step)
    assert power[:, :seam].any() and power[:, seam:].any()
    row, column = np.unravel_index(power.argmax(), power.shape)
    assert scan.labels is not None and scan.labels[row, column] == 256
    sim.command("runner", present=False)
    sim.scan()
    assert 256 not in sim.source_powers()


def test_the_specification_as_printed_has_no_sources() -> None:
    sim = rs.Simulator(rs.load_scene(SCENE), "documented")
    with pytest.raises(ValueError, match="source_powers: .*choose another fidelity"):
        sim.source_powers(0)
    with pytest.raises(ValueError, match="radiometric: .*choose another fidelity"):
        sim.crossings(0, radiometric=True)
