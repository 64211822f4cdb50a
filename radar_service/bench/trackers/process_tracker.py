"""Trackers that are programs: JSON Lines on their standard input and output."""

import json
import os
import secrets
import shlex
import shutil
import signal
import subprocess
import sys
from collections.abc import Hashable, Mapping, Sequence
from contextlib import suppress
from multiprocessing.util import Finalize
from pathlib import Path
from queue import Empty, Queue
from tempfile import TemporaryDirectory
from threading import Thread
from typing import Any

from typing_extensions import override

from radar_service import plug_ins
from radar_service.bench.trackers.callable_child import FOLDER, READY
from radar_service.bench.trackers.json_lines import ANSWER_SECONDS, MAX_LINE, LineTracker, TrackerError, TrackerHangs
from radar_service.terminal import did_you_mean

MARK = "RADAR_SERVICE_TRACKER"  # in the environment of a program, and of what it starts
SCRIPTS = (".py", ".js", ".jar", ".jl", ".lua", ".pl", ".rb", ".sh")  # endings of files that an interpreter runs
MAX_WAITING = 4  # answers that nobody has asked for yet
MAX_PROCESSES = 64  # of a program with all that it starts
MAX_TEXT = 1000  # characters of a line of its standard error that are kept
LAST_WORDS = 20.0  # s from the end of its answers to its own: on a busy machine it takes a while to write why
SEALED = Path(__file__).with_name("sealed_child.py")
CHILD = "radar_service.bench.trackers.callable_child"  # the program that a callable runs in
_WAITING: dict[Hashable, "ProcessTracker"] = {}  # programs that wait for another header


class ProcessTracker(LineTracker):
    """A LineTracker that another program is. `close` ends the program."""

    def __init__(
        self, command: str, header: Mapping[str, Any], timeout: float = ANSWER_SECONDS, *,
        sealed: Sequence[str] | None = None,
    ) -> None:  # fmt: skip
        """command: as a shell splits it, but without a shell; timeout: for each answer [s]; sealed: folders that the program
        cannot read, which then has a working folder of its own; None for an open run. Raises TrackerError."""
        super().__init__(command, timeout)
        self.key: Hashable = None  # of what it was started as, where it may wait
        self._mark = secrets.token_hex(16)
        self._folder: TemporaryDirectory[str] | None = None
        try:
            self._process = self._started(self._words(command), sealed)
        except (OSError, ValueError, IndexError) as error:
            raise TrackerError(f"tracker: {command!r} could not be started: {error}") from None
        self._answers: Queue[str] = Queue()
        self._last_line = ""
        self._reading = Thread(target=self._read, name="tracker's answers", daemon=True)
        self._reading.start()
        self._noting = Thread(target=self._note, name="tracker's standard error", daemon=True)
        self._noting.start()
        self.begin(header)

    @classmethod
    def ready(cls, command: str, header: Mapping[str, Any], sealed: Sequence[str] | None, digest: str) -> "ProcessTracker":
        """Returns a program that waits for another header, or a new one. digest: of the program. Raises TrackerError."""
        key = cls, command, digest, os.getcwd(), sealed and tuple(sealed)
        tracker = _WAITING.pop(key, None)
        if tracker and tracker.status is None:
            tracker.begin_again(header)
            return tracker
        if tracker:
            tracker.close()
        tracker = cls(command, header, sealed=sealed)
        tracker.key = key
        return tracker

    def begin_again(self, header: Mapping[str, Any]) -> None:
        """Begins another run. Raises TrackerError."""
        self._last_line = ""
        LineTracker.begin(self, header)

    def finish(self) -> None:
        if self.again and self.key and self.key not in _WAITING:
            _WAITING[self.key] = self
        else:
            self.close()

    def _words(self, command: str) -> Sequence[str]:
        """The program and its arguments."""
        return shlex.split(command)

    def _started(self, words: Sequence[str], sealed: Sequence[str] | None) -> "subprocess.Popen[str]":
        """The program, in a group of its own, so that what it starts ends with it."""
        pipe, environment, folder = subprocess.PIPE, {**os.environ, MARK: self._mark, FOLDER: os.getcwd()}, None
        program = shutil.which(words[0])
        if program is None:
            known = [*plug_ins.names("trackers"), *(f"./{name}" for name in os.listdir())]
            absent = f"there is no such program{did_you_mean(words[0], known)}"
            raise OSError("it may not be executed" if os.path.isfile(words[0]) else absent)
        script = next((word for word in words[1:] if not word.startswith("-")), "")
        if script.endswith(SCRIPTS) and not os.path.exists(script):
            raise OSError(f"there is no file {script} in {os.getcwd()}{did_you_mean(script, os.listdir())}")
        if sealed is not None:
            self._folder = TemporaryDirectory(prefix="tracker-", ignore_cleanup_errors=True)
            folder = environment["TMPDIR"] = os.path.realpath(self._folder.name)
            environment["PYTHONPATH"] = os.pathsep.join(filter(None, [os.getcwd(), environment.get("PYTHONPATH")]))
            words = [os.path.abspath(word) if os.path.exists(word) else word for word in (program, *words[1:])]
            if sealed:
                request = json.dumps({"sealed": [*sealed], "files": [*filter(os.path.isfile, words)]})
                words = [sys.executable, "-I", "-S", str(SEALED), request, *words]
        return subprocess.Popen(
            words, stdin=pipe, stdout=pipe, stderr=pipe, encoding="utf-8", errors="replace", start_new_session=True,
            env=environment, cwd=folder,
        )  # fmt: skip

    def _kill(self) -> None:
        """Ends the program and what it has started."""
        with suppress(OSError, AttributeError):  # Windows has no groups
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.kill()
        for environment in Path("/proc").glob("[0-9]*/environ"):  # of what has left the group, where Linux tells
            with suppress(OSError):
                if f"{MARK}={self._mark}".encode() in environment.read_bytes():
                    os.kill(int(environment.parent.name), signal.SIGKILL)

    @override
    def write(self, line: str) -> None:
        assert self._process.stdin
        self._process.stdin.write(line + "\n")
        self._process.stdin.flush()

    @override
    def answer(self, scan: int) -> str:
        try:
            line = self._answers.get(timeout=self.timeout)
        except Empty:
            self._kill()
            raise self.silent(scan) from None
        if not line:
            raise TrackerError(f"tracker: {self.name!r} {self.end} before it answered scan {scan}")
        if len(line) == MAX_LINE:
            raise TrackerError(f"tracker: the answer to scan {scan} is not understood: it has {MAX_LINE} characters or more")
        return line

    def close(self) -> None:
        """Ends the program."""
        if self.is_stuck:
            self._kill()
        with suppress(OSError):
            if self._process.stdin:
                self._process.stdin.close()
        try:
            self._process.wait(1.0 if self._reading.is_alive() else LAST_WORDS)
        except subprocess.TimeoutExpired:
            self._kill()
            self._process.wait()
        self._kill()
        self._noting.join(1.0)
        if self._folder:
            self._folder.cleanup()

    @property
    @override
    def status(self) -> int | None:
        return self._process.poll()

    @property
    @override
    def memory(self) -> int | None:
        """Memory of the program and its children [bytes], where Linux tells. Raises TrackerError for too many of these."""
        processes = _family(self._process.pid)
        if len(processes) > MAX_PROCESSES:
            raise TrackerError(f"tracker: {self.name!r} has {len(processes)} processes; at most {MAX_PROCESSES}")
        try:
            pages = [int(Path(f"/proc/{process}/statm").read_text().split()[1]) for process in processes]
            return sum(pages) * os.sysconf("SC_PAGE_SIZE")
        except (OSError, ValueError, IndexError):
            return None

    @property
    @override
    def last_line(self) -> str:
        return self._last_line

    def _note(self) -> None:
        """Passes the program's standard error on, and keeps its last line."""
        assert self._process.stderr
        with self._process.stderr as output:
            while line := output.readline(MAX_TEXT):
                self._last_line = line.strip() or self._last_line
                sys.stderr.write(line)

    def _read(self) -> None:
        """Keeps the answers. A program that answers without being asked is read no further, so that they stay few."""
        assert self._process.stdout
        with self._process.stdout as output:
            while line := output.readline(MAX_LINE):
                if self._answers.qsize() >= MAX_WAITING:
                    self.end = "wrote more lines than it got scans"
                    break
                self._answers.put(line)
        self._answers.put("")


def _family(process: int) -> list[int]:
    """A process and what it has started, as far as Linux tells."""
    family = [process]
    for each in family:
        with suppress(OSError):
            for task in Path(f"/proc/{each}/task").iterdir():
                family += map(int, (task / "children").read_text().split())
    return family


def end_waiting() -> None:
    """Ends the programs that wait for another header."""
    while _WAITING:
        _WAITING.popitem()[1].close()


Finalize(None, end_waiting, exitpriority=0)  # in worker processes too


class CallableTracker(ProcessTracker):
    """A tracker in Python, `module:callable`, in a process of its own: it is checked as any program is. Raises TrackerError where
    the callable makes none."""

    @override
    def _words(self, command: str) -> Sequence[str]:
        return [sys.executable, "-m", CHILD, command]

    @override
    def begin(self, header: Mapping[str, Any]) -> None:
        try:
            line = self._answers.get(timeout=self.timeout)
        except Empty:
            self._kill()
            self.close()
            raise TrackerHangs(f"tracker: {self.name!r} made no tracker within {self.timeout:g} s") from None
        if line.strip() != READY:
            self.close()
            raise TrackerError(f"tracker: {self.name!r} made no tracker: {self.last_line or self.end}")
        super().begin(header)
