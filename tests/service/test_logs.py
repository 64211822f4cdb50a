"""Log lines: they say what happened, in forms that their readers accept, and nothing else."""

import json
import logging
import os
import subprocess
import sys
from collections.abc import Iterator

import pytest

from radar_service.service import logs
from radar_service.service.logs import MAX_LINES, OTHERS, JsonLines, LineQueue, Refusals, Words, log_event


@pytest.fixture
def new_loggers(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Loggers are as a new process has them, and afterwards as they were."""
    loggers = [logging.getLogger(name) for name in ("radar_service", "uvicorn", "uvicorn.error")]
    monkeypatch.setattr(logging.getLogger(), "handlers", [])
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.NOTSET)
        for attribute, value in (("disabled", False), ("propagate", True), ("handlers", [])):
            monkeypatch.setattr(logger, attribute, value)
    yield
    for handler in logging.getLogger().handlers:
        handler.close()
    for logger, level in zip(loggers, levels, strict=True):
        logger.setLevel(level)


def written(capfd: pytest.CaptureFixture[str]) -> str:
    """What the log has written."""
    logging.getLogger().handlers[0].flush()
    return capfd.readouterr().err


def test_json_lines_hold_an_event_each(new_loggers: None, capfd: pytest.CaptureFixture[str]) -> None:
    logs.configure("json")
    log_event("client left", radar="0", lost=3)
    log_event("radar failed", logging.ERROR, reason='the "wheel"\ncame off')
    logging.getLogger("uvicorn.error").warning("plain %s", "words")
    first, second, third = map(json.loads, written(capfd).splitlines())
    assert (first["event"], first["level"], first["radar"], first["lost"]) == ("client left", "info", "0", 3)
    assert second["reason"] == 'the "wheel"\ncame off' and second["level"] == "error"
    assert third["event"] == "plain words" and all("time" in line for line in (first, second, third))


def test_quiet_logs_only_warnings_and_errors(new_loggers: None, capfd: pytest.CaptureFixture[str]) -> None:
    logs.configure("quiet")
    log_event("client joined", radar="0")
    log_event("radar failed", logging.ERROR, reason="wheel")
    assert written(capfd) == "error: radar failed reason=wheel\n"


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


@pytest.fixture
def pipe() -> Iterator[tuple[int, int]]:
    ends = os.pipe()
    yield ends
    for end in ends:
        os.close(end)


def record(text: str, logger: str = "radar_service", **fields: object) -> logging.LogRecord:
    return logging.makeLogRecord({"msg": text, "name": logger, "levelname": "INFO", "fields": fields})


def test_a_pipe_that_nobody_reads_holds_nobody_up(pipe: tuple[int, int], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(logs, "FLUSH_SECONDS", 0.01)
    handler = LineQueue(pipe[1])
    handler.setFormatter(Words())
    for number in range(3 * MAX_LINES):
        handler.handle(record(f"line {number}", padding="x" * 4000))  # the kernel's pipe holds 64 KiB
    assert 2 * MAX_LINES - 40 <= handler.dropped["queue"] <= 2 * MAX_LINES
    handler.flush()  # does not wait for ever
    got = b""
    while got.count(b"\n") < 3 * MAX_LINES - handler.dropped["queue"]:
        got += os.read(pipe[0], 2**16)
    assert got.startswith(b"info: line 0 padding=x")
    handler.close()


def test_a_process_ends_where_nobody_reads_its_lines(pipe: tuple[int, int]) -> None:
    code = """if True:
        from radar_service.service import logs
        logs.configure("text")
        for number in range(100):
            logs.log_event(f"{number} {'x' * 4000}")"""
    subprocess.run([sys.executable, "-c", code], stderr=pipe[1], check=True, timeout=20)  # the kernel's pipe holds 64 KiB


def test_one_kind_that_repeats_is_dropped_and_others_are_not(pipe: tuple[int, int]) -> None:
    now = [0.0]
    handler = LineQueue(pipe[1], lambda: now[0])
    for _ in range(200):
        handler.handle(record("Invalid HTTP request received.", "uvicorn.error"))
    handler.handle(record("another kind", "uvicorn.error"))
    now[0] = 1.0 / OTHERS[0]
    handler.handle(record("Invalid HTTP request received.", "uvicorn.error"))
    handler.flush()
    assert os.read(pipe[0], 2**16).decode().splitlines() == [
        *["Invalid HTTP request received."] * int(OTHERS[1]), "another kind", "Invalid HTTP request received."
    ]  # fmt: skip
    assert handler.dropped == {"repeated": 200 - OTHERS[1]}
    handler.close()


def test_control_characters_forge_no_line() -> None:
    hostile = "harbour\nerror: forged \x1b[31m\u2028\u202e\x85\ud800"
    for line in (Words().format(record(hostile)), Words().format(record("radar failed", reason=hostile)),
                 JsonLines().format(record(hostile))):  # fmt: skip
        assert line.isprintable() and "\\n" in line and "forged" in line
    try:
        raise ValueError(hostile)
    except ValueError as error:
        fault = record("fault")
        fault.exc_info = (ValueError, error, error.__traceback__)
    first, *rest = Words().format(fault).split("\n")
    assert first == "info: fault" and rest and all(line.startswith("    ") and line.isprintable() for line in rest)


def test_counts_of_dropped_lines_name_every_reason_from_the_start(new_loggers: None) -> None:
    handler = logs.configure("quiet")
    assert logs.dropped() == {"queue": 0, "repeated": 0} and set(logs.dropped()) == {"queue", "repeated"}
    handler.dropped["queue"] += 3
    assert set(logs.dropped().items()) == {("queue", 3), ("repeated", 0)}
