"""The service's figures for Prometheus, read from the stations when somebody asks. No label names a client."""

from collections.abc import Iterator, Mapping, Sequence

from prometheus_client import CollectorRegistry, ProcessCollector
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, Metric, SummaryMetricFamily
from prometheus_client.exposition import CONTENT_TYPE_LATEST, generate_latest
from prometheus_client.registry import Collector

from radar_service.stream.station import Station

CONTENT_TYPE = CONTENT_TYPE_LATEST
STATES = ("running", "behind", "paused", "standby", "restarting", "failed")

COUNTERS = {
    "radar_azimuths": "Spokes sent since the start",
    "radar_spokes_lost": "Spokes that slow clients lost, all together",
    "radar_gaps": "Gaps announced to slow clients",
    "radar_bytes": "Bytes handed to sockets",
    "radar_slips": "Times that the engine was so late that the schedule started afresh",
    "radar_restarts": "Times that the engine died and was started again",
}
GAUGES = {
    "radar_lag_seconds": "How late the newest spokes went out",
    "radar_real_time_factor": "Simulated seconds per second over the last seconds",
    "radar_factor_asked": "Simulated seconds per second that are asked for; infinite for as fast as possible",
    "radar_views": "Different views that are encoded",
}


class Figures(Collector):
    """All figures of some stations. refused: how often what was refused."""

    def __init__(self, stations: Sequence[Station], refused: Mapping[str, int]) -> None:
        self._stations, self._refused = stations, refused

    def collect(self) -> Iterator[Metric]:
        """Each family of figures, as they stand."""
        read = [(station, station.figures()) for station in self._stations]
        for families, kind in ((COUNTERS, CounterMetricFamily), (GAUGES, GaugeMetricFamily)):
            for name, text in families.items():
                family = kind(name, text, labels=["radar"])
                for station, figures in read:
                    if (value := figures[name]) is not None:
                        family.add_metric([station.identity], value)
                yield family
        yield self._clients()
        yield self._states()
        yield self._encoding()
        refusals = CounterMetricFamily("radar_refused", "Connections and requests turned away", labels=["reason"])
        for reason, count in list(self._refused.items()):
            refusals.add_metric([reason], count)
        yield refusals

    def _clients(self) -> Metric:
        family = GaugeMetricFamily("radar_clients", "Clients of the feed", labels=["radar", "mode"])
        for station in self._stations:
            modes = [client.mode for client in station.hub.clients]
            for mode in ("live", "lossless"):
                family.add_metric([station.identity, mode], modes.count(mode))
        return family

    def _states(self) -> Metric:
        family = GaugeMetricFamily("radar_state", "1 for the state that the radar is in", labels=["radar", "state"])
        for station in self._stations:
            now = station.state()
            for state in STATES:
                family.add_metric([station.identity, state], float(state == now))
        return family

    def _encoding(self) -> Metric:
        family = SummaryMetricFamily("radar_encode_seconds", "Encoding a batch for a view", labels=["radar", "encoding"])
        for station in self._stations:
            for encoding, (count, seconds) in sorted(station.transmitter.encoding.items()):
                family.add_metric([station.identity, encoding], count, seconds)
        return family


def exposition(stations: Sequence[Station], refused: Mapping[str, int]) -> bytes:
    """All figures as Prometheus reads them, those of the process too."""
    registry = CollectorRegistry()
    registry.register(Figures(stations, refused))
    ProcessCollector(registry=registry)
    return generate_latest(registry)
