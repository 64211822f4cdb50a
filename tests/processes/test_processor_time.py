"""Limits of processor time."""

import resource

import pytest

from radar_service.processes import processor_time


def test_the_limit_counts_from_now() -> None:
    before = resource.getrlimit(resource.RLIMIT_CPU)
    try:
        processor_time.limit_processor_time(5.0)
        soft, hard = resource.getrlimit(resource.RLIMIT_CPU)
        assert hard == before[1] and 4.5 <= soft - processor_time.used_processor_time() <= 6.1
    finally:
        resource.setrlimit(resource.RLIMIT_CPU, before)


def test_a_busy_machine_is_named_with_what_waits() -> None:
    with pytest.raises(processor_time.MachineBusyError, match="^body: the machine is busy: .* in 120 s; try again later$"):
        raise processor_time.machine_busy("body", 120.0)
