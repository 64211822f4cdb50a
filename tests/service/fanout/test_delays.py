"""When a lossless client is too slow."""

import pytest

from radar_service.service.fanout.hub import FLOOR, WINDOW, DelayAccount

PERIOD = 0.01  # s


@pytest.mark.parametrize(
    ("waited", "share", "slow"),
    [(0.9, 0.9 * FLOOR, True), (0.9, 1.1 * FLOOR, False), (0.4, 0.1 * FLOOR, False), (0.9, 0.0, True)],
)
def test_a_client_is_slow_that_is_waited_for_and_takes_too_little(waited: float, share: float, slow: bool) -> None:
    account = DelayAccount(100.0, 50)
    account.add(waited * WINDOW)
    got = 50 + round(share * WINDOW / PERIOD)
    assert not account.is_too_slow(100.0 + 0.99 * WINDOW, got, PERIOD)
    assert account.is_too_slow(100.0 + WINDOW, got, PERIOD) == slow
    assert not account.is_too_slow(100.0 + 1.5 * WINDOW, got, PERIOD)  # a new window has begun


def test_a_good_hour_does_not_count_for_a_bad_minute() -> None:
    account = DelayAccount(0.0, 0)
    account.add(1.0)
    assert not account.is_too_slow(3600.0, 360_000, PERIOD)
    account.add(0.9 * WINDOW)
    assert account.is_too_slow(3600.0 + WINDOW, 360_000, PERIOD)
