"""Starts a program that cannot read some folders, other processes and disks: python sealed_child.py JSON PROGRAM ARGUMENTS.

JSON: {"sealed": folders, "files": of the program}. Source: Linux, Documentation/userspace-api/landlock.rst.
"""

import contextlib
import ctypes
import json
import os
import stat
import struct
import sys
from collections.abc import Collection, Iterator, Sequence

CREATE_RULESET, ADD_RULE, RESTRICT_SELF = 444, 445, 446
WRITE_FILE, READ_FILE, WRITE = 2, 4, 0x1FF2  # LANDLOCK_ACCESS_FS_*; WRITE: with all of REMOVE_ and MAKE_
NO_NEW_PRIVILEGES = 38  # PR_SET_NO_NEW_PRIVS
NOBODY = 65534
OWN = ("/proc/self", "/proc/cpuinfo", "/proc/meminfo", "/proc/stat", "/proc/sys", "/proc/filesystems")
MEMORY = {"mem", "kmem", "port", "core"}  # devices


def granted(folder: str, sealed: Collection[str]) -> Iterator[str]:
    """Yields paths under a folder that together have all but the sealed ones."""
    for entry in os.scandir(folder):
        if entry.is_symlink() or entry.path in sealed:  # what a link names is granted where it is
            continue
        if any(path.startswith(f"{entry.path}/") for path in sealed):
            with contextlib.suppress(OSError):
                yield from granted(entry.path, sealed)
        else:
            yield entry.path


def devices() -> Iterator[str]:
    """Yields the devices that are neither disks nor memory."""
    for entry in os.scandir("/dev"):
        if entry.name not in MEMORY and not stat.S_ISBLK(entry.stat(follow_symlinks=False).st_mode):
            yield entry.path


def seal(sealed: Collection[str]) -> None:
    """Keeps this process and its children from the sealed folders, and lets them write in the working folder alone, so that
    none tells the next command of plots. Raises OSError."""
    system = ctypes.CDLL(None, use_errno=True)
    ruleset = system.syscall(CREATE_RULESET, struct.pack("=Q", READ_FILE | WRITE), 8, 0)
    rights = dict.fromkeys(granted("/", {*sealed, "/proc", "/dev"}), READ_FILE)
    for path, allowed in {**rights, **dict.fromkeys([*devices(), *OWN, os.getcwd()], READ_FILE | WRITE)}.items():
        with contextlib.suppress(OSError):
            place = os.open(path, os.O_PATH | os.O_CLOEXEC)
            allowed &= READ_FILE | WRITE if stat.S_ISDIR(os.fstat(place).st_mode) else READ_FILE | WRITE_FILE
            system.syscall(ADD_RULE, ruleset, 1, struct.pack("=Qi", allowed, place), 0)
            os.close(place)
    if system.prctl(NO_NEW_PRIVILEGES, 1, 0, 0, 0) or system.syscall(RESTRICT_SELF, ruleset, 0):
        raise OSError(ctypes.get_errno(), "the program could not be sealed")


def become_nobody(files: Sequence[str]) -> None:
    """Gives up the rights of root, where nobody may read these files."""
    if os.geteuid() == 0:
        os.seteuid(NOBODY)
        readable = all(os.access(file, os.R_OK, effective_ids=True) for file in files)
        os.seteuid(0)
        if readable:
            os.chown(".", NOBODY, NOBODY)
            os.setgroups([])
            os.setgid(NOBODY)
            os.setuid(NOBODY)
            os.environ["HOME"] = os.getcwd()  # the one of root is closed to it


if __name__ == "__main__":
    request = json.loads(sys.argv[1])
    become_nobody(request["files"])
    seal(request["sealed"])
    os.execvp(sys.argv[2], sys.argv[2:])
