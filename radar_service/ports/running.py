"""Puts radars, application and server together, and runs them until they are stopped."""

import argparse
import asyncio
import gc
import signal
from collections.abc import Callable, Sequence

from radar_service.ports.app import create_app
from radar_service.ports.http.server import MAX_CONNECTIONS, Requests, Server, configuration, listening_socket
from radar_service.ports.port import Port
from radar_service.ports.port_host import PortHost
from radar_service.processes.fork_server import ForkServer
from radar_service.processes.stop_signals import STOP_SIGNALS
from radar_service.service.access import Access
from radar_service.service.logs import Refusals
from radar_service.service.radio.radar_group import RadarGroup
from radar_service.service.radio.station import Station, Stations
from radar_service.service.scene_request import MakeSpokeSource, SceneSpokeSource
from radar_service.service.settings import Pace, Settings
from radar_service.service.spokes import whole_second


def run(
    options: argparse.Namespace, access: Access, scenes: Callable[[], Sequence[Sequence[SceneSpokeSource]]],
    make: MakeSpokeSource, fork_server: ForkServer, ports: Sequence[Port], station_type: type[Station] = Station,
) -> int:  # fmt: skip
    """Serves the radars of all scenes until stopped; returns the exit status. Raises OSError where it cannot listen,
    UndeclaredRoleError for a route of a port, SceneError where two radars have the same id, and UsageError where the options of
    a port do not suit the radars.

    options: of the command `serve`; scenes: waits for the radars of each scene, which prepare while the application is put
    together; make, fork_server: start further scenes and other processes.
    """
    refused, requests, stations, host = Refusals(), Requests(), Stations(), PortHost(ports)
    app = create_app(stations, host, fork_server=fork_server, access=access, refused=refused, requests=requests)
    config = configuration(app, connections=options.connections or MAX_CONNECTIONS, refused=refused)
    server = Server(config, stations.stop, requests)
    settings = Settings(pace=Pace("run", options.pace))
    start_utc = options.start_utc or whole_second()
    for number, radars in enumerate(scenes()):
        group = RadarGroup(number)
        for identity, radar in zip(group.identities_in(radars[0].info.scene), radars, strict=True):
            station = station_type(
                identity, radar, make, settings=settings, allow_truth=options.truth, group=group,
                wait_for=options.wait_for, sinks=host.sinks(identity), recorded=host.sources,
                start_utc=start_utc,
            )  # fmt: skip
            stations.add(station)
    host.check(stations)
    return _run(server, stations, options)


def _run(server: Server, stations: Stations, options: argparse.Namespace) -> int:
    listener = listening_socket(options.host, options.port)
    if options.exit_when_failed:
        for station in stations.values():
            station.failed = server.give_up
    for signal_number in STOP_SIGNALS:  # uvicorn stops at either, and raises it again after its end
        signal.signal(signal_number, lambda *_: server.stop())
    gc.freeze()  # objects that live as long as the service are not searched again and again, 50 ms at a time
    gc.enable()
    with asyncio.Runner(loop_factory=server.config.get_loop_factory()) as runner:
        runner.run(server.serve(sockets=[listener]))
    return 0 if server.started and not server.gave_up else 1
