"""A prepared world has a copy that stands by: a process forked from it, which shares its memory and runs when it has died.

Forking takes milliseconds where preparing takes seconds. A process with threads may fork only while those hold no lock; here
they sleep. A copy that does not deliver all the same is replaced by a world that is prepared anew.
"""

import os
import signal
import socket
import sys

from radar_service.stream.processes.channel import Channel

RUN = "run"  # the order to a copy
Ends = tuple[Channel, Channel]  # control, data


def with_standby(control: Channel, data: Channel) -> tuple[Ends, bool]:
    """Forks a copy of this process, and tells the service its number and its channels; None where none can be made.

    Returns twice: in this process its own channels and False, and in the copy those of the copy and True, when the service
    orders it to run. Raises EOFError in a copy that is not needed.
    """
    ends, is_copy = (control, data), False
    while True:
        (near, its_near), (far, its_far) = pairs = socket.socketpair(), socket.socketpair()
        try:
            process = os.fork() if sys.platform == "linux" else -1
        except OSError:  # no memory, or too many processes
            process = -1
        if process:
            for _, its_end in pairs:
                its_end.close()
            signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # a copy that has ended leaves no zombie
            ends[0].send(process if process > 0 else None)
            if process > 0:
                ends[0].send_ends([near, far])
            near.close()
            far.close()
            return ends, is_copy
        near.close()
        far.close()
        for end in ends:
            end.forget()
        ends, is_copy = (Channel(its_near), Channel(its_far)), True
        if ends[0].receive() != RUN:
            raise EOFError
