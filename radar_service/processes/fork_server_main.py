"""The process that starts others: python -m radar_service.processes.fork_server_main MODULES, requests on its input.

A request is one byte with the ends of two channels. The server forks, and answers with the number of the new process. The
child reads the function and its arguments from its channel, runs it and ends.
"""

import contextlib
import ctypes
import gc
import importlib
import json
import os
import select
import signal
import socket
import sys
from collections.abc import Sequence
from pathlib import Path

from radar_service.processes.channel import Channel
from radar_service.processes.fork_server import ENDS, PROCESS

SUBREAPER = 36  # PR_SET_CHILD_SUBREAPER of linux/prctl.h
IDLE_SECONDS = 10.0  # a start is over by then, and a service of a test; the others take 0.3 s of processor time


def serve(requests: socket.socket, first: Sequence[str], others: Sequence[str]) -> None:
    """Forks a child for each request, until the service is gone. Imports the other modules when there is nothing to do."""
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # children that have ended leave no zombies
    adopt_orphans()
    share(first)
    while True:
        if others and not select.select([requests], [], [], IDLE_SECONDS)[0]:
            share(others)
            others = ()
        request, ends, _, _ = socket.recv_fds(requests, 1, ENDS)
        if not request:
            return
        process = os.fork()
        if not process:
            requests.close()
            run(*(Channel(socket.socket(fileno=end)) for end in ends))
        for end in ends:
            os.close(end)
        requests.send(PROCESS.pack(process))


def adopt_orphans() -> None:
    """Makes this process the parent of its children's children when those end, where the system can (Linux)."""
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(SUBREAPER, 1, 0, 0, 0)


def share(modules: Sequence[str]) -> None:
    """Imports modules; children share their memory as long as nobody writes to it."""
    gc.disable()  # a tenth of the time of imports
    for module in modules:
        importlib.import_module(module)
    gc.freeze()
    gc.enable()


def run(control: Channel, data: Channel) -> None:
    """Runs the function that arrives on the channel, and ends this process."""
    try:
        os.setsid()  # so that its priority can be its own
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        for ending in (signal.SIGINT, signal.SIGTERM):
            signal.signal(ending, signal.SIG_IGN)  # the service ends its children in order
        with contextlib.suppress(OSError):  # where memory runs out, the kernel ends this process and not the service
            Path("/proc/self/oom_score_adj").write_text("500")
        function, arguments = control.receive()
        function(control, data, *arguments)
    finally:
        os._exit(0)  # not the way of `sys.exit`: what the server had to tidy up is not this process's business


if __name__ == "__main__":
    requests_from_service = socket.socket(fileno=os.dup(0))
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    serve(requests_from_service, *json.loads(sys.argv[1]))
