"""Figures and lines: they say what happened, in forms that their readers accept, and nothing else."""

import asyncio
import io
import json
import logging
import sys

import pytest
from prometheus_client.parser import text_string_to_metric_families

from radar_service.stream import journal, wire
from radar_service.stream.app import create_app
from radar_service.stream.journal import JsonLines, Refusals, Words, note
from radar_service.stream.pace import Pace, Schedule
from radar_service.stream.station import Station
from radar_service.stream.transmitter import Settings
from tests.stream.asgi import Server, running
from tests.stream.fake import FakeEngine, factory, scene


async def figures(server: Server) -> dict[str, float]:
    """All samples, by name and labels; read by Prometheus's own parser."""
    answer = await server.http.get("/metrics")
    assert answer.headers["content-type"].startswith("text/plain")
    return {
        sample.name + "".join(f",{value}" for _, value in sorted(sample.labels.items())): sample.value
        for family in text_string_to_metric_families(answer.text)
        for sample in family.samples
    }


def test_metrics_count_what_the_clients_saw() -> None:
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
        now = await figures(server)
        assert now["radar_azimuths_total,0"] == 12 and now["radar_bytes_total,0"] == sum(len(wire.pack(m)) for m in got)
        assert now["radar_encode_seconds_count,f32,0"] == len(got) - 1 and now["radar_encode_seconds_sum,f32,0"] > 0
        assert (now["radar_clients,live,0"], now["radar_clients,lossless,0"], now["radar_views,0"]) == (1, 0, 1)
        assert now["radar_state,0,paused"] == 1 and now["radar_state,0,running"] == 0
        assert (now["radar_refused_total,origin"], now["radar_refused_total,feed request"]) == (1, 1)
        assert (now["radar_spokes_lost_total,0"], now["radar_gaps_total,0"], now["radar_restarts_total,0"]) == (0, 0, 0)
        assert now["process_resident_memory_bytes"] > 1e6

    async def whole() -> None:
        only = Station("0", FakeEngine(scene()), factory(), settings=Settings(pace=Pace("pause")))
        async with running(create_app([only])) as server:
            await test(server)

    asyncio.run(asyncio.wait_for(whole(), 20))


def test_lag_is_how_late_the_newest_spokes_are() -> None:
    schedule = Schedule()
    for now, simulated, lag in ((100.0, 0.0, 0.0), (100.1, 0.2, 0.0), (100.3, 0.2, 0.1), (100.2, 0.2, 0.0)):
        schedule.delay(now, simulated, 1.0)
        assert schedule.lag == pytest.approx(lag, abs=1e-9)


def lines(style: journal.Style, monkeypatch: pytest.MonkeyPatch) -> io.StringIO:
    out = io.StringIO()
    monkeypatch.setattr(sys, "stderr", out)
    monkeypatch.setattr(logging.getLogger(), "handlers", [])
    monkeypatch.setattr(logging.getLogger("radar_service"), "level", logging.INFO)
    for name in ("uvicorn", "uvicorn.error"):  # servers of other tests leave them quieter than a new process has them
        for attribute, value in (("level", logging.NOTSET), ("disabled", False), ("propagate", True), ("handlers", [])):
            monkeypatch.setattr(logging.getLogger(name), attribute, value)
    logging.getLogger("radar_service").manager._clear_cache()
    journal.write(style)
    return out


def test_json_lines_hold_an_event_each(monkeypatch: pytest.MonkeyPatch) -> None:
    out = lines("json", monkeypatch)
    note("client left", radar="0", lost=3)
    note("radar failed", logging.ERROR, reason='the "wheel"\ncame off')
    logging.getLogger("uvicorn.error").warning("plain %s", "words")
    first, second, third = map(json.loads, out.getvalue().splitlines())
    assert (first["event"], first["level"], first["radar"], first["lost"]) == ("client left", "info", "0", 3)
    assert second["reason"] == 'the "wheel"\ncame off' and second["level"] == "error"
    assert third["event"] == "plain words" and all("time" in line for line in (first, second, third))


def test_quiet_says_only_what_is_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    out = lines("quiet", monkeypatch)
    note("client joined", radar="0")
    note("radar failed", logging.ERROR, reason="wheel")
    assert out.getvalue() == "error: radar failed reason=wheel\n"


def test_a_flood_of_refusals_is_no_flood_of_lines(caplog: pytest.LogCaptureFixture) -> None:
    times = iter((0.0, 0.3, 0.6, 1.2, 1.3, 1.4))
    refusals = Refusals(lambda: next(times))
    with caplog.at_level(logging.INFO, "radar_service"):
        for reason in ("token",) * 5 + ("host",):
            refusals(reason)
    assert refusals.counts == {"token": 5, "host": 1}
    assert [Words().format(r) for r in caplog.records] == [
        "info: refused reason=token times=1", "info: refused reason=token times=3", "info: refused reason=host times=1",
    ]  # fmt: skip
    assert json.loads(JsonLines().format(caplog.records[0]))["event"] == "refused"
