"""A prepared world has a spare: a process forked from it, which shares its memory, waits, and runs when the world has died.

Forking takes milliseconds where preparing takes seconds. A process with threads may fork only while those hold no lock; here
they sleep. A spare that does not deliver all the same is replaced by a world that is prepared anew.
"""

import os
import signal
import socket
import sys

from radar_service.stream.processes.channel import Channel

RUN = "run"  # the order to a spare
Ends = tuple[Channel, Channel]  # control, data


def with_spare(control: Channel, data: Channel) -> tuple[Ends, bool]:
    """Forks a spare, and tells the service the number and the channels of that process; None where none can be made.

    Returns twice: in this process with its own channels and False; in the spare with those of the spare and True, when the
    service orders it to run. Raises EOFError in a spare that is not needed.
    """
    ends, is_spare = (control, data), False
    while True:
        (near, its_near), (far, its_far) = pairs = socket.socketpair(), socket.socketpair()
        try:
            process = os.fork() if sys.platform == "linux" else -1
        except OSError:  # no memory, or too many processes
            process = -1
        if process:
            for _, its_end in pairs:
                its_end.close()
            signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # a spare that has ended leaves no zombie
            ends[0].send(process if process > 0 else None)
            if process > 0:
                ends[0].send_ends([near, far])
            near.close()
            far.close()
            return ends, is_spare
        near.close()
        far.close()
        for end in ends:
            end.forget()
        ends, is_spare = (Channel(its_near), Channel(its_far)), True
        if ends[0].receive() != RUN:
            raise EOFError
