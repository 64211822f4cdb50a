"""ASTERIX by UDP, as surveillance systems read it: radar video (category 240) and plots (category 048)."""

import argparse
from collections.abc import Mapping
from dataclasses import dataclass
from pkgutil import resolve_name
from typing import TYPE_CHECKING

from radar_service.ports.udp.addresses import address, check_reach, numeric
from radar_service.terminal import add_whole_number

if TYPE_CHECKING:
    from radar_service.ports.asterix.asterix_port import AsterixPort
    from radar_service.ports.port import Port
    from radar_service.ports.udp.capture import Capture
    from radar_service.ports.udp.udp_port import Sender
    from radar_service.service.spokes import SpokeSink


@dataclass(frozen=True)
class AsterixPackage:
    """What a category has for `serve`, `replay` and `export`, as `PortPackage`. what: is sent; port: the name of its class."""

    name: str
    what: str
    port: str
    replays = True

    def add_arguments(self, groups: "Mapping[str, argparse._ActionsContainer]") -> None:
        """Adds its options."""
        help = f"send {self.what} there; IF as with --nmea-udp"
        groups["where"].add_argument(f"--{self.name}", type=address, metavar="HOST:PORT[%IF]", help=help)

    def opened(self, options: argparse.Namespace) -> "Port | None":
        """Returns the port, open; None without its option. Raises UsageError."""
        option, where = f"--{self.name}", getattr(options, self.name.replace("-", "_"))
        if where is None:
            return None
        check_reach(option, where, options.asterix_allow, options.insecure, listens=False, allow="--asterix-allow")
        from radar_service.ports.udp.capture import capture_of
        from radar_service.ports.udp.sender import UdpSender

        return self._port(UdpSender(option, where, joined=0, capture=capture_of(options)), options)

    def exported(self, number: int, capture: "Capture", options: argparse.Namespace) -> "SpokeSink":
        """Returns a sink that writes a recorded radar into a capture. number: of the radar in its recording, from 0."""
        from radar_service.ports.udp.capture import CaptureSender

        sender = CaptureSender(capture, ("192.0.2.1", 8600), ("239.192.43.78", 8600))
        return self._port(sender, options).sink(number % 255 + 1)

    def _port(self, sender: "Sender", options: argparse.Namespace) -> "AsterixPort":
        from radar_service.ports.asterix.blocks import Form

        form = Form(options.asterix_sac, options.asterix_bits, options.asterix_datagram)
        port: AsterixPort = resolve_name(f"{__name__}.asterix_port:{self.port}")([sender], form)
        return port


class Video(AsterixPackage):
    """Category 240, with the options that both have."""

    def add_arguments(self, groups: "Mapping[str, argparse._ActionsContainer]") -> None:
        """Adds its options."""
        super().add_arguments(groups)
        self.add_export_arguments(groups["where"])
        groups["who may"].add_argument(
            "--asterix-allow", nargs="+", default=[], type=numeric, metavar="ADDRESS", help="other machines they may go to"
        )

    def add_export_arguments(self, where: "argparse._ActionsContainer") -> None:
        """Adds the options that captures of recordings have, too."""
        where.add_argument("--asterix-bits", type=int, choices=(8, 16), default=8, help="of a cell of it (default 8)")
        size = "bytes of a datagram of it; longer spokes are split (default 1400, 65507: one datagram a spoke)"
        add_whole_number(where, "--asterix-datagram", 1400, 256, 65507, metavar="N", help=size)
        add_whole_number(where, "--asterix-sac", 0, 0, 255, metavar="N", help="system area code of ASTERIX (default 0)")


VIDEO = Video("asterix", "the video of all radars as ASTERIX category 240", "AsterixPort")
PLOTS = AsterixPackage("asterix-plots", "plots of all radars as ASTERIX category 048", "PlotPort")
