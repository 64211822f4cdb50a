"""A token bucket allows its rate on average and its burst at once."""

from radar_service.service.token_bucket import TokenBucket


def test_a_burst_and_then_the_rate() -> None:
    now = [0.0]
    bucket = TokenBucket(10.0, 5.0, lambda: now[0])
    assert bucket.take(5) and not bucket.take(1)
    now[0] = 0.25
    assert not bucket.take(3) and bucket.take(2) and not bucket.take(1)
    now[0] = 1000.0
    assert not bucket.take(6) and bucket.take(5)
