"""Processes that compute tiles side by side: the bytes of one, whatever is asked, commanded, killed or given up meanwhile."""

import contextlib
import os
import select
import signal
import socket
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from hashlib import sha256
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.engine import pipeline
from radar_service.numerics.parallel import BLAS_LIMIT
from radar_service.processes.channel import CAN_FORK, Channel
from radar_service.records.spokes import SpokeBlock
from radar_service.simulation import tile_processes
from radar_service.simulation.engine_set_up import SourceTile
from radar_service.simulation.tile_processes import Computed, TileRequest, TileSender
from tests.scenes import point, scene

pytestmark = pytest.mark.skipif(not CAN_FORK, reason="this system does not fork processes with libraries that have threads")

PATIENCE = 60.0  # s after which a test that waits for another process fails
RADAR = {"azimuths": 128, "beamwidth_deg": 6, "range_max_m": 450, "pulse_s": 1e-6}
BODIES = [point("p", 100, 200, speed_kn=10), point("q", -100, 200, speed_kn=5, course_deg=90), point("r", -50, -300)]
ENVIRONMENT = {"noise": True}
TWO = [{"modulation": "none", "pulse_s": 8e-8, "range_max_m": 300}, {"pulse_s": 1e-6}]
OWN_SHIP = {"steerable": {"max_speed_kn": 30}, "speed_kn": 10}
MADE = scene(BODIES, radar=RADAR, environment=ENVIRONMENT, own_ship=OWN_SHIP)
AT_SEA = scene(BODIES, radar=RADAR, environment=ENVIRONMENT | {"sea_state": 3}, own_ship=OWN_SHIP)
STITCHED = scene(BODIES, radar={name: value for name, value in RADAR.items() if name != "pulse_s"} | {"pulses": TWO},
                 environment=ENVIRONMENT)  # fmt: skip


def simulator(threads: int, made: rs.Scene = MADE, **more: Any) -> rs.Simulator:
    return rs.Simulator(made, "fast", 3, threads, **more)


def digest(blocks: Iterable[SpokeBlock]) -> str:
    """Of all that blocks have, however they are grouped."""
    result = sha256()
    for block in blocks:
        for k in range(len(block)):
            result.update(block.field[k].tobytes() + block.power[k].tobytes())
            result.update(b"" if block.labels is None else block.labels[k].tobytes())
            result.update(
                b"".join(number.to_bytes(4) + power[k].tobytes() for number, power in (block.powers or {}).items())
            )
    return result.hexdigest()


def fail(patch: pytest.MonkeyPatch, errors: dict[int, Exception | None]) -> None:
    """Lets tiles, by their first azimuths, raise an error, or hang for ever."""
    original = pipeline.profiles

    def failing(prepared: Any, azimuths: Any, *more: Any) -> Any:
        first = int(azimuths.number[0])
        if error := errors.get(first):
            raise error
        return original(prepared, azimuths, *more) if first not in errors else select.select([], [], [])

    patch.setattr(pipeline, "profiles", failing)


def in_a_copy(work: Callable[[], str]) -> str:
    """What work returns in a copy of this process, as text."""
    reading, writing = os.pipe()
    if not os.fork():
        try:
            os.write(writing, work().encode())
        finally:
            os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as pipe:
        text = pipe.read()
    os.wait()
    return text


@cache
def alone(scans: int = 1, first: int = 0) -> str:
    """The digest of scans of one process, from the first on."""
    sim = simulator(1)
    sim.skip_to(first)
    return digest(sim.blocks(scans=scans))


def has_ended(process: int) -> bool:
    """Waits for the end of a process."""
    try:
        handle = os.pidfd_open(process)
    except ProcessLookupError:
        return True
    poll = select.poll()
    poll.register(handle, select.POLLIN)
    ended = bool(poll.poll(1000.0 * PATIENCE))
    os.close(handle)
    return ended


@pytest.mark.parametrize(
    "more",
    [
        {"made": AT_SEA},
        {"made": AT_SEA, "labels": True, "powers": "all"},
        {"made": STITCHED, "labels": True},
        {"sector": (5.0, 1.3)},
    ],
    ids=["plain", "labels and powers", "labels of two pulses", "sector across north"],
)
def test_blocks_have_the_bytes_of_one_process(more: dict[str, Any]) -> None:
    shared = simulator(3, **more)
    assert digest(shared.blocks(scans=2)) == digest(simulator(1, **more).blocks(scans=2))
    assert len(shared.processes) == 3


def test_requests_and_commands_of_a_run_reach_the_processes() -> None:
    """Commands that follow each other, and one that comes before them."""

    def run(sim: rs.Simulator) -> str:
        parts = [digest(sim.blocks(scans=1))]
        for at, speed in ((150, 25.0), (200, 5.0), (140, 15.0)):
            sim.command(speed_kn=speed, course_deg=speed, spoke=at)
        parts.append(digest(sim.blocks(scans=1)))
        sim.request_sources(labels=True)
        sim.skip_to(4)
        parts.append(digest(sim.blocks(scans=1)))
        return " ".join(parts)

    plain, commanded = alone(2), run(simulator(1))
    assert run(simulator(2)) == commanded
    assert plain != commanded


@pytest.mark.parametrize("change", ["command", "earlier command", "request", "skip"])
def test_what_was_computed_ahead_is_dropped_where_the_next_scan_is_another(change: str) -> None:
    def run(sim: rs.Simulator) -> str:
        first = digest(sim.blocks(scans=2))
        if change == "command":
            sim.command(speed_kn=25.0, course_deg=70.0, spoke=2 * RADAR["azimuths"])
        elif change == "earlier command":
            sim.command(speed_kn=25.0, course_deg=70.0, spoke=200)
        elif change == "request":
            sim.request_sources(labels=True)
        else:
            sim.skip_to(1)
        return first + digest(sim.blocks(scans=2))

    plain, expected = alone(2), run(simulator(1))
    assert run(simulator(2)) == expected and not expected.endswith(plain)


def test_processes_go_on_without_an_order(monkeypatch: pytest.MonkeyPatch) -> None:
    """With the next scan, of which a sector is known from its second time on; shares stay where others were not much better."""
    orders: list[TileRequest] = []
    original = Channel.send

    def send(channel: Channel, message: object) -> None:
        orders.extend([message] if isinstance(message, TileRequest) else [])
        original(channel, message)

    monkeypatch.setattr(Channel, "send", send)
    monkeypatch.setattr(tile_processes, "UNEVEN", np.inf)
    for more, expected in ({}, [0, 0]), ({"sector": (0.0, 4.0)}, [0, 0, 1, 1]):
        orders.clear()
        for _ in simulator(2, **more).blocks(scans=4):
            pass
        assert [order.scan for order in orders] == expected


def test_a_reader_that_leaves_within_a_scan_finds_the_next_one_whole() -> None:
    sim = simulator(2)
    blocks = sim.blocks()
    next(blocks)
    blocks.close()  # type: ignore[attr-defined]  # it is a generator
    assert digest(sim.blocks(scans=1)) == alone(first=1)


@pytest.mark.parametrize("how", ["closed", "copied"])
def test_a_scan_goes_on_here_where_its_processes_have_gone(how: str) -> None:
    """Within a scan the processes are ended, or the parent is copied."""
    sim, expected = simulator(2), alone(2)
    blocks = sim.blocks(scans=2)
    first = [next(blocks)]
    if how == "closed":
        sim.close()
        assert digest(first + list(blocks)) == expected
        return
    assert in_a_copy(lambda: digest(first + list(blocks))) == expected


def test_two_readers_by_turns_have_the_scans_that_they_began() -> None:
    def run(sim: rs.Simulator) -> list[str]:
        readers = [sim.blocks(scans=1, size=32) for _ in range(2)]
        pairs = list(zip(*readers, strict=True))  # of scans 0 and 1
        return [digest(blocks) for blocks in zip(*pairs, strict=True)] + [digest(sim.blocks(scans=1))]

    assert run(simulator(2)) == run(simulator(1))


def test_where_a_process_is_killed_the_scan_goes_on_here_and_the_next_one_has_others() -> None:
    """What they sent before comes first: a scan or two."""
    sim, expected = simulator(2), alone(6)
    blocks: list[SpokeBlock] = []
    for block in sim.blocks(scans=6):
        blocks.append(block)
        if block.first in (32, 128):  # once within a scan, once with its first tile
            before = sim.processes
            for process in before:
                os.kill(process, signal.SIGKILL)
                assert has_ended(process)
    assert digest(blocks) == expected
    assert len(sim.processes) == 2 and not set(sim.processes) & set(before)


def test_what_a_process_raises_is_raised_here_and_the_next_scan_is_right(monkeypatch: pytest.MonkeyPatch) -> None:
    class OnlyHere(Exception):
        """Cannot be handed to another process."""

        def __reduce__(self) -> str:
            raise TypeError

    fail(monkeypatch, {96: ValueError("no tile at 96"), 128 + 96: OnlyHere("nor here")})
    sim = simulator(2)
    with pytest.raises(ValueError, match="no tile at 96"):
        sim.scan()
    with pytest.raises(RuntimeError, match="OnlyHere: nor here"):
        sim.scan()
    assert digest(sim.blocks(scans=1)) == alone(first=2)


def test_an_error_comes_in_place_of_its_tile(monkeypatch: pytest.MonkeyPatch) -> None:
    """After the tiles before it, though its process computes it ahead while those of the scan before are asked for."""
    fail(monkeypatch, {128 + 64: ValueError("no tile at 192")})
    monkeypatch.setattr(tile_processes, "first_ready", lambda channels: [0])  # all of one process before those of the next
    taken: list[int] = []
    with pytest.raises(ValueError, match="no tile at 192"):
        taken.extend(block.first for block in simulator(4).blocks(size=32))
    assert taken == [0, 32, 64, 96, 128, 160]


@pytest.mark.parametrize(("name", "error"), [("sendall", KeyboardInterrupt), ("recv_into", TimeoutError)])
def test_what_a_signal_raises_within_a_message_is_raised_and_the_next_scan_is_right(
    name: str, error: type[BaseException], monkeypatch: pytest.MonkeyPatch
) -> None:
    original = getattr(socket.socket, name)

    def interrupted(end: socket.socket, data: Any) -> None:
        original(end, data[:5])
        raise error

    sim = simulator(2)
    next(sim.blocks())
    with monkeypatch.context() as patch, pytest.raises(error):
        patch.setattr(socket.socket, name, interrupted)
        sim.scan()
    assert sim.processes == []
    sim.skip_to(0)
    assert digest(sim.blocks(scans=2)) == alone(2)


def test_a_process_that_is_interrupted_as_it_begins_runs_nothing_of_its_parent() -> None:
    fork = os.fork

    def interrupted() -> int:
        process = fork()
        if not process:
            os.kill(os.getpid(), signal.SIGINT)
        return process

    def work() -> str:
        tile_processes.os.fork = interrupted
        sim = simulator(2)
        with contextlib.suppress(KeyboardInterrupt):
            sim.scan()
        return f"{len(sim.processes)} "

    assert in_a_copy(work) == "2 "


def test_while_another_thread_computes_nothing_is_forked() -> None:
    sim, begun, go = simulator(2), threading.Event(), threading.Event()

    def compute() -> None:
        with BLAS_LIMIT.held():
            begun.set()
            assert go.wait(PATIENCE)

    thread = threading.Thread(target=compute)
    thread.start()
    assert begun.wait(PATIENCE)
    first = digest(sim.blocks(scans=1))
    assert sim.processes == []
    go.set()
    thread.join(PATIENCE)
    assert first == alone()
    assert digest(sim.blocks(scans=1)) == alone(first=1) and len(sim.processes) == 2


def test_where_no_process_can_be_forked_this_one_computes(monkeypatch: pytest.MonkeyPatch) -> None:
    def none() -> int:
        raise BlockingIOError(11, "Resource temporarily unavailable")

    monkeypatch.setattr(tile_processes.os, "fork", none)
    sim = simulator(2)
    assert digest(sim.blocks(scans=1)) == alone(1) and sim.processes == []


def test_a_process_without_a_handle_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    forked: list[int] = []

    def none(process: int) -> int:
        forked.append(process)
        raise OSError(24, "Too many open files")

    monkeypatch.setattr(tile_processes.os, "pidfd_open", none)
    sim = simulator(2)
    assert digest(sim.blocks(scans=1)) == alone(1) and sim.processes == []
    with pytest.raises(ChildProcessError):
        os.waitpid(forked[0], os.WNOHANG)  # no zombie


def test_processes_end_with_the_simulator_and_when_it_is_closed() -> None:
    sim = simulator(3)
    sim.scan()
    closed = sim.processes
    sim.close()
    assert all(map(has_ended, closed)) and sim.processes == []
    sim.scan()
    dropped = sim.processes
    del sim
    assert len(dropped) == 3 and all(map(has_ended, dropped))
    with pytest.raises(ChildProcessError):
        os.waitpid(dropped[0], os.WNOHANG)  # no zombie


def test_a_process_that_hangs_ends_too(monkeypatch: pytest.MonkeyPatch) -> None:
    fail(monkeypatch, {96: None})
    sim = simulator(2)
    next(sim.blocks())
    processes = sim.processes
    sim.close()
    assert all(map(has_ended, processes))


def test_processes_end_where_their_parent_is_killed() -> None:
    def work() -> str:
        sim = simulator(2)
        next(sim.blocks())
        os.write(writing, " ".join(map(str, sim.processes)).encode())
        os.kill(os.getpid(), signal.SIGKILL)
        return ""

    reading, writing = os.pipe()
    in_a_copy(work)
    processes = [int(number) for number in os.read(reading, 100).split()]
    os.close(reading)
    os.close(writing)
    assert len(processes) == 2 and all(map(has_ended, processes))


def test_processes_hold_no_connection_of_their_parent() -> None:
    near, far = socket.socketpair()
    sim = simulator(2)
    sim.scan()
    far.close()
    near.settimeout(PATIENCE)
    assert near.recv(1) == b""  # no copy of the other end is left
    near.close()


def test_a_copy_of_the_parent_has_processes_of_its_own() -> None:
    """As the spare of a scene's process, which runs on where that one dies."""
    sim = simulator(2)
    sim.scan()
    before = sim.processes

    def work() -> str:
        text = digest(sim.blocks(scans=1))
        has_others = not set(sim.processes) & set(before)
        count = len(sim.processes)
        sim.close()
        return f"{text} {has_others} {count}"

    expected = alone(first=1)
    assert in_a_copy(work) == f"{expected} True 2"
    assert digest(sim.blocks(scans=1)) == expected and sim.processes == before


CELLS = 2**17  # of a tile: 1 MiB of field, which no socket takes at once


@pytest.fixture
def ends() -> Iterator[tuple[TileSender, Channel]]:
    """A sender, and who reads."""
    near, far = (Channel(end) for end in socket.socketpair())
    yield TileSender(near), far
    near.close()
    far.close()


def tile(number: int) -> Computed:
    field = np.full((1, CELLS), number, dtype=np.complex64)
    return Computed(SourceTile(number, field, np.zeros((1, 0), dtype=np.float32), None, None), 0.0)


def received(reader: Channel) -> int:
    message = reader.receive(PATIENCE)
    assert isinstance(message, Computed) and (message.tile.field == message.tile.start).all()
    return message.tile.start


def test_tiles_wait_in_order_while_nobody_reads(ends: tuple[TileSender, Channel]) -> None:
    sender, reader = ends
    for number in range(4):
        sender.put(tile(number))
        assert not sender.has_order(10)
    sender.put("done")
    assert [received(reader) for _ in range(4)] == [0, 1, 2, 3] and reader.receive(PATIENCE) == "done"


@pytest.mark.parametrize("most", [2, 100])
def test_no_more_are_computed_than_may_wait(
    ends: tuple[TileSender, Channel], most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One is being sent; of the others two are one too many, by their number or by their size."""
    monkeypatch.setattr(tile_processes, "BYTES_AHEAD", 8 * CELLS + 1 if most > 2 else 2**30)
    sender, reader = ends
    for number in range(3):
        sender.put(tile(number))
    went_on = threading.Event()

    def wait() -> None:
        assert not sender.has_order(most)
        went_on.set()

    waiting = threading.Thread(target=wait, daemon=True)
    waiting.start()
    assert not went_on.wait(0.1)
    assert received(reader) == 0
    assert went_on.wait(PATIENCE)
    assert [received(reader), received(reader)] == [1, 2]


def test_soon_after_an_order_few_wait(ends: tuple[TileSender, Channel], monkeypatch: pytest.MonkeyPatch) -> None:
    """Two of three that are not being sent are too many until STEERED_SECONDS have passed, while nobody reads."""
    sender, _ = ends
    monkeypatch.setattr(tile_processes, "STEERED_SECONDS", 0.3)
    begun = time.monotonic()
    sender.begin()
    for number in range(3):
        sender.put(tile(number))
    assert not sender.has_order(100)
    assert time.monotonic() >= begun + 0.3
    assert not sender.has_order(100)


def test_an_order_ends_the_wait_and_what_waits_is_dropped(ends: tuple[TileSender, Channel]) -> None:
    sender, reader = ends
    for number in range(3):
        sender.put(tile(number))
    answers: list[bool] = []
    waiting = threading.Thread(target=lambda: answers.append(sender.has_order(1)), daemon=True)
    waiting.start()
    reader.send("stop")
    waiting.join(PATIENCE)
    assert answers == [True]
    sender.drop()
    sender.put("done")
    messages = [reader.receive(PATIENCE)]
    while messages[-1] != "done":
        messages.append(reader.receive(PATIENCE))
    assert len(messages) <= 2


def test_the_end_of_the_reader_is_an_order(ends: tuple[TileSender, Channel]) -> None:
    sender, reader = ends
    for number in range(3):
        sender.put(tile(number))
    reader.close()
    assert sender.has_order(1)


def test_what_cannot_be_sent_ends_the_connection(ends: tuple[TileSender, Channel]) -> None:
    sender, reader = ends
    sender.put(ValueError(lambda: None))
    with pytest.raises(EOFError):
        reader.receive(PATIENCE)
    assert sender.has_order(1)
