"""Metrics: they count what clients saw, in the format that Prometheus reads."""

from prometheus_client.parser import text_string_to_metric_families

from radar_service import wire
from radar_service.ports.app import create_app
from radar_service.service.radio.station import Station
from radar_service.service.settings import Pace, Settings
from tests.ports.asgi import Server, running
from tests.service.fake import FakeEngine, factory, scene


async def figures(server: Server) -> dict[str, float]:
    """All samples, by name and labels; read by Prometheus's own parser."""
    answer = await server.http.get("/metrics")
    assert answer.headers["content-type"].startswith("text/plain")
    return {
        sample.name + "".join(f",{value}" for _, value in sorted(sample.labels.items())): sample.value
        for family in text_string_to_metric_families(answer.text)
        for sample in family.samples
    }


async def test_metrics_count_what_the_clients_saw() -> None:
    async def test(server: Server) -> None:
        feed = await server.feed("?encoding=f32")
        got = [await feed.receive()]
        await server.http.patch("/api/radars/0/controls", json={"pace": {"state": "step", "steps": 12}})
        while sum(message.get("count", 0) for message in got) < 12:
            got.append(await feed.receive())
        await server.http.get("/api/radars/0", headers={"origin": "http://elsewhere"})
        assert (await server.http.patch("/api/radars/0/controls", headers={"origin": "http://else"})).status_code == 403
        refused = await server.feed("?encoding=f31")
        await refused.until("bye")
        while (now := await figures(server))["radar_azimuths_total,0"] < 12:  # counted a moment after they were sent
            continue
        assert now["radar_azimuths_total,0"] == 12 and now["radar_bytes_total,0"] == sum(len(wire.pack(m)) for m in got)
        assert now["radar_encode_seconds_count,f32,0"] == len(got) - 1 and now["radar_encode_seconds_sum,f32,0"] > 0
        assert (now["radar_clients,live,0"], now["radar_clients,lossless,0"], now["radar_views,0"]) == (1, 0, 1)
        assert now["radar_state,0,paused"] == 1 and now["radar_state,0,running"] == 0
        assert (now["radar_refused_total,origin"], now["radar_refused_total,feed request"]) == (1, 1)
        assert (now["radar_spokes_lost_total,0"], now["radar_gaps_total,0"], now["radar_restarts_total,0"]) == (0, 0, 0)
        assert (now["radar_factor_asked,0"], now["radar_lag_seconds,0"]) == (1, 0)
        assert now["radar_event_loop_lag_seconds"] >= 0 and now["radar_trees,0"] == 3
        assert now["radar_tasks"] >= 2  # the client of the feed and this request
        assert (now["radar_jobs,running"], now["radar_jobs,waiting"], now["radar_queued_messages,0"]) == (0, 0, 0)
        assert now["radar_log_lines_dropped_total,queue"] >= 0 and now["radar_log_lines_dropped_total,repeated"] >= 0
        assert now["radar_port_faults_total,rest"] == now["radar_port_dropped_total,rest"] == 0
        assert now["process_resident_memory_bytes"] > 1e6

    only = Station("0", FakeEngine(scene()), factory(), settings=Settings(pace=Pace("pause")))
    async with running(create_app([only])) as server:
        await test(server)
