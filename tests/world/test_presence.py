"""Tests of radar_service.world.presence: when a body is present."""

import pickle
from dataclasses import dataclass

import numpy as np

from radar_service.world.presence import MAX_CHANGES, Fading, Presence, Presences, SteeredPresence


@dataclass(frozen=True)
class Guest:
    """Something with a presence alone."""

    presence: Presence


VISIT = Presence(np.array([0.0, 3.0, 7.0]), np.array([False, True, False]))


def test_a_change_holds_from_its_instant_on() -> None:
    times = np.array([-1.0, 0.0, 2.999, 3.0, 6.999, 7.0, 1e6])
    assert VISIT.at(times).tolist() == [False, False, False, True, True, False, False]
    assert Presence.always.at(times).all() and Presence.always.constant and not VISIT.constant


def test_a_time_that_misses_an_instant_by_rounding_is_at_it() -> None:
    assert VISIT.at(np.array([3.0 - 1e-12])).all()


def test_fading_repeats_its_pattern() -> None:
    fading = Presence(np.zeros(1), np.ones(1, dtype=np.bool_), Fading(np.array([True, True, False]), 2.5, 1.0))
    assert fading.at(np.arange(1.0, 17.0, 2.5)).tolist() == [True, True, False, True, True, False, True]
    assert fading.at(np.array([0.9]))[0] == np.False_  # the unit before the first is the last of the pattern
    assert not fading.constant


def test_fading_applies_while_the_body_is_there_at_all() -> None:
    both = Presence(VISIT.time, VISIT.present, Fading(np.array([True, False]), 1.0))
    assert both.at(np.arange(10.0)).tolist() == [False, False, False, False, True, False, True, False, False, False]


def test_a_later_change_replaces_what_was_planned_after_it() -> None:
    changed = VISIT.changed(5.0, False).changed(6.0, True)
    assert changed.at(np.array([2.0, 4.0, 5.5, 6.5, 8.0])).tolist() == [False, True, False, True, True]
    assert Presence.always.changed(0.0, False).at(np.array([-0.5, 0.0])).tolist() == [True, False]


def test_spans_end_where_any_presence_changes() -> None:
    late = Presence(np.array([0.0, 5.0]), np.array([False, True]))
    bodies = [Guest(Presence.always), Guest(VISIT), Guest(late)]
    presences = Presences(bodies)
    assert presences.changing.tolist() == [1, 2]
    assert list(presences.spans(np.arange(10.0))) == [(0, 3), (3, 5), (5, 7), (7, 10)]
    assert list(Presences(bodies[:1]).spans(np.arange(10.0))) == [(0, 10)]
    assert [presences.at(time).tolist() for time in (1.0, 6.0, 8.0)] == [
        [True, False, False], [True, True, True], [True, False, True],
    ]  # fmt: skip


TIMES = np.array([0.0, 4.9, 5.0, 8.0, 20.0])


def test_it_begins_as_the_presence_of_the_scene_and_is_never_constant() -> None:
    presence = SteeredPresence.under(Presence.always)
    assert presence.at(TIMES).all() and not presence.constant and not presence.past.constant
    hidden = SteeredPresence.under(Presence(np.zeros(1), np.zeros(1, dtype=np.bool_)))
    assert not hidden.at(TIMES).any() and not hidden.past.at(TIMES).any()


def test_the_past_takes_changes_at_once_and_the_rest_follows() -> None:
    presence = SteeredPresence.under(Presence.always)
    presence.steer(5.0, False)
    assert presence.at(TIMES).all()
    np.testing.assert_array_equal(presence.past.at(TIMES), [True, True, False, False, False])
    presence.follow()
    np.testing.assert_array_equal(presence.at(TIMES), [True, True, False, False, False])
    presence.steer(8.0, True)
    presence.follow()
    np.testing.assert_array_equal(presence.at(TIMES), [True, True, False, True, True])
    presence.forget()
    assert presence.past.at(TIMES).all() and not presence.at(TIMES).all()
    presence.follow()
    assert presence.at(TIMES).all()


def test_fading_goes_on() -> None:
    presence = SteeredPresence.under(Presence(np.zeros(1), np.ones(1, dtype=np.bool_), Fading(np.array([True, False]), 4.0)))
    presence.steer(5.0, True)
    presence.follow()
    np.testing.assert_array_equal(presence.at(np.array([1.0, 5.0, 9.0, 13.0])), [True, False, True, False])


def test_it_remembers_so_many_changes_and_travels() -> None:
    presence = SteeredPresence.under(Presence.always)
    for second in range(MAX_CHANGES + 5):
        presence.steer(float(second), second % 2 == 0)
    presence.follow()
    times = np.arange(10.0, MAX_CHANGES + 5.0)
    np.testing.assert_array_equal(presence.at(times), times % 2 == 0)
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(presence)).at(times), times % 2 == 0)
