"""The command line.

Commands import what they need when they are chosen: `serve` leaves the simulator to other processes, and so starts soon.
"""

import contextlib
import os
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import Any

from radar_service.commands.command_line import module_of, parser
from radar_service.terminal import NO_ROOM, MissingExtra, UsageError
from radar_service.world import SceneError

PIPE_CLOSED = 141  # exit status, 128 + SIGPIPE, as shells report programs that a closed pipe ends


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command line. Returns the exit status: 0, 2 for wrong input, 130 when interrupted, 141 for a closed pipe."""
    try:
        try:
            return _run(arguments)
        finally:
            sys.stdout.flush()
    except OSError as error:
        name = error.filename or ("standard output" if error.errno in NO_ROOM else "radar-service")  # files are named
        if isinstance(error, BrokenPipeError) or name == "standard output":  # as in `radar-service check | head -1`
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # the interpreter flushes once more at its end
        if isinstance(error, BrokenPipeError):
            return PIPE_CLOSED
        print(f"{name}: {error.strerror or error}", file=sys.stderr)
        return 2


def _run(arguments: Sequence[str] | None) -> int:
    words = sys.argv[1:] if arguments is None else arguments
    chosen = next((word for word in words if not word.startswith("-")), None)
    try:
        options = parser(chosen or "").parse_args(words)
        if options.command not in ("replay", "schema"):
            import_module("radar_service.kernels.library")  # where they are absent, a program says so at once
        with _blas_limit(options.command):
            return module_of(options.command).run(options)
    except SceneError as error:
        print(*error.problems, sep="\n", file=sys.stderr)
        return 2
    except (UsageError, MissingExtra) as error:
        print(error, file=sys.stderr)
        return 2
    except ImportError as error:
        if not (error.name or "").startswith("radar_service.kernels."):
            raise
        print(error, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130


def _blas_limit(command: str) -> contextlib.AbstractContextManager[Any]:
    """Keeps BLAS to one thread for the whole command; `serve` does no such arithmetic in this process."""
    if command in ("serve", "replay"):
        return contextlib.nullcontext()
    from radar_service.numerics import BLAS_LIMIT

    return BLAS_LIMIT.held()


if __name__ == "__main__":
    sys.exit(main())
