"""Who steers, by times that the test gives."""

import pytest

from radar_service.ports.nmea_in.sentence_reader import Reading, SentenceIgnoredError
from radar_service.ports.nmea_in.steering_port import SILENCE, Helm

HEADING = Reading(heading_deg=30.0)


def at(clock: float) -> Reading:
    return Reading(position=(50.0, -1.0), clock=clock)


def word(helm: Helm, sender: str, reading: Reading, now: float) -> str:
    with pytest.raises(SentenceIgnoredError) as ignored:
        helm.hear(sender, reading, now)
    return str(ignored.value)


def test_the_first_one_steers_until_three_seconds_of_silence() -> None:
    helm = Helm()
    assert SILENCE == 3.0
    helm.hear("a", HEADING, 10.0)
    assert word(helm, "b", HEADING, 12.9) == "holder"
    helm.hear("a", HEADING, 12.95)
    assert word(helm, "b", HEADING, 15.9) == "holder" and helm.holder == "a"
    helm.hear("b", HEADING, 15.95)
    assert helm.holder == "b" and word(helm, "a", HEADING, 16.0) == "holder"


def test_what_one_has_said_stays_but_for_the_position() -> None:
    helm = Helm()
    helm.hear("a", Reading(None, 80.0, 6.0, (50.0, -1.0), 1.0), 0.0)
    order = helm.hear("a", HEADING, 0.1)
    assert order.motion == {"heading_deg": 30.0, "course_deg": 80.0, "speed_kn": 6.0} and order.position is None
    assert helm.hear("b", HEADING, 3.2).motion == {"heading_deg": 30.0}  # nothing of the one before


def test_the_past_is_not_followed_and_holds_no_helm() -> None:
    helm = Helm()
    helm.hear("a", at(100.0), 0.0)
    helm.hear("a", at(100.0), 0.1)  # two sentences of one second
    assert word(helm, "a", at(99.9), 1.0) == "past" and word(helm, "a", at(99.9), 3.0) == "past"
    helm.hear("b", at(5.0), 3.2)
    assert helm.holder == "b"


def test_a_clock_that_was_set_back_is_followed_after_three_seconds() -> None:
    """The heading goes on meanwhile: another scene of that simulator."""
    helm = Helm()
    helm.hear("a", at(1000.0), 0.0)
    for tenth in range(1, 30):
        helm.hear("a", HEADING, tenth / 10)
        assert word(helm, "a", at(tenth / 10), tenth / 10) == "past"
    assert helm.hear("a", at(3.0), 3.0).position == (50.0, -1.0)


def test_midnight_is_not_the_past() -> None:
    helm = Helm()
    helm.hear("a", at(86_399.5), 0.0)
    helm.hear("a", at(0.5), 1.0)
    assert word(helm, "a", at(86_399.9), 1.1) == "past"
