"""Garmin xHD: reports, spokes and commands by UDP, as software for that radar reads and sends them."""

from typing import TYPE_CHECKING

from radar_service.ports.dialect import DialectPackage

if TYPE_CHECKING:
    from radar_service.ports.dialect.dialect import Dialect


def _dialect() -> "Dialect":
    from radar_service.ports.garmin_xhd.datagrams import XHD

    return XHD


PORT = DialectPackage("garmin-xhd", "a Garmin xHD", _dialect)
