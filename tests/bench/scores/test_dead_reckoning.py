"""Dead reckoning against what a pencil gives."""

from radar_service.bench.scores.dead_reckoning import distance_at, moved_on


def test_a_position_moves_along_its_velocity() -> None:
    assert moved_on((100.0, -50.0), (2.0, 3.0), 10.0).tolist() == [120.0, -20.0]
    assert moved_on((100.0, -50.0), (2.0, 3.0), -10.0).tolist() == [80.0, -80.0]


def test_the_truth_is_moved_to_the_time_of_the_track() -> None:
    """At 12 s a truth of 10 s at (0, 0) and 1.5, -2 m/s stands at (3, -4): 5 m from (0, 0)."""
    assert distance_at((0.0, 0.0), 12.0, (0.0, 0.0), (1.5, -2.0), 10.0) == 5.0
    assert distance_at((3.0, -4.0), 12.0, (0.0, 0.0), (1.5, -2.0), 10.0) == 0.0
