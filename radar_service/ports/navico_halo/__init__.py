"""Navico HALO, as software for that radar reads and commands it."""

from radar_service.ports.dialect import DialectPackage

PORT = DialectPackage("navico-halo", "a Navico HALO", f"{__name__}.datagrams:HALO")
