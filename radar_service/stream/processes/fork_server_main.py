"""The process that starts others: python -m radar_service.stream.processes.fork_server_main MODULES, orders on its input.

An order is one byte with the ends of two channels. The server forks, and answers with the number of the new process. The
child reads the function and its arguments from its channel, runs it and ends.
"""

import contextlib
import gc
import importlib
import json
import os
import signal
import socket
import sys
from pathlib import Path

from radar_service.stream.processes.channel import Channel
from radar_service.stream.processes.fork_server import ENDS, PROCESS


def serve(orders: socket.socket) -> None:
    """Forks a child for each order, until the service is gone."""
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # children that have ended leave no zombies
    while True:
        order, ends, _, _ = socket.recv_fds(orders, 1, ENDS)
        if not order:
            return
        process = os.fork()
        if not process:
            orders.close()
            run(*(Channel(socket.socket(fileno=end)) for end in ends))
        for end in ends:
            os.close(end)
        orders.send(PROCESS.pack(process))


def run(control: Channel, data: Channel) -> None:
    """Runs the function that arrives on the channel, and ends this process."""
    try:
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
    orders_from_service = socket.socket(fileno=os.dup(0))
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    for module in json.loads(sys.argv[1]):
        importlib.import_module(module)
    gc.collect()
    gc.freeze()  # children share the memory of imported modules as long as nobody writes to it
    serve(orders_from_service)
