"""Messages between two processes: Python objects through a socket, arrays as raw bytes beside them.

Both ends belong to this service, so messages are pickled. An array is written from its own memory and read into its own
memory; nothing is copied in between (docs/decisions/0014-world-processes.md has the cost).
"""

import contextlib
import errno
import os
import pickle
import select
import socket
import struct
import sys
import threading
import warnings
from collections.abc import Sequence
from typing import Any, cast

CAN_FORK = sys.platform == "linux"
HEAD = struct.Struct("<II")  # bytes of the pickled object, number of arrays
LENGTH = struct.Struct("<Q")  # bytes of an array


class Channel:
    """One end of a connection. One thread may send while another receives; `close` may be called from any thread."""

    def __init__(self, end: socket.socket) -> None:
        self._end = end
        self._sending = threading.Lock()

    def send(self, message: object) -> None:
        """Sends an object; waits while the other end does not read. Raises OSError when the other end is gone."""
        arrays: list[pickle.PickleBuffer] = []
        text = pickle.dumps(message, 5, buffer_callback=arrays.append)
        views = [array.raw() for array in arrays]
        lengths = b"".join(LENGTH.pack(view.nbytes) for view in views)
        with self._sending:
            self._end.sendall(HEAD.pack(len(text), len(views)) + lengths + text)
            for view in views:
                self._end.sendall(view)

    def receive(self, timeout: float | None = None) -> Any:
        """Returns the next object. Raises TimeoutError after `timeout` [s], and EOFError when the other end is gone."""
        if timeout is not None and not self.wait(timeout):
            raise TimeoutError
        size, count = HEAD.unpack(self._read(HEAD.size))
        lengths = [LENGTH.unpack(self._read(LENGTH.size))[0] for _ in range(count)]
        text = self._read(size)
        return pickle.loads(text, buffers=[self._read(length) for length in lengths])

    def send_ends(self, ends: "Sequence[socket.socket | Channel]") -> None:
        """Hands sockets to the other process, which calls `receive_ends` next. Raises OSError."""
        with self._sending:
            socket.send_fds(self._end, [b"e"], [end.fileno() for end in ends])

    def receive_ends(self, count: int) -> "list[Channel]":
        """Returns channels of so many sockets that the other process hands over.

        Raises EOFError, and OSError where this process has no descriptors left for them: they are closed then.
        """
        try:
            _, ends, flags, _ = socket.recv_fds(self._end, 1, count)
        except OSError:
            ends, flags = [], 0
        channels = [Channel(socket.socket(fileno=end)) for end in ends]
        if len(channels) == count:
            return channels
        for channel in channels:
            channel.close()
        if flags & socket.MSG_CTRUNC:
            raise OSError(errno.EMFILE, "no file descriptors are left for the ends of a channel")
        raise EOFError("the other process has ended")

    def wait(self, timeout: float) -> bool:
        """Waits until there is something to receive, at most `timeout` [s]; returns whether there is."""
        poll = select.poll()
        try:
            poll.register(self._end, select.POLLIN)
        except ValueError:  # closed: `receive` says so
            return True
        return bool(poll.poll(1000.0 * timeout))

    def other_end_is_gone(self) -> bool:
        """Returns whether the other end is closed. Raises OSError where this one is."""
        try:
            return not self._end.recv(1, socket.MSG_PEEK | socket.MSG_DONTWAIT)
        except BlockingIOError:
            return False

    def fileno(self) -> int:
        """Returns the descriptor of this end."""
        return self._end.fileno()

    def end(self) -> None:
        """Sends no more: the other end reads what was sent, and then the end. A `send` that waits raises OSError."""
        with contextlib.suppress(OSError):
            self._end.shutdown(socket.SHUT_WR)

    def close(self) -> None:
        """Ends the connection: both ends stop waiting."""
        with contextlib.suppress(OSError):
            self._end.shutdown(socket.SHUT_RDWR)  # wakes threads that wait; `close` alone does not
        self._end.close()

    def forget(self) -> None:
        """Gives up this process's copy of the end; the connection goes on in the process that forked this one."""
        self._end.close()

    def _read(self, size: int) -> memoryview:
        data = memoryview(bytearray(size))
        at = 0
        while at < size:
            try:
                count = self._end.recv_into(data[at:])
            except TimeoutError:  # of a signal's handler
                raise
            except OSError:
                count = 0
            if not count:
                raise EOFError("the other process has ended")
            at += count
        return data


def forked(count: int) -> "tuple[int, list[Channel]]":
    """Forks this process. Returns the number of the new process, 0 in that itself, and the near ends of `count` channels between
    the two. Raises OSError: no memory, too many processes or descriptors, or a system whose libraries do not survive a fork."""
    if not CAN_FORK:
        raise OSError(errno.ENOSYS, "this system's libraries do not survive a fork")
    with contextlib.ExitStack() as ends:
        pairs = [tuple(map(ends.enter_context, socket.socketpair())) for _ in range(count)]
        with warnings.catch_warnings():  # of threads: none of them holds a lock that the process needs
            warnings.simplefilter("ignore", DeprecationWarning)
            process = os.fork()
        ends.pop_all()
    near = 0 if process else 1
    for pair in pairs:
        pair[1 - near].close()
    return process, [Channel(pair[near]) for pair in pairs]


def portable(error: Exception, kinds: tuple[type[Exception], ...] = (Exception,)) -> Exception:
    """Returns an error that another process can read: the same one where it is of these kinds and crosses, else its text."""
    with contextlib.suppress(Exception):
        if isinstance(error, kinds):
            return cast(Exception, pickle.loads(pickle.dumps(error)))
    return RuntimeError(f"{type(error).__name__}: {error}")


def first_ready(channels: Sequence[Channel]) -> list[int]:
    """Waits until one of several channels has something to receive, or its other end is gone; returns the numbers of those."""
    poll = select.poll()
    for channel in channels:
        poll.register(channel, select.POLLIN)
    ready = {descriptor for descriptor, _ in poll.poll()}
    return [number for number, channel in enumerate(channels) if channel.fileno() in ready]
