"""Kills the processes of a sweep at drawn moments, and goes on with it, until it is whole: the same bytes must come of it.

A moment is a number of files in the store: the process that is to die is killed when there are so many.
"""

import contextlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[2]
LOOK = 0.002  # s between two looks at what is waited for
PATIENCE = 240.0  # s


def command(spec: Path, store: Path, *options: str) -> list[str]:
    """The command that goes on with a sweep."""
    return [sys.executable, "-m", "radar_service", "sweep", str(spec), "-o", str(store), *options]


def started(spec: Path, store: Path, *options: str) -> "subprocess.Popen[str]":
    """The same, begun."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.Popen(command(spec, store, *options), env=environment, stderr=subprocess.PIPE, text=True)


def files(store: Path) -> int:
    """How many files there are in a store; folders come and go meanwhile."""
    return sum(len(names) for _, _, names in os.walk(store))


def children(pid: int) -> list[int]:
    """The worker processes of a process; not the one that tracks what it shares."""
    with contextlib.suppress(FileNotFoundError):
        listed = [int(child) for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
        threads = [path.name for path in Path(f"/proc/{pid}/task").iterdir()]
        listed += [
            int(child) for thread in threads for child in Path(f"/proc/{pid}/task/{thread}/children").read_text().split()
        ]
        return [child for child in dict.fromkeys(listed) if "spawn_main" in _command_line(child)]
    return []


def _command_line(pid: int) -> str:
    with contextlib.suppress(OSError):
        return Path(f"/proc/{pid}/cmdline").read_text()
    return ""


def killed(process: "subprocess.Popen[str]", store: Path, at: int, victims: str, workers: list[int] | None = None) -> bool:
    """Whether a process was killed when a store had so many files; False where it ended before.

    victims: "main", "worker" or "both". workers: those of a cluster; by default the children of the process.
    """
    end = time.monotonic() + PATIENCE
    while process.poll() is None:
        if files(store) >= at:
            some = children(process.pid) if workers is None else workers
            for pid in [*(some[:1] if victims != "main" else ()), *([process.pid] if victims != "worker" else ())]:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
            return True
        assert time.monotonic() < end, f"the sweep stands still with {files(store)} files"
        time.sleep(LOOK)
    return False


def moments(seed: int, count: int, whole: int) -> list[tuple[int, str]]:
    """Numbers of files at which to kill, and whom, drawn by a seed. whole: files of a store that is finished."""
    rng = np.random.default_rng(seed)
    return [(int(rng.integers(1, whole)), str(rng.choice(["main", "worker", "both"]))) for _ in range(count)]


def ended(process: "subprocess.Popen[str]") -> None:
    """Waits for a process that is to succeed, or that was killed."""
    _, text = process.communicate(timeout=PATIENCE)
    assert process.returncode in (0, -signal.SIGKILL), text
