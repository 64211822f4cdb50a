"""ASTERIX category 240: radar video by UDP, as surveillance systems read it."""

import argparse
from collections.abc import Mapping
from typing import TYPE_CHECKING

from radar_service.ports.udp.addresses import address, check_reach, numeric
from radar_service.terminal.arguments import add_whole_number

if TYPE_CHECKING:
    from radar_service.ports.asterix.video_blocks import Form
    from radar_service.ports.port import Port
    from radar_service.ports.udp.capture import Capture
    from radar_service.service.spokes import SpokeSink

replays = True


def add_arguments(groups: "Mapping[str, argparse._ActionsContainer]") -> None:
    """Adds the options of ASTERIX."""
    where = groups["where"]
    where.add_argument(
        "--asterix", type=address, metavar="HOST:PORT[%IF]",
        help="send the video of all radars there as ASTERIX category 240; IF as with --nmea-udp",
    )  # fmt: skip
    add_export_arguments(where)
    groups["who may"].add_argument(
        "--asterix-allow", nargs="+", default=[], type=numeric, metavar="ADDRESS", help="other machines it may go to"
    )


def add_export_arguments(where: "argparse._ActionsContainer") -> None:
    """Adds the options that captures of recordings have, too."""
    where.add_argument("--asterix-bits", type=int, choices=(8, 16), default=8, help="of a cell of it (default 8)")
    size = "bytes of a datagram of it; longer spokes are split (default 1400, 65507: one datagram a spoke)"
    add_whole_number(where, "--asterix-datagram", 1400, 256, 65507, metavar="N", help=size)
    add_whole_number(where, "--asterix-sac", 0, 0, 255, metavar="N", help="its system area code (default 0)")


def opened(options: argparse.Namespace) -> "Port | None":
    """Returns the port of ASTERIX, with its socket open; None without --asterix. Raises UsageError."""
    if options.asterix is None:
        return None
    check_reach(
        "--asterix", options.asterix, options.asterix_allow, options.insecure, listens=False, allow="--asterix-allow"
    )
    from radar_service.ports.asterix.asterix_port import AsterixPort
    from radar_service.ports.udp.capture import capture_of
    from radar_service.ports.udp.sender import UdpSender

    return AsterixPort([UdpSender("--asterix", options.asterix, joined=0, capture=capture_of(options))], _form(options))


def exported(number: int, capture: "Capture", options: argparse.Namespace) -> "SpokeSink":
    """Returns a sink that writes a recorded radar into a capture. number: of the radar in its recording, from 0."""
    from radar_service.ports.asterix.asterix_port import AsterixSink
    from radar_service.ports.udp.capture import CaptureSender
    from radar_service.ports.udp.udp_port import UdpPort

    sender = CaptureSender(capture, ("192.0.2.1", 8600), ("239.192.43.78", 8600))
    return AsterixSink(UdpPort([sender]), _form(options), number % 255 + 1)


def _form(options: argparse.Namespace) -> "Form":
    from radar_service.ports.asterix.video_blocks import Form

    return Form(options.asterix_sac, options.asterix_bits, options.asterix_datagram)
