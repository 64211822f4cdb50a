"""The service's metrics for Prometheus, read from the stations on request, and how its process fares. No label names a client."""

import asyncio
import shutil
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from prometheus_client import CollectorRegistry, ProcessCollector
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, Metric, SummaryMetricFamily
from prometheus_client.exposition import CONTENT_TYPE_LATEST, generate_latest
from prometheus_client.registry import Collector

from radar_service.ports.port_thread import PortThread
from radar_service.service import logs
from radar_service.service.jobs import JobQueue
from radar_service.service.radio.radio_state import State
from radar_service.service.radio.station import Station
from radar_service.service.radio.status import STATES, state
from radar_service.service.scene_request import Spared

LAG_PERIOD = 0.25  # s between two looks at the event loop
LAG_SAMPLES = 60  # the worst of the last 15 s is given: a reader of metrics comes every 15 s
POOL_SECONDS = 1.0  # until the pool of threads counts as stuck; the image's health check waits for 2 s
JOB_SECONDS = 900.0  # until a job counts as stuck: a scene may take 240 s after others before it
MIN_FREE_BYTES = 128 * 2**20  # of the disk: two uploads
CONTENT_TYPE = CONTENT_TYPE_LATEST
Read = Callable[[Station], float | None]  # None: not known yet
Family = CounterMetricFamily | GaugeMetricFamily
Value = tuple[Sequence[str], float | None]  # labels and number


class Vitals:
    """Watches the serving process. Belongs to the event loop.

    jobs: its queue of jobs; folder: where it stores uploads.
    """

    def __init__(self, jobs: JobQueue, folder: Path) -> None:
        self._jobs, self._folder = jobs, folder
        self._lags: deque[float] = deque(maxlen=LAG_SAMPLES)
        self._timer: asyncio.TimerHandle | None = None
        self._probe: asyncio.Task[int] | None = None

    @property
    def lag(self) -> float:
        """The longest delay of the event loop lately [s]."""
        return max(self._lags, default=0.0)

    @property
    def tasks(self) -> int:
        """Number of tasks on the event loop; read there."""
        return len(asyncio.all_tasks())

    @property
    def job_states(self) -> Counter[str]:
        """Number of jobs in each state."""
        return Counter({"waiting": 0, "running": 0} | Counter(job.state for job in self._jobs.jobs))

    def start(self) -> None:
        """Starts to watch the event loop."""
        loop = asyncio.get_running_loop()
        self._timer = loop.call_at(loop.time() + LAG_PERIOD, self._note_lag, loop.time() + LAG_PERIOD)

    def close(self) -> None:
        """Stops watching."""
        if self._timer:
            self._timer.cancel()

    async def problems(self, stations: Iterable[Station]) -> list[str]:
        """Returns what keeps the service from working, a line each."""
        lines = []
        for radio, station in ((each.transmitter.state, each) for each in stations):
            if not (radio.fault or radio.now is State.RESTARTING or station.transmitter.supervisor.worker.is_alive):
                lines.append(f"radar {station.identity}: its worker has died")
        if not await self._pool_works():
            lines.append(f"threads: none was free for {POOL_SECONDS:g} s")
        if any(job.state == "running" and job.as_dict()["seconds"] > JOB_SECONDS for job in self._jobs.jobs):
            lines.append(f"jobs: one has taken more than {JOB_SECONDS:g} s")
        if shutil.disk_usage(self._folder).free < MIN_FREE_BYTES:
            lines.append(f"disk: less than {MIN_FREE_BYTES / 2**20:.0f} MiB are free for uploads")
        return lines

    def _note_lag(self, due: float) -> None:
        self._lags.append(asyncio.get_running_loop().time() - due)
        self.start()

    async def _pool_works(self) -> bool:
        """Whether the default pool of threads does a task in time; one that does not keeps this one task."""
        if self._probe is None or self._probe.done():
            self._probe = asyncio.create_task(asyncio.to_thread(int))
        await asyncio.wait({self._probe}, timeout=POOL_SECONDS)
        return self._probe.done()


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
        lambda s: s.transmitter.pacer.group_clock.schedule.slips,
    ),
    "radar_restarts": (
        "Times that the engine failed and was started again", lambda s: s.transmitter.state.restarts,
    ),
}  # fmt: skip
GAUGES: dict[str, tuple[str, Read]] = {
    "radar_lag_seconds": ("How late the newest spokes were sent", lambda s: s.transmitter.pacer.group_clock.schedule.lag),
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
    """Families of metrics with their present values."""

    def __init__(self, families: Iterable[Metric]) -> None:
        self._families = families

    def collect(self) -> Iterable[Metric]:
        """Returns them."""
        return self._families


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
    registry.register(_Families([*_of_stations(stations, refused), *_of_ports(threads), *_of_service(vitals)]))
    ProcessCollector(registry=registry)
    return generate_latest(registry)
