"""Garmin xHD, as software for that radar reads and commands it."""

from radar_service.ports.dialect import DialectPackage

PORT = DialectPackage("garmin-xhd", "a Garmin xHD", f"{__name__}.datagrams:XHD")
