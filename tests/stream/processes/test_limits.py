"""Limits of processes and the priority of set-up."""

import os
import threading

import pytest

from radar_service.stream.processes import limits


def test_set_up_has_a_low_priority_and_what_follows_has_not() -> None:
    before = os.getpriority(os.PRIO_PROCESS, 0)
    assert limits.at_low_priority(lambda: os.getpriority(os.PRIO_PROCESS, threading.get_native_id())) == min(
        19, before + limits.SET_UP_NICENESS
    )
    assert os.getpriority(os.PRIO_PROCESS, 0) == before


def test_an_error_of_set_up_is_raised() -> None:
    with pytest.raises(ZeroDivisionError):
        limits.at_low_priority(lambda: 1 // 0)


def test_a_world_may_have_half_of_the_machine_and_always_something() -> None:
    machine = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    assert limits.default_memory() == max(limits.MIN_MEMORY, machine // 2)
