"""The port of AIS: what the transponders of a scene report, each at its own times, by TCP and UDP."""

from collections.abc import Sequence

from radar_service.ports.ais.messages import ais_sentences, position_of, static_of
from radar_service.ports.ais.transponders import AisReport, Transponders
from radar_service.ports.nmea.nmea_port import SenderPort
from radar_service.ports.udp.udp_port import Sender


class AisPort(SenderPort):
    """AIVDM of the ships around the one that carries a radar, and its own AIVDO: of the first radar, or of `radar`."""

    name = "ais"

    def __init__(self, senders: Sequence[Sender], radar: str | None = None) -> None:
        super().__init__(senders, radar)
        self._transponders = Transponders()

    def tick(self, radar: str, time: float) -> None:
        """Sends the reports that are due."""
        if self.is_of(radar) and (station := self.station) is not None:
            reports = self._transponders.due(station, time, self.begins)
            self.send([line for report in reports for line in self._sentences(report)])

    def _sentences(self, report: AisReport) -> list[bytes]:
        kind, ship = "VDO" if report.is_own else "VDM", report.ship
        position = [] if report.position is None else [position_of(ship, report.position)]
        static = [bits for number, bits in enumerate(static_of(ship)) if number in report.static]
        groups = enumerate((position, static), report.number)  # parts share a channel
        return [line for number, messages in groups for bits in messages for line in ais_sentences(bits, kind, number)]
