"""Log lines: they say what happened, in forms that their readers accept, and nothing else."""

import json
import logging
from collections.abc import Iterator

import pytest

from radar_service.stream import logs
from radar_service.stream.logs import JsonLines, Refusals, Words, log_event


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
    for logger, level in zip(loggers, levels, strict=True):
        logger.setLevel(level)


def test_json_lines_hold_an_event_each(new_loggers: None, capsys: pytest.CaptureFixture[str]) -> None:
    logs.configure("json")
    log_event("client left", radar="0", lost=3)
    log_event("radar failed", logging.ERROR, reason='the "wheel"\ncame off')
    logging.getLogger("uvicorn.error").warning("plain %s", "words")
    first, second, third = map(json.loads, capsys.readouterr().err.splitlines())
    assert (first["event"], first["level"], first["radar"], first["lost"]) == ("client left", "info", "0", 3)
    assert second["reason"] == 'the "wheel"\ncame off' and second["level"] == "error"
    assert third["event"] == "plain words" and all("time" in line for line in (first, second, third))


def test_quiet_logs_only_warnings_and_errors(new_loggers: None, capsys: pytest.CaptureFixture[str]) -> None:
    logs.configure("quiet")
    log_event("client joined", radar="0")
    log_event("radar failed", logging.ERROR, reason="wheel")
    assert capsys.readouterr().err == "error: radar failed reason=wheel\n"


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
