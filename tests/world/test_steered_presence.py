"""Presence under command."""

import pickle

import numpy as np

from radar_service.world.presence import Fading, Presence
from radar_service.world.steered_presence import MAX_CHANGES, SteeredPresence

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
