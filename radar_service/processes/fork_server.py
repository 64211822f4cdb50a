"""Starts processes in milliseconds: a server process imports what they need once, and forks one for each task.

The service itself has threads, so it must not fork. The server process has none. Each child runs one function and ends with
it; it also ends when its channel closes, so no child outlives the service.
"""

import contextlib
import json
import os
import signal
import socket
import struct
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence

from radar_service.processes.channel import Channel
from radar_service.processes.limits import child_environment

SERVER = "radar_service.processes.fork_server_main"
PROCESS = struct.Struct("<i")  # the answer of the server: number of the new process
ENDS = 2  # channels that a child gets
ANSWER_TIMEOUT = 60.0  # s until a server that does not answer is replaced; its imports take one


class Child:
    """A process that runs one function. control, data: channels to it."""

    def __init__(self, process: int, control: Channel, data: Channel) -> None:
        self.process, self.control, self.data = process, control, data
        self._closed = False

    def close(self) -> None:
        """Ends the process at once, whatever it does."""
        if self._closed:
            return
        self._closed = True
        if not self._has_ended():
            with contextlib.suppress(ProcessLookupError):
                os.kill(self.process, signal.SIGKILL)
        self.control.close()
        self.data.close()

    def _has_ended(self) -> bool:
        """Whether the process is gone, so that its number may belong to another one."""
        with contextlib.suppress(OSError):
            return self.control.other_end_is_gone()
        return True


class ForkServer:
    """The server process, started with the first child or earlier by `start`, and again after it has died.

    first: modules that the first child needs; others: modules that the server imports when it has nothing to do. All
    methods may be called from any thread.
    """

    def __init__(self, first: Sequence[str] = (), others: Sequence[str] = ()) -> None:
        self._modules = tuple(first), tuple(others)
        self._lock = threading.Lock()
        self._server: subprocess.Popen[bytes] | None = None
        self._closed = False
        self._requests: socket.socket | None = None

    def start(self) -> None:
        """Starts the server process, so that the first child does not wait for its imports."""
        with self._lock:
            self._running_server()

    def close(self) -> None:
        """Ends the server process for good. Its children go on until their channels close."""
        self._closed = True
        if server := self._server:  # without the lock: a thread holds it while it waits for a child
            server.kill()
        with self._lock:
            self._end()

    def child(self, function: Callable[..., None], *arguments: object) -> Child:
        """Starts a process that calls function(control, data, *arguments). Both must be picklable, the function by its name.

        Raises OSError where no process can be started, as after `close`.
        """
        with contextlib.ExitStack() as theirs, contextlib.ExitStack() as on_failure:
            pairs = []
            for _ in range(ENDS):
                end, their_end = socket.socketpair()
                pairs.append((on_failure.enter_context(end), theirs.enter_context(their_end)))
            process = self._fork([their_end.fileno() for _, their_end in pairs])
            on_failure.pop_all()
        control, data = (end for end, _ in pairs)
        child = Child(process, Channel(control), Channel(data))
        with contextlib.suppress(OSError):  # it has died already, which its channels tell
            child.control.send((function, arguments))
        return child

    def _fork(self, ends: list[int]) -> int:
        with self._lock:
            for last in (False, True):
                requests = self._running_server()
                try:
                    socket.send_fds(requests, [b"1"], ends)
                    if len(answer := requests.recv(PROCESS.size)) == PROCESS.size:
                        return int(PROCESS.unpack(answer)[0])
                    raise OSError("the process that starts others has died")
                except OSError:
                    self._end()
                    if last:
                        raise
        raise AssertionError

    def _running_server(self) -> socket.socket:
        if self._server is None or self._requests is None or self._server.poll() is not None:
            self._end()
            if self._closed:
                raise OSError("the process that starts others was ended")
            self._server, self._requests = _started(self._modules)
        return self._requests

    def _end(self) -> None:
        server, requests, self._server, self._requests = self._server, self._requests, None, None
        if requests is not None:
            requests.close()
        if server is not None:
            server.kill()
            server.wait()


def _started(modules: tuple[Sequence[str], Sequence[str]]) -> tuple["subprocess.Popen[bytes]", socket.socket]:
    """Returns a new server process and the socket for requests to it."""
    near, far = socket.socketpair()
    near.settimeout(ANSWER_TIMEOUT)
    with far, contextlib.ExitStack() as on_failure:
        on_failure.enter_context(near)
        server = subprocess.Popen(  # with one thread, as a fork copies no other
            [sys.executable, "-P", "-m", SERVER, json.dumps(modules)], stdin=far.fileno(), stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL, env=os.environ | child_environment(), start_new_session=True,
        )  # fmt: skip  # a session of its own: Ctrl-C on the terminal reaches the service alone
        on_failure.pop_all()
    return server, near
