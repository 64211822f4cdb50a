"""What a process holds, to see whether it grows."""

import asyncio
import gc
import os
import threading
from pathlib import Path
from typing import NamedTuple


class ResultCache(NamedTuple):
    """What a process has: resident bytes, tasks, threads, open files, objects that are collected."""

    memory: int
    tasks: int
    threads: int
    files: int
    objects: int


def held() -> ResultCache:
    """What this process has now, when what nobody uses has been collected; from within a running event loop."""
    gc.collect()
    memory = resident_memory(os.getpid())
    files = len(os.listdir("/proc/self/fd"))
    return ResultCache(memory, len(asyncio.all_tasks()), threading.active_count(), files, len(gc.get_objects()))


def resident_memory(process: int) -> int:
    """Resident memory of a process [bytes]."""
    return int(Path(f"/proc/{process}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
