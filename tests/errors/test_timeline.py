"""Which errors are in force when."""

from radar_service.errors import timeline
from radar_service.errors.timeline import ErrorTimeline
from radar_service.scene.error_settings import AntennaErrors, ErrorSettings

ONE, TWO = (ErrorSettings(antenna=AntennaErrors(angle, 0.0, 0.0, 0.0)) for angle in (0.1, 0.2))


def test_a_change_acts_from_its_spoke_on() -> None:
    its = ErrorTimeline()
    assert its.latest is None and not its.has_errors
    its.set(ONE, 10)
    its.set(None, 20)
    assert [its.at(number) for number in (0, 9, 10, 19, 20, 99)] == [None, None, ONE, ONE, None, None]
    assert its.latest is None and its.has_errors and its.changes(0, 100) == [10, 20] and its.changes(10, 20) == []


def test_a_change_replaces_what_was_to_come() -> None:
    its = ErrorTimeline(ONE)
    its.set(None, 20)
    its.set(TWO, 5)
    assert [its.at(number) for number in (0, 4, 5, 99)] == [ONE, ONE, TWO, TWO]
    its.set(None, 0)
    assert its.at(50) is None and not its.has_errors


def test_it_tells_since_when_a_part_is_as_it_is() -> None:
    its = ErrorTimeline(ONE)
    its.set(TWO, 10)
    its.set(ErrorSettings(antenna=TWO.antenna), 15)  # equal: no change
    its.set(None, 20)
    its.set(TWO, 30)

    def angle(errors: ErrorSettings | None) -> float | None:
        return errors.antenna.misalignment if errors and errors.antenna else None

    assert its.changes(0, 100) == [10, 20, 30]
    assert [its.since(number, angle) for number in (3, 12, 25, 40)] == [0, 10, 20, 30]
    assert its.since(40, lambda errors: "anything") == 0


def test_it_remembers_a_bounded_number_of_changes() -> None:
    its = ErrorTimeline()
    for number in range(1, 3 * timeline.MAX_CHANGES):
        its.set((ONE, TWO)[number % 2], number)
    end = 3 * timeline.MAX_CHANGES
    assert len(its.changes(0, end)) <= timeline.MAX_CHANGES
    assert its.at(0) is not None and its.at(end) is (ONE, TWO)[(end - 1) % 2]
