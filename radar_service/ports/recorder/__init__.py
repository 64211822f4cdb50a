"""The recorder: all that the radars send, into a file."""

import argparse
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING

from radar_service.terminal import UsageError, add_sources, check_sources, file_ending, prepare

if TYPE_CHECKING:
    from radar_service.ports.port import Port


def add_arguments(groups: "Mapping[str, argparse._ActionsContainer]") -> None:
    """Adds the options of recordings."""
    records = groups["records"]
    records.add_argument(
        "--record", type=partial(file_ending, suffix=".mcap"), metavar="FILE.mcap",
        help="record what the radars send, and with --truth the truth",
    )  # fmt: skip
    add_sources(records, "record", ", with --record; clients ask for theirs, where --truth allows it")


def opened(options: argparse.Namespace) -> "Port | None":
    """Returns the recorder, with its file open; None without --record. Raises UsageError and OSError."""
    check_sources(options, "labels", "powers")
    if options.record is None:
        for name in ("labels", "powers"):
            if getattr(options, name):
                raise UsageError(
                    f"--{name}: goes with --record FILE.mcap; a client asks for its own by ?{name}=... where --truth allows it"
                )
        return None
    from radar_service.ports.recorder.recorder_port import RecorderPort
    from radar_service.records import SourceRequest

    prepare([options.record], options.overwrite)
    return RecorderPort(options.record, options.truth, SourceRequest(options.labels, options.powers))
