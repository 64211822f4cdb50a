"""The short modules of REST, each under its name."""

import asyncio
import contextlib
import errno
import fcntl
import gc
import json
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import AsyncIterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from fastapi import FastAPI
from prometheus_client.parser import text_string_to_metric_families
from pydantic import ValidationError

from radar_service import wire
from radar_service.plug_ins import PlugInError
from radar_service.ports.feed.feed_socket import FeedPort
from radar_service.ports.port_host import PortHost
from radar_service.ports.rest import metrics, pictures, scene_store
from radar_service.ports.rest.answers import add_exception_handlers, problem_lines
from radar_service.ports.rest.metrics import Vitals
from radar_service.ports.rest.pictures import Pictures
from radar_service.ports.rest.rest_port import RestPort
from radar_service.ports.rest.scene_store import Conflict, OwnedFolder, SceneStore
from radar_service.ports.rest.schemas import ControlsChange, ControlsState
from radar_service.processes.call import ProcessFault
from radar_service.processes.fork_server import ForkServer
from radar_service.processes.limits import MachineBusyError
from radar_service.records.fidelity import PRESETS
from radar_service.service.controls import CONTROLS, ControlError
from radar_service.service.jobs import RETRY_SECONDS, Busy, JobQueue
from radar_service.service.radio.command_worker import NoRadarError, TooManyCommandsError
from radar_service.service.radio.radio_state import Failed, Looked
from radar_service.service.radio.scene_process import SpokeWorker
from radar_service.service.settings import Pace, Settings
from radar_service.spoke_source import BusyFault, SpokeSourceFault
from radar_service.world.error import SceneError
from tests.ports.asgi import Closed, Server, Socket, running
from tests.ports.playing import playing, station
from tests.scenes import TWO_RADARS
from tests.service.fake import AZIMUTHS, FakeEngine, scene


# schemas: bodies of REST: controls with the limits of their declaration, and nothing unknown.
@pytest.mark.parametrize("control", [c for c in CONTROLS if c.kind == "number"], ids=lambda control: control.name)
def test_numbers_have_the_limits_of_their_control(control: Any) -> None:
    for limit, beyond in ((control.minimum, -1.0), (control.maximum, 1.0)):
        if limit is not None:
            assert getattr(ControlsChange.model_validate({control.name: limit}), control.name) == limit
            with pytest.raises(ValidationError):
                ControlsChange.model_validate({control.name: limit + beyond * 1e-3})
    with pytest.raises(ValidationError):
        ControlsChange.model_validate({control.name: float("nan")})


def test_what_is_not_given_is_not_changed() -> None:
    assert ControlsChange().model_dump(exclude_none=True) == {}
    with pytest.raises(ValidationError):
        ControlsChange.model_validate({"colour": "red"})


def test_the_schemas_show_descriptions_and_examples_of_the_controls() -> None:
    properties = ControlsChange.model_json_schema()["properties"]
    assert {name: field["description"] for name, field in properties.items()} == {c.name: c.description for c in CONTROLS}
    example = ControlsState.model_json_schema()["examples"][0]
    assert ControlsState.model_validate(example).model_dump() == example


# scene_store: the store of scenes: bounded, and gone with the server.
async def test_the_number_of_uploads_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scene_store, "MAX_UPLOADS", 1)
    async with playing() as server:
        for name, status in (("a", 201), ("a", 201), ("b", 409)):
            assert (await server.http.post("/api/scenes", json={"name": name, "scene": {"name": "s"}})).status_code == status


async def test_uploads_go_with_the_server() -> None:
    async with playing(ports=PortHost((rest := RestPort(), FeedPort()))) as server:
        await server.http.post("/api/scenes", json={"name": "mine", "scene": {"name": "s"}})
    assert not rest.store.home.exists()


async def test_a_scene_of_several_radars_is_summed_up_by_its_first(tmp_path: Path) -> None:
    (tmp_path / "two.json").write_text(json.dumps(TWO_RADARS))
    async with playing(ports=PortHost((RestPort([tmp_path]), FeedPort()))) as server:
        await server.http.post("/api/scenes", json={"name": "mine", "scene": TWO_RADARS})
        listed = {scene["name"]: scene["summary"] for scene in (await server.http.get("/api/scenes")).json()}
        assert listed["two"] == "2 radars, the first: 2 bodies, 600 m, 60 rpm"
        assert listed["mine"] == "2 radars, the first: 1 bodies, 600 m, 60 rpm"  # of those that it sees
        assert listed["harbour"].count("radar") == 0


# metrics: metrics: they count what clients saw, in the format that Prometheus reads.
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
    async with playing() as server:
        feed = await server.feed("?encoding=f32")
        got = [await feed.receive()]
        await server.step(12)
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


# answers: refusals as answers: a line for each problem.
def failing(*errors: Exception) -> FastAPI:
    """An application whose path /N raises error N."""
    app = FastAPI()
    add_exception_handlers(app)

    @app.get("/{number}")
    async def fail(number: int) -> None:
        raise errors[number]

    return app


async def test_each_error_has_its_status_and_its_lines() -> None:
    cases: list[tuple[Exception, int, list[str]]] = [
        (SceneError("a: bad", "b: bad"), 422, ["a: bad", "b: bad"]), (ControlError("gain: 140"), 422, ["gain: 140"]),
        (SpokeSourceFault("it broke"), 422, ["scene: it broke"]), (PlugInError("it is broken"), 422, ["scene: it is broken"]),
        (Conflict("it is full"), 409, ["it is full"]), (NoRadarError("it has stopped"), 409, ["it has stopped"]),
    ]  # fmt: skip
    async with running(failing(*(error for error, _, _ in cases))) as server:
        for number, (_, status, lines) in enumerate(cases):
            answer = await server.http.get(f"/{number}")
            assert (answer.status_code, answer.json()) == (status, {"detail": lines})


async def test_what_is_to_be_tried_again_says_when() -> None:
    full = OSError(errno.EMFILE, "x"), OSError(errno.ENFILE, "x")
    errors = [*full, MachineBusyError("x"), BusyFault("x"), Busy("x"), TooManyCommandsError("x")]
    async with running(failing(*errors)) as server:
        for number, error in enumerate(errors):
            answer = await server.http.get(f"/{number}")
            assert answer.status_code == 503 and answer.headers["retry-after"] == str(RETRY_SECONDS), error
            if error in full:
                assert answer.json()["detail"][0].startswith("request: the server has no file descriptors left; ")


def test_lines_name_the_key_the_value_and_the_problem() -> None:
    errors = [
        {"loc": ("body", "pace", "factor"), "input": 0, "msg": "too small"},
        {"loc": ("query",), "input": "x" * 100, "msg": "too long"},
    ]
    assert problem_lines(errors) == ["pace.factor: 0; too small", "body: too long"]
    assert len(problem_lines([errors[0]] * 30)) == 20


# websockets: the websocket of the truth: JSON Lines in step with the feed, and refusals with a reason.
PATH = "/api/radars/0/truth/stream"


async def line(socket: Socket) -> dict[str, Any]:
    return dict(json.loads(await socket.text()))


async def test_lines_come_in_step_with_the_spokes() -> None:
    async with playing(station(allow_truth=True)) as server:
        truth, feed = await server.open(PATH), await server.feed()
        assert (await line(truth))["type"] == "header"
        await server.step(AZIMUTHS // 2)
        await feed.spokes(AZIMUTHS // 2)
        first = await line(truth)
        assert (first["type"], first["spoke"], first["scan"]) == ("crossing", 8, 0)
        await server.step(AZIMUTHS - AZIMUTHS // 2)
        assert [(await line(truth))["type"] for _ in range(2)] == ["crossing", "snapshot"]


async def test_the_power_of_bodies_is_asked_for_by_the_address() -> None:
    async with playing(station(allow_truth=True)) as server:
        truth, feed = await server.open(f"{PATH}?radiometric=1"), await server.feed()
        assert (await line(truth))["type"] == "header"
        await server.step(AZIMUTHS)
        await feed.spokes(AZIMUTHS)
        assert (await line(truth))["snr_db"] == 20.0
        wrong = await server.open(f"{PATH}?radiometric=yes")
        assert (await line(wrong))["reason"] == 'radiometric: "yes" is not 0 or 1; leave it out for 0'
        with pytest.raises(Closed) as closed:
            await wrong.text()
        assert closed.value.code == 4400


async def test_the_specification_as_printed_has_no_power_to_tell() -> None:
    engine = FakeEngine(scene())
    engine.fidelity = PRESETS["documented"]
    async with playing(station(engine, allow_truth=True)) as server:
        reason = (await line(await server.open(f"{PATH}?radiometric=1")))["reason"]
        assert reason.startswith("radiometric: the fidelity documented has none")
        assert (await line(await server.open(PATH)))["type"] == "header"


async def test_a_server_that_stops_says_bye() -> None:
    only = station(allow_truth=True)
    async with playing(only) as server:
        socket = await server.open(PATH)
        await line(socket)
        only.truth_stream.end("the server is stopping")
        assert await line(socket) == {"type": "bye", "reason": "the server is stopping"}


# metrics: what keeps the service from working makes it unready, and says so.
READY = "/api/health/ready"


async def test_a_working_server_has_no_problems() -> None:
    async with playing() as server:
        answer = await server.http.get(READY)
        assert answer.status_code == 200 and answer.json() == {"yes": True}


class CountingPool(ThreadPoolExecutor):
    """Two threads, and how many tasks they were given."""

    def __init__(self) -> None:
        super().__init__(2)
        self.tasks = 0

    def submit(self, *task: Any, **more: Any) -> Any:
        self.tasks += 1
        return super().submit(*task, **more)


async def test_a_stuck_pool_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(metrics, "POOL_SECONDS", 0.05)
    release = threading.Event()
    async with playing() as server:
        asyncio.get_running_loop().set_default_executor(pool := CountingPool())
        held = [asyncio.create_task(asyncio.to_thread(release.wait, 10)) for _ in range(2)]
        await asyncio.sleep(0)
        for _ in range(3):
            answer = await server.http.get(READY)
            assert answer.status_code == 503 and answer.json()["problems"] == ["threads: none was free for 0.05 s"]
        assert pool.tasks == 3  # probes do not pile up
        release.set()
        await asyncio.gather(*held)
        monkeypatch.setattr(metrics, "POOL_SECONDS", 10.0)
        assert (await server.http.get(READY)).status_code == 200


async def test_a_full_disk_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    async with playing() as server:
        monkeypatch.setattr(metrics, "MIN_FREE_BYTES", 2**80)
        answer = await server.http.get(READY)
        assert answer.status_code == 503 and answer.json()["problems"][0].startswith("disk: less than")


async def test_a_dead_worker_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    async with playing(station()) as server:
        monkeypatch.setattr(SpokeWorker, "is_alive", False)
        answer = await server.http.get(READY)
        assert answer.status_code == 503 and answer.json()["problems"] == ["radar 0: its worker has died"]


async def test_a_radar_whose_engine_is_made_anew_or_that_has_failed_lacks_no_worker(tmp_path: Path) -> None:
    watched, only = Vitals(JobQueue(), tmp_path), station()
    state, dead = only.transmitter.state, ["radar 0: its worker has died"]
    problems = [await watched.problems([only])]
    look = Looked(0.0, only.transmitter.pacer.run_control())
    for events in (4 * [Failed("it broke", 0.0)], [look]):
        for event in events:
            state.handle(event)
        problems.append(await watched.problems([only]))
    assert problems == [dead, [], []]


async def test_a_job_that_does_not_end_is_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(metrics, "JOB_SECONDS", -1.0)
    started, release = threading.Event(), threading.Event()
    queue = JobQueue()
    watched = Vitals(queue, tmp_path)
    assert await watched.problems(()) == []
    job = asyncio.create_task(queue.run("test", lambda _: (started.set(), release.wait(10))))
    await asyncio.to_thread(started.wait, 10)
    assert await watched.problems(()) == ["jobs: one has taken more than -1 s"]
    assert watched.job_states == {"waiting": 0, "running": 1}
    release.set()
    await job
    queue.close()


async def test_a_blocked_event_loop_shows_as_lag(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(metrics, "LAG_PERIOD", 0.01)
    watched = Vitals(JobQueue(), tmp_path)
    assert watched.lag == 0.0
    watched.start()
    until = time.monotonic() + 0.2
    while time.monotonic() < until:  # blocks the loop
        continue
    while watched.lag == 0.0:
        await asyncio.sleep(0.001)
    assert 0.18 < watched.lag < 60.0  # s: 0.2 less the period, and what else the machine does
    watched.close()


async def test_a_task_that_is_left_behind_is_counted(tmp_path: Path) -> None:
    watched = Vitals(JobQueue(), tmp_path)
    before = watched.tasks
    left = asyncio.create_task(asyncio.Event().wait())
    assert watched.tasks == before + 1
    left.cancel()


# pictures: drawn once for all who request the same, a few a second, in a process.
@contextlib.asynccontextmanager
async def drawing_pictures(fork_server: ForkServer, pauses: list[float] | None = None) -> AsyncIterator[Pictures]:
    drawing = Pictures(fork_server, [].append if pauses is None else pauses.append)
    try:
        yield drawing
    finally:
        drawing.close()


async def test_equal_pictures_are_drawn_once(fork_server: ForkServer) -> None:
    radar = station()
    async with drawing_pictures(fork_server) as drawing:
        both = await asyncio.gather(*(drawing.png(radar, 64, None) for _ in range(8)))
        assert len(set(both)) == 1 and both[0].startswith(b"\x89PNG")
        assert await drawing.png(radar, 64, None) is both[0]
        assert await drawing.png(radar, 65, None) != both[0]


def test_a_running_radar_has_a_picture_for_each_revolution_and_a_paused_one_for_each_spoke() -> None:
    paused, running = station(), station(settings=Settings(pace=Pace()))
    for radar, moments in ((paused, 3), (running, 2)):
        seen = set()
        for spokes in (1, 2, 24):
            seen.add(pictures.moment(radar, replace(radar.last_scan.read(), next=spokes)))
        assert len(seen) == moments


async def test_different_ones_are_drawn_at_a_bounded_rate_and_too_many_are_refused(
    fork_server: ForkServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    radar, pauses, begun = station(), list[float](), threading.Event()
    monkeypatch.setattr(pictures, "call_in_process", lambda *_: b"drawn" if begun.wait(10) else b"")
    async with drawing_pictures(fork_server, pauses) as drawing:
        tasks = [asyncio.create_task(drawing.png(radar, 64 + n, None)) for n in range(6)]
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)  # the one that is refused
        begun.set()
        answers = await asyncio.gather(*tasks, return_exceptions=True)
        assert [isinstance(answer, Busy) for answer in answers] == [False] * 5 + [True]  # one is drawn, four wait
    assert pauses[0] == 0.0 and all(0.0 <= pause <= 1 / pictures.MAX_PER_SECOND for pause in pauses) and len(pauses) == 5


async def test_a_picture_that_fails_is_drawn_again(fork_server: ForkServer, monkeypatch: pytest.MonkeyPatch) -> None:
    radar, times = station(), list[int]()

    def fail_once(*_: object) -> bytes:
        times.append(1)
        if len(times) == 1:
            raise ProcessFault("it crashed")
        return b"drawn"

    monkeypatch.setattr(pictures, "call_in_process", fail_once)
    async with drawing_pictures(fork_server) as drawing:
        with pytest.raises(ProcessFault):
            await drawing.png(radar, 64, None)
        assert await drawing.png(radar, 64, None) == b"drawn"


# scene_store: folders of living owners stay, those of dead ones go.
PREFIX = "owned-"
OWNER = f"""
import sys
from radar_service.ports.rest.scene_store import OwnedFolder
folder = OwnedFolder({PREFIX!r})
(folder.path / "upload").write_text("some")
print(folder.path, flush=True)
sys.stdin.read()
"""


@pytest.fixture
def temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder for temporary ones of its own."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    return tmp_path


def test_what_a_killed_process_has_left_goes_at_the_next_start(temporary: Path) -> None:
    with subprocess.Popen([sys.executable, "-c", OWNER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as owner:
        assert owner.stdout
        left = Path(owner.stdout.readline().strip())
        assert OwnedFolder(PREFIX).path != left and (left / "upload").is_file()  # its owner lives
        owner.kill()
        owner.wait()
        assert left.is_dir()
        folder = OwnedFolder(PREFIX)
        assert list(temporary.iterdir()) == [folder.path]


def test_the_store_of_scenes_removes_what_is_left(temporary: Path) -> None:
    (temporary / "radar-scenes-dead" / "upload").mkdir(parents=True)
    stores = [SceneStore([]) for _ in range(3)]
    assert {*temporary.iterdir()} == {store.home for store in stores}
    stores[1].close()
    assert {*temporary.iterdir()} == {stores[0].home, stores[2].home}


def test_folders_of_others_and_what_is_no_folder_stay(temporary: Path) -> None:
    target = temporary / "target"
    target.mkdir()
    (target / "kept").touch()
    (temporary / f"{PREFIX}link").symlink_to(target)
    (temporary / f"{PREFIX}file").touch()
    folder = OwnedFolder(PREFIX)
    assert (target / "kept").is_file() and len(list(temporary.iterdir())) == 4
    folder.close()
    folder.close()
    assert not folder.path.exists()


def test_a_folder_that_nobody_closes_goes_with_its_object(temporary: Path) -> None:
    folder = OwnedFolder(PREFIX)
    del folder
    gc.collect()
    assert not list(temporary.iterdir())


def test_a_folder_that_another_process_removes_before_it_is_locked_is_made_again(
    temporary: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make, made = tempfile.mkdtemp, []

    def removed_once(**options: str) -> str:
        made.append(make(**options))
        if len(made) == 1:
            Path(made[0]).rmdir()
        return made[-1]

    monkeypatch.setattr(tempfile, "mkdtemp", removed_once)
    assert str(OwnedFolder(PREFIX).path) == made[1] and len(made) == 2


def test_a_system_without_locks_removes_nothing(temporary: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise OSError(errno.ENOLCK, "no locks")

    monkeypatch.setattr(fcntl, "flock", refuse)
    folders = [OwnedFolder(PREFIX), OwnedFolder(PREFIX)]
    assert {*temporary.iterdir()} == {folder.path for folder in folders}
