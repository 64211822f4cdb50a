"""Errors of a run, in process: when they act, and what the truth says of them."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.errors import reporter
from radar_service.errors.reporter import ErrorReporter, ErrorTimeline
from radar_service.numerics.frames import wrap_angle
from radar_service.records.spokes import SpokeBlock
from radar_service.world.reporting import AntennaErrors, ErrorSettings
from tests.errors.runs import AZIMUTHS, SCENE, same, simulator, whole

BAD_FEED = {
    "drop_rate": 0.1, "repeat_rate": 0.1, "late_rate": 0.1, "late_s": 0.2, "swap_rate": 0.1, "stuck_sector_deg": [80, 120],
    "heading_lost_s": [[1.25, 1.5]],
}  # fmt: skip
EVERYTHING: dict[str, Any] = {
    "profile": "imo-a823",
    "gyro": {"latency_s": 0.1},
    "position": {"noise_m": 4, "bias_m": [2, 1]},
    "feed": BAD_FEED,
}


def test_a_change_acts_from_the_first_spoke_not_yet_yielded() -> None:
    sim, plain = simulator(), whole(simulator())
    spokes = iter(sim.blocks(1, size=10))
    taken = [next(spokes), next(spokes)]
    sim.set_errors({"gyro": {"bias_deg": 2}})
    taken += list(spokes)
    assert all(block.true is None for block in taken[:2]) and all(block.true is not None for block in taken[2:])
    difference = np.concatenate([block.heading for block in taken]) - plain.heading
    np.testing.assert_allclose(wrap_angle(difference), np.where(np.arange(AZIMUTHS) < 20, 0.0, np.deg2rad(2)), atol=1e-12)
    sim.set_errors(None)
    assert sim.errors is None and next(sim.blocks(1)).true is None


def test_truth_says_what_the_nearest_spoke_reports() -> None:
    sim, plain = simulator(EVERYTHING), simulator()
    spokes = {spoke.number: spoke for spoke in sim.spokes(3)}
    list(plain.blocks(3))
    nearest = [crossing.spoke for crossing in plain.crossings(1)]
    assert 2 * AZIMUTHS in nearest  # of the next scan, which is not yet sent when the truth of this one is told
    for scan in range(3):
        records = [*sim.crossings(scan), sim.snapshot(scan)]
        expected = [*plain.crossings(scan), plain.snapshot(scan)]
        for record, truly in zip(records, expected, strict=True):
            last = (scan + 1) * AZIMUTHS - 1
            spoke = spokes[min(record.spoke, last) if isinstance(record, rs.Crossing) else last]
            own, reported = record.own_ship, record.own_ship.reported
            assert reported is not None and spoke.true is not None and truly.own_ship.reported is None
            assert replace(own, reported=None) == truly.own_ship
            offset = np.subtract(reported.position, own.position)
            np.testing.assert_allclose(offset[:2], np.subtract(spoke.position, spoke.true.position), atol=1e-12)
            assert offset[2] == 0.0
            assert reported.speed - own.speed == pytest.approx(spoke.speed - spoke.true.speed, abs=1e-12)
            error = wrap_angle(np.array(spoke.azimuth - spoke.true.azimuth))
            if np.isnan(spoke.heading):
                assert reported.heading is None and reported.course is None
                error = wrap_angle(np.array(spoke.azimuth - spoke.true.azimuth + spoke.true.heading))
            else:
                assert reported.heading is not None and reported.course is not None
                for name in ("heading", "course"):
                    value, true = getattr(reported, name), getattr(own, name)
                    sent_error = float(wrap_angle(np.array(getattr(spoke, name) - getattr(spoke.true, name))))
                    assert wrap_angle(np.array(value - true)) == pytest.approx(sent_error, abs=1e-12)
            assert reported.azimuth_error == pytest.approx(float(error), abs=1e-12)


def test_crossings_of_several_scans_are_those_of_each_where_errors_change_meanwhile() -> None:
    sim = simulator(EVERYTHING)
    for tables in (None, {"gyro": {"bias_deg": 2}}, EVERYTHING):
        sim.scan()
        sim.set_errors(tables)
    sim.scan()
    every = [crossing for scan in range(4) for crossing in sim.crossings(scan)]
    assert list(sim.crossings(0, count=4)) == every
    assert {crossing.own_ship.reported is None for crossing in every} == {True, False}


def test_a_lost_heading_is_null_in_the_truth() -> None:
    sim = simulator({"feed": {"heading_lost_s": [[0, 1]]}})
    reported = sim.snapshot(0).own_ship.reported
    assert reported is not None and reported.heading is None and reported.course is None and reported.azimuth_error == 0.0
    reported = sim.snapshot(1).own_ship.reported
    assert reported is not None and reported.heading == pytest.approx(sim.snapshot(1).own_ship.heading)


def test_the_feed_in_process_meets_the_errors_and_the_truth_counts_them() -> None:
    sim, plain = simulator(EVERYTHING), simulator(EVERYTHING | {"feed": None})
    sent, spokes = list(sim.feed(4)), {spoke.number: spoke for spoke in plain.spokes(4)}
    for spoke in sent:
        truly = spokes[spoke.number]
        assert (spoke.time, spoke.index, spoke.scan, spoke.position) == (truly.time, truly.index, truly.scan, truly.position)
    numbers = [spoke.number for spoke in sent]
    assert numbers != sorted(numbers) and len(set(numbers)) < len(numbers)
    counts = [sim.snapshot(scan).feed_errors for scan in range(4)]
    assert all(count is not None for count in counts) and plain.snapshot(0).feed_errors is None
    for scan, count in enumerate(counts[:3]):  # late spokes of the last one are to come
        assert count is not None
        of_scan = [n for n in numbers if n // AZIMUTHS == scan]
        assert AZIMUTHS - len(set(of_scan)) == count.dropped > 0
        assert len(of_scan) - len(set(of_scan)) == count.repeated > 0 and count.late > 0 and count.out_of_order > 0
        changed = [spoke for spoke in sent if not np.array_equal(spoke.power, spokes[spoke.number].power)]
        stuck = {spoke.number for spoke in changed if spoke.scan == scan}
        assert len(stuck) == count.stuck and (count.stuck > 0) is (scan > 0)
        assert count.heading_lost == len({s.number for s in sent if s.scan == scan and np.isnan(s.heading)})
    assert counts[1] is not None and counts[1].heading_lost > 0


def test_counts_belong_to_the_errors_in_force() -> None:
    sim = simulator()
    spokes = iter(sim.blocks(2, size=AZIMUTHS // 2))
    next(spokes)
    sim.set_errors({"feed": {"drop_rate": 1}})
    next(spokes)
    sim.set_errors(None)
    list(spokes)
    counts = sim.snapshot(0).feed_errors
    assert counts is not None and counts.dropped == AZIMUTHS // 2 and sim.snapshot(1).feed_errors is None
    assert "feed_errors" in sim.snapshot(0).as_dict() and "feed_errors" not in sim.snapshot(1).as_dict()


def test_a_run_that_skips_begins_anew_with_the_errors_in_force() -> None:
    sim, other = simulator(), simulator({"feed": {"stuck_sector_deg": [0, 360]}})
    list(sim.feed(2))
    sim.set_errors({"feed": {"stuck_sector_deg": [0, 360]}})
    for each in (sim, other):
        each.skip_to(3)
    one, two = list(sim.feed(2)), list(other.feed(2))
    assert [spoke.number for spoke in one] == [spoke.number for spoke in two] == list(range(3 * AZIMUTHS, 5 * AZIMUTHS))
    assert all(np.array_equal(a.power, b.power) for a, b in zip(one, two, strict=True))
    counts = [each.snapshot(scan).feed_errors for each in (sim, other) for scan in (3, 4)]
    assert [count.stuck for count in counts if count] == [0, AZIMUTHS] * 2


def test_each_radar_has_an_antenna_and_a_feed_of_its_own() -> None:
    scene, plain = rs.load_scene(SCENE | {"errors": {"profile": "imo-a823", "feed": {"drop_rate": 0.3}}}), whole(simulator())
    made = [ErrorReporter(scene.radar, 5, scene.errors, *key) for key in ((), ("0",), ("aft",))]
    reported = [each.reported(plain, lambda _: plain.readings) for each in made]
    assert same(reported[0], reported[1]) and not same(reported[0], reported[2])
    np.testing.assert_array_equal(reported[0].heading, reported[2].heading)  # they share the gyro
    sent = [[part.first for part in each.sent(plain)] for each in made]
    assert sent[0] == sent[1] != sent[2]


def test_without_errors_nothing_is_added() -> None:
    block: SpokeBlock = whole(sim := simulator({"gyro": {}}))
    assert block.true is None and same(block, whole(simulator())) and sim.errors is None
    assert list(map(lambda spoke: spoke.number, simulator().feed(2))) == list(range(2 * AZIMUTHS))


ONE, TWO = (ErrorSettings(antenna=AntennaErrors(angle, 0.0, 0.0, 0.0)) for angle in (0.1, 0.2))


def test_a_change_acts_from_its_spoke_on() -> None:
    timeline = ErrorTimeline()
    assert timeline.errors is None and not timeline.has_errors
    timeline.set(ONE, 10)
    timeline.set(None, 20)
    assert [timeline.at(number) for number in (0, 9, 10, 19, 20, 99)] == [None, None, ONE, ONE, None, None]
    assert timeline.errors is None and timeline.has_errors
    assert timeline.changes(0, 100) == [10, 20] and timeline.changes(10, 20) == []


def test_a_change_replaces_what_was_to_come() -> None:
    timeline = ErrorTimeline(ONE)
    timeline.set(None, 20)
    timeline.set(TWO, 5)
    assert [timeline.at(number) for number in (0, 4, 5, 99)] == [ONE, ONE, TWO, TWO]
    timeline.set(None, 0)
    assert timeline.at(50) is None and not timeline.has_errors


def test_it_tells_since_when_a_part_is_as_it_is() -> None:
    timeline = ErrorTimeline(ONE)
    timeline.set(TWO, 10)
    timeline.set(ErrorSettings(antenna=TWO.antenna), 15)  # equal: no change
    timeline.set(None, 20)
    timeline.set(TWO, 30)

    def angle(errors: ErrorSettings | None) -> float | None:
        return errors.antenna.misalignment if errors and errors.antenna else None

    assert timeline.changes(0, 100) == [10, 20, 30]
    assert [timeline.since(number, angle) for number in (3, 12, 25, 40)] == [0, 10, 20, 30]
    assert timeline.since(40, lambda errors: "anything") == 0


def test_it_remembers_a_bounded_number_of_changes() -> None:
    timeline = ErrorTimeline()
    for number in range(1, 3 * reporter.MAX_CHANGES):
        timeline.set((ONE, TWO)[number % 2], number)
    end = 3 * reporter.MAX_CHANGES
    assert len(timeline.changes(0, end)) <= reporter.MAX_CHANGES
    assert timeline.at(0) is not None and timeline.at(end) is (ONE, TWO)[(end - 1) % 2]
