"""Arguments that several commands share."""

import argparse

import pytest

from radar_service.commands.shared_options import check_sources, service_groups
from radar_service.terminal.arguments import UsageError


def test_sources_need_a_fidelity_that_tells_them() -> None:
    check_sources(argparse.Namespace(fidelity="documented", labels=False, powers=()), "labels", "powers")
    check_sources(argparse.Namespace(fidelity="auto", labels=True, powers="all"), "labels", "powers")
    with pytest.raises(UsageError, match="--powers: the fidelity documented has none; choose another"):
        check_sources(argparse.Namespace(fidelity="documented", labels=False, powers="all"), "labels", "powers")


def test_groups_are_made_in_the_order_of_the_help() -> None:
    titles = [group.title for group in service_groups(argparse.ArgumentParser()).values()]
    assert titles == ["what", "where", "how exact", "how fast", "who may", "records"]
