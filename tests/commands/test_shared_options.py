"""Arguments that several commands share."""

import argparse

from radar_service.commands.shared_options import service_groups


def test_groups_are_made_in_the_order_of_the_help() -> None:
    titles = [group.title for group in service_groups(argparse.ArgumentParser()).values()]
    assert titles == ["what", "where", "how exact", "how fast", "who may", "records"]
