"""Subscriptions of the Signal K stream: which paths they take, and when each is due. Times are given, none is measured."""

import functools
import random
from collections import Counter
from typing import Any

import pytest

from radar_service.ports.signalk.subscriptions import (
    MAX_SUBSCRIPTIONS,
    MIN_FIXED,
    SELF,
    Subscriber,
    Subscription,
    SubscriptionError,
    matches,
)

GAIN, RAIN = (SELF, "radars.sim-0.controls.gain"), (SELF, "radars.sim-0.controls.rain")
OTHER = ("vessels.urn:mrn:imo:mmsi:211000001", "navigation.position")


def of(path: str, **row: Any) -> Subscription:
    return Subscription.of(SELF, {"path": path, **row})


@pytest.mark.parametrize(
    ("pattern", "taken"),
    [
        ("radars.*", True), ("radars.*.controls.*", True), ("radars.sim-0.controls.gain", True), ("*", True),
        ("*gain", True), ("radars.sim-1.*", False), ("radars", False), ("radars.sim.0.controls.gain", False), ("", False),
    ],
)  # fmt: skip
def test_paths_with_stars(pattern: str, taken: bool) -> None:
    assert of(pattern).takes(*GAIN) is taken


def slow_match(pattern: str, text: str) -> bool:
    """By the definition: character by character, a star taking none or one more."""

    @functools.cache
    def of_rest(p: int, t: int) -> bool:
        if p == len(pattern):
            return t == len(text)
        if pattern[p] == "*":
            return of_rest(p + 1, t) or (t < len(text) and of_rest(p, t + 1))
        return t < len(text) and pattern[p] == text[t] and of_rest(p + 1, t + 1)

    return of_rest(0, 0)


def test_stars_stand_for_any_characters() -> None:
    """Against the definition, for patterns and texts of two letters, which repeat and overlap in all ways."""
    draw = random.Random(11)
    found = Counter[bool]()
    for _ in range(4000):
        pattern = "".join(draw.choices("ab*", k=draw.randrange(9)))
        text = "".join(draw.choices("ab", k=draw.randrange(9)))
        found[slow_match(pattern, text)] += 1
        assert matches(pattern, text) is slow_match(pattern, text), (pattern, text)
    assert min(found[True], found[False]) > 300


def test_many_stars_cost_nothing() -> None:
    """A regular expression tries more ways than there is time for: some 10 to the power of 50 here."""
    assert not matches("*a" * 99 + "b", "a" * 1000) and matches("*a" * 99, "a" * 1000)


def test_contexts_with_stars() -> None:
    assert Subscription.of("vessels.*", {"path": "*"}).takes(*OTHER) and Subscription.of("*", {"path": "*"}).takes(*GAIN)
    assert not Subscription.of(SELF, {"path": "*"}).takes(*OTHER)


def test_present_values_are_due_at_once_and_changes_as_they_happen() -> None:
    client = Subscriber()
    client.subscribe([of("radars.*")], [GAIN, RAIN, OTHER], now=10.0)
    assert client.take(10.0) == [GAIN, RAIN] and client.next_due is None
    client.note(RAIN, 10.001)
    client.note(OTHER, 10.001)
    assert client.take(10.001) == [RAIN] and client.take(10.001) == []


def test_values_come_no_faster_than_their_period() -> None:
    client = Subscriber(of("radars.*", policy="ideal", period=1000))
    client.note(GAIN, 5.0)
    assert client.take(5.0) == [GAIN]
    client.note(GAIN, 5.2)
    client.note(GAIN, 5.4)
    assert client.next_due == 6.0 and client.take(5.99) == [] and client.take(6.0) == [GAIN] and client.next_due is None


def test_a_later_subscription_counts_for_paths_that_came_before() -> None:
    client = Subscriber(of("radars.*", policy="ideal", period=1000))
    client.note(GAIN, 5.0)
    assert client.take(5.0) == [GAIN]
    client.subscribe([of("*gain")], [], now=5.0)
    client.note(GAIN, 5.1)
    assert client.take(5.1) == [GAIN]
    client.unsubscribe(SELF, "*")
    client.note(GAIN, 9.0)
    assert client.take(9.0) == []


def test_a_period_alone_is_the_shortest_one() -> None:
    """As the plotter OpenCPN subscribes."""
    assert of("radars.*", period=1000) == of("radars.*", policy="ideal", period=1000) != of("radars.*")


@pytest.mark.parametrize("path", ["vessels.*", "vessels.urn:mrn:imo:mmsi:211000001.navigation.*"])
def test_a_path_may_begin_with_its_context(path: str) -> None:
    assert of(path).takes(*OTHER) and not of("vessels.self.navigation.*").takes(*OTHER)
    aid = OTHER[0].replace("vessels", "atons"), OTHER[1]
    assert of(path.replace("vessels", "atons")).takes(*aid) and not of(path).takes(*aid)


def test_an_instant_subscription_may_have_a_shortest_period() -> None:
    client = Subscriber(of("radars.*", policy="instant", minPeriod=200))
    client.note(GAIN, 5.0)
    client.take(5.0)
    client.note(GAIN, 5.1)
    assert client.next_due == pytest.approx(5.2, abs=1e-12)


def test_a_fixed_subscription_repeats_what_has_not_changed() -> None:
    client = Subscriber()
    client.subscribe([of("radars.*", policy="fixed", period=500)], [GAIN], now=1.0)
    assert client.take(1.0) == [GAIN] and client.take(1.4) == [] and client.take(1.5) == [GAIN] and client.next_due == 2.0


def test_of_several_subscriptions_the_quickest_counts() -> None:
    client = Subscriber(of("radars.*", policy="ideal", period=9000), of("*gain"))
    client.note(GAIN, 1.0)
    client.take(1.0)
    client.note(GAIN, 1.1)
    assert client.next_due == 1.1


def test_what_is_unsubscribed_is_due_no_more() -> None:
    client = Subscriber()
    client.subscribe([of("*gain"), of("*rain")], [GAIN, RAIN], now=1.0)
    client.unsubscribe(SELF, "*gain")
    assert client.take(1.0) == [RAIN]
    client.unsubscribe("*", "*")
    client.note(RAIN, 2.0)
    assert client.next_due is None


@pytest.mark.parametrize(
    ("row", "reason"),
    [
        ({}, "path"), ("radars.*", "each row"), ({"path": 5}, "path"), ({"path": "*", "policy": "often"}, "policy: 'often'"),
        ({"path": "*", "policy": "fixed", "period": "1"}, "period: '1' is not a number"),
        ({"path": "*", "policy": "ideal", "period": -1}, "period: -1 ms"),
        ({"path": "*", "minPeriod": 1e12}, "minPeriod: 1e.12 ms"), ({"path": "*", "minPeriod": True}, "minPeriod"),
    ],
)  # fmt: skip
def test_rows_that_are_none_are_refused(row: Any, reason: str) -> None:
    with pytest.raises(SubscriptionError, match=reason):
        Subscription.of(SELF, row)


def test_subscriptions_of_a_client_are_bounded() -> None:
    client = Subscriber()
    for number in range(MAX_SUBSCRIPTIONS):
        client.subscribe([of(f"radars.{number}")], [], now=0.0)
    client.subscribe([of("radars.0")], [GAIN], now=0.0)  # the same again is none
    with pytest.raises(SubscriptionError, match="at most 100"):
        client.subscribe([of("radars.x")], [], now=0.0)


def test_a_fixed_period_of_nothing_does_not_spin() -> None:
    client = Subscriber()
    client.subscribe([of("*", policy="fixed", period=0)], [GAIN], now=0.0)
    client.take(0.0)
    assert client.next_due == pytest.approx(MIN_FIXED, abs=1e-15)
