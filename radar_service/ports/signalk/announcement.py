"""Tells by mDNS where the service is, for mayara_pi and others."""

import contextlib
import logging
import socket
from typing import TYPE_CHECKING

from radar_service.service.logs import log_event
from radar_service.terminal import UsageError, extra

if TYPE_CHECKING:
    from zeroconf.asyncio import AsyncZeroconf

KIND = "_signalk-http._tcp.local."
TEXT = {"txtvers": "1", "roles": "master, main", "swname": "radar-service", "self": "simulated"}


class Announcement:
    """An announcement of a port on the interface of an address. A network that fails is logged."""

    def __init__(self, host: str, port: int) -> None:
        """host: of the service, in IPv4 or its name. Raises UsageError and MissingExtra."""
        with extra("announce", "announcements"):
            import zeroconf.asyncio  # noqa: F401
        if port == 0:
            raise UsageError("--announce: others need to know the port; give --port, as 8000")
        self._port, self._address = port, ""
        with contextlib.suppress(OSError):
            self._address = socket.gethostbyname(host)
        if self._address in ("", "0.0.0.0"):
            raise UsageError(f"--announce: {host} is no address of IPv4 for others; give one of this machine as --host")
        self._zeroconf: AsyncZeroconf | None = None

    async def start(self) -> None:
        """Begins to announce."""
        from zeroconf import Error, ServiceInfo
        from zeroconf.asyncio import AsyncZeroconf

        info = ServiceInfo(
            KIND, f"Simulated radar, port {self._port}.{KIND}", port=self._port, properties=TEXT,
            server=f"radar-service-{self._port}.local.", parsed_addresses=[self._address],
        )  # fmt: skip
        try:
            self._zeroconf = AsyncZeroconf(interfaces=[self._address])
            await self._zeroconf.async_register_service(info, allow_name_change=True)
        except (OSError, Error) as error:
            log_event("not announced", logging.WARNING, option="--announce", reason=str(error))

    async def stop(self) -> None:
        """Says that the service goes."""
        if self._zeroconf is not None:
            await self._zeroconf.async_close()
