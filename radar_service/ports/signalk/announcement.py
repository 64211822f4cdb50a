"""Tells by mDNS where the service is, as mayara_pi and others look for a Signal K server."""

import ipaddress
import logging
import socket

from radar_service.service.logs import log_event
from radar_service.terminal.arguments import UsageError
from radar_service.terminal.extras import extra

with extra("announce", "announcements"):
    from zeroconf import Error, InterfaceChoice, ServiceInfo, get_all_addresses
    from zeroconf.asyncio import AsyncZeroconf

KIND = "_signalk-http._tcp.local."
TEXT = {"txtvers": "1", "roles": "master, main", "swname": "radar-service", "self": "simulated"}


class Announcement:
    """An announcement of a port on the interfaces on which the service listens. A network that fails is logged."""

    def __init__(self, host: str, port: int) -> None:
        """host: of the service, in IPv4 or as a name of that. Raises UsageError."""
        if port == 0:
            raise UsageError("--announce: others need to know the port; give --port, as 8000")
        try:
            address = ipaddress.IPv4Address(socket.gethostbyname(host))
        except (OSError, ValueError):
            raise UsageError(f"--announce: {host} has no address of IPv4, by which others look; give another --host") from None
        self._port, self._everywhere, self._address = port, address.is_unspecified, str(address)
        self._zeroconf: AsyncZeroconf | None = None

    async def start(self) -> None:
        """Begins to announce."""
        addresses = get_all_addresses() if self._everywhere else [self._address]
        name = f"Simulated radar, port {self._port}"
        info = ServiceInfo(
            KIND, f"{name}.{KIND}", port=self._port, properties=TEXT, server=f"radar-service-{self._port}.local.",
            parsed_addresses=addresses,
        )  # fmt: skip
        try:
            self._zeroconf = AsyncZeroconf(interfaces=InterfaceChoice.All if self._everywhere else addresses)
            await self._zeroconf.async_register_service(info, allow_name_change=True)
        except (OSError, Error) as error:
            log_event("not announced", logging.WARNING, option="--announce", reason=str(error))

    async def stop(self) -> None:
        """Says that the service goes."""
        if self._zeroconf is not None:
            await self._zeroconf.async_close()
