"""Navico HALO, as software for that radar reads and commands it."""

from typing import TYPE_CHECKING

from radar_service.ports.dialect import DialectPackage

if TYPE_CHECKING:
    from radar_service.ports.dialect.dialect import Dialect


def _dialect() -> "Dialect":
    from radar_service.ports.navico_halo.datagrams import HALO

    return HALO


PORT = DialectPackage("navico-halo", "a Navico HALO", _dialect)
