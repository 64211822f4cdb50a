"""The service's metrics for Prometheus, read from the stations on request. No label names a client."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial

from prometheus_client import CollectorRegistry, ProcessCollector
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, Metric, SummaryMetricFamily
from prometheus_client.exposition import CONTENT_TYPE_LATEST, generate_latest
from prometheus_client.registry import Collector

from radar_service.ports.port_thread import PortThread
from radar_service.ports.rest.vitals import Vitals
from radar_service.service import logs
from radar_service.service.radio.station import Station
from radar_service.service.radio.status import STATES, state
from radar_service.service.scene_request import Spared

CONTENT_TYPE = CONTENT_TYPE_LATEST
Read = Callable[[Station], float | None]  # None: not known yet
Family = CounterMetricFamily | GaugeMetricFamily
Value = tuple[Sequence[str], float | None]  # labels and number


def _trees(station: Station) -> int | None:
    if station.epoch.is_blind:
        return None  # meshes have trees
    return source.trees if isinstance(source := station.epoch.spoke_source, Spared) else 0


COUNTERS: dict[str, tuple[str, Read]] = {
    "radar_azimuths": ("Spokes sent since the start", lambda s: s.transmitter.state.sent),
    "radar_spokes_lost": ("Spokes that slow clients lost, all together", lambda s: s.hub.totals().lost),
    "radar_gaps": ("Gaps announced to slow clients", lambda s: s.hub.totals().gaps),
    "radar_bytes": ("Bytes handed to sockets", lambda s: s.hub.totals().bytes),
    "radar_slips": (
        "Times that the engine was so late that the schedule started anew",
        lambda s: s.transmitter.pacer.schedule.slips,
    ),
    "radar_restarts": (
        "Times that the engine failed and was started again", lambda s: s.transmitter.state.restarts,
    ),
}  # fmt: skip
GAUGES: dict[str, tuple[str, Read]] = {
    "radar_lag_seconds": ("How late the newest spokes were sent", lambda s: s.transmitter.pacer.schedule.lag),
    "radar_real_time_factor": (
        "Simulated seconds per second over the last seconds", lambda s: s.transmitter.pacer.reached(),
    ),
    "radar_factor_asked": (
        "Simulated seconds per second that are requested; infinite for as fast as possible",
        lambda s: s.settings.pace.factor,
    ),
    "radar_queued_messages": (
        "Messages that clients have not taken, all together", lambda s: sum(c.queued for c in list(s.hub.clients)),
    ),
    "radar_views": ("Different views that are encoded", lambda s: len(s.hub.views)),
    "radar_trees": ("Trees for ray tests that its world process holds", _trees),
}  # fmt: skip


class _Families(Collector):
    """The families of metrics that some functions yield."""

    def __init__(self, *families: Callable[[], Iterator[Metric]]) -> None:
        self._families = families

    def collect(self) -> Iterator[Metric]:
        """Yields each family of metrics with its present values."""
        for each in self._families:
            yield from each()


def _of_stations(stations: Sequence[Station], refused: Mapping[str, int]) -> Iterator[Metric]:
    for families, kind in ((COUNTERS, CounterMetricFamily), (GAUGES, GaugeMetricFamily)):
        for name, (text, read) in families.items():
            values = [((station.identity,), read(station)) for station in stations]
            yield _labelled(kind(name, text, labels=["radar"]), values)
    clients, states = list[Value](), list[Value]()
    for station in stations:
        modes, now = [client.mode for client in list(station.hub.clients)], state(station)
        clients += [((station.identity, mode), modes.count(mode)) for mode in ("live", "lossless")]
        states += [((station.identity, name), float(name == now)) for name in STATES]
    yield _labelled(GaugeMetricFamily("radar_clients", "Clients of the feed", labels=["radar", "mode"]), clients)
    text = "1 for the state that the radar is in"
    yield _labelled(GaugeMetricFamily("radar_state", text, labels=["radar", "state"]), states)
    family = SummaryMetricFamily("radar_encode_seconds", "Encoding a batch for a view", labels=["radar", "encoding"])
    for station in stations:
        for encoding, (count, seconds) in sorted(station.feed.timings.items()):
            family.add_metric([station.identity, encoding], count, seconds)
    yield family
    yield _by_reason("radar_refused", "Connections and requests that were refused", refused)


def _of_service(vitals: Vitals) -> Iterator[Metric]:
    yield GaugeMetricFamily(
        "radar_event_loop_lag_seconds", "Longest delay of the event loop in the last 15 s", value=vitals.lag
    )
    yield GaugeMetricFamily("radar_tasks", "Tasks on the event loop", value=vitals.tasks)
    jobs = [((job_state,), count) for job_state, count in vitals.job_states.items()]
    yield _labelled(GaugeMetricFamily("radar_jobs", "Jobs by their state", labels=["state"]), jobs)
    yield _by_reason("radar_log_lines_dropped", "Log lines that were not written", logs.dropped())


def _of_ports(threads: Sequence[PortThread]) -> Iterator[Metric]:
    faults = CounterMetricFamily("radar_port_faults", "Calls of a port that have failed", labels=["port"])
    yield _labelled(faults, [((thread.name,), thread.faults) for thread in threads])
    text = "Spokes, sentences and other calls that a port, or its network, was too slow for"
    dropped = CounterMetricFamily("radar_port_dropped", text, labels=["port"])
    yield _labelled(dropped, [((thread.name,), thread.dropped) for thread in threads])


def _by_reason(name: str, text: str, counts: Mapping[str, int]) -> Metric:
    """A family of counters, one for each reason."""
    family = CounterMetricFamily(name, text, labels=["reason"])
    return _labelled(family, [((reason,), count) for reason, count in list(counts.items())])


def _labelled(family: Family, values: Sequence[Value]) -> Family:
    """A family with values by their labels, those that are known."""
    for labels, value in values:
        if value is not None:
            family.add_metric(labels, value)
    return family


def exposition(
    stations: Sequence[Station], refused: Mapping[str, int], vitals: Vitals, threads: Sequence[PortThread] = ()
) -> bytes:
    """Returns all metrics, those of the process too, in the format of Prometheus. threads: of the ports."""
    registry = CollectorRegistry()
    families = partial(_of_stations, stations, refused), partial(_of_ports, threads), partial(_of_service, vitals)
    registry.register(_Families(*families))
    ProcessCollector(registry=registry)
    return generate_latest(registry)
