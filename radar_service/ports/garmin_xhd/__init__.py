"""Garmin xHD, as software for that radar reads and commands it."""

from typing import TYPE_CHECKING

from radar_service.ports.dialect import DialectPackage

if TYPE_CHECKING:
    from radar_service.ports.dialect.dialect import Dialect


def _dialect() -> "Dialect":
    from radar_service.ports.garmin_xhd.datagrams import XHD

    return XHD


PORT = DialectPackage("garmin-xhd", "a Garmin xHD", _dialect)
