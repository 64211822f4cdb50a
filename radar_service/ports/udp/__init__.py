"""UDP for ports: addresses, who may be there, datagrams out, and a capture of these."""

import argparse
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING

from radar_service.terminal.arguments import file_ending

if TYPE_CHECKING:
    from radar_service.ports.port import Port

replays = True


def add_arguments(groups: "Mapping[str, argparse._ActionsContainer]") -> None:
    """Adds the option of captures."""
    groups["records"].add_argument(
        "--pcap", type=partial(file_ending, suffix=".pcap"), metavar="FILE.pcap",
        help="write what ports send by UDP as a capture",
    )  # fmt: skip


def opened(options: argparse.Namespace) -> "Port | None":
    """Returns what ends the capture; None without --pcap. Raises OSError."""
    from radar_service.ports.udp.capture import CapturePort, capture_of

    capture = capture_of(options)
    return None if capture is None else CapturePort(capture)
