"""The arguments of `record` and `replay`."""

import argparse
from pathlib import Path

import pytest

from radar_service.commands.command_line import parser
from radar_service.commands.recording_arguments import seconds


def test_what_the_commands_take() -> None:
    record = parser().parse_args(["record", "harbour", "-o", "a.mcap", "--scans", "7", "--seed", "2", "--threads", "2"])
    assert (record.scene, record.out, record.scans, record.seed, record.truth) == ("harbour", Path("a.mcap"), 7, 2, False)
    replay = parser().parse_args(["replay", "a.mcap", "--from", "2.5", "--epoch", "1", "--pace", "max", "--wait-for", "2"])
    assert (replay.recording, replay.start, replay.epoch, replay.wait_for) == (Path("a.mcap"), 2.5, 1, 2)
    assert parser().parse_args(["serve", "--record", "a.mcap"]).record == Path("a.mcap")


@pytest.mark.parametrize(
    "command", [["record", "x", "-o", "a.npz"], ["record", "x"], ["replay"], ["serve", "--record", "a"]]
)
def test_what_they_refuse(command: list[str]) -> None:
    with pytest.raises(SystemExit):
        parser().parse_args(command)


def test_a_time_is_a_number_from_0() -> None:
    assert seconds("0") == 0.0 and seconds("1e3") == 1000.0
    for text in ("-1", "nan", "inf", "soon"):
        with pytest.raises(argparse.ArgumentTypeError, match=f'"{text}" is not a time of 0 s or more'):
            seconds(text)
