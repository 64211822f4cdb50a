"""Keeps BLAS to one thread while the engine computes, and knows whether any thread computes.

The engine makes thousands of small matrix products. BLAS libraries that spread each of them over the cores mostly wait, and
compete with the engine's own processes.

Importing this module changes neither the environment nor any library. `BLAS_LIMIT` acts only while something holds it.
"""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from threading import Lock, local
from typing import Any

BLAS_USERS = ("numpy.linalg", "scipy.linalg")  # each loads the BLAS library of its package; the engine uses no third one
ENVIRONMENT_OF_THREADPOOLCTL = "KMP_DUPLICATE_LIB_OK"  # threadpoolctl sets it when it is imported, for OpenMP of Intel


class BlasLibrary:
    """A BLAS library as threadpoolctl controls it.

    description: its name, version and, where it has several, its core.
    per_thread: whether each thread has a number of its own, as with OpenMP; otherwise one number holds for the process.
    """

    def __init__(self, controller: Any) -> None:
        openblas = controller.internal_api == "openblas"
        self.filepath: str = controller.filepath
        parts = {"openblas": "OpenBLAS"}.get(controller.internal_api, controller.internal_api), controller.version
        self.description = " ".join(str(part) for part in (*parts, getattr(controller, "architecture", None)) if part)
        self.per_thread: bool = openblas and controller.threading_layer == "openmp"
        self._shared = openblas and not self.per_thread
        self._controller = controller

    def get_num_threads(self) -> int:
        """Returns the number of threads that BLAS may use."""
        return int(self._controller.get_num_threads())

    def set_num_threads(self, number: int) -> None:
        """Sets the number of threads that BLAS may use.

        threadpoolctl 3.8 lets only the thread that set OpenBLAS first set it again, and ignores all others without a word.
        Here the last holder restores, whichever thread it runs on, so no thread keeps that right.
        """
        self._free()
        self._controller.set_num_threads(number)
        self._free()

    def _free(self) -> None:
        if self._shared:
            self._controller.clear_controlling_thread(force=True)


def loaded_blas() -> list[BlasLibrary]:
    """Loads the BLAS libraries that the engine uses, then finds all that this process has loaded. Takes about 2 ms."""
    for module in BLAS_USERS:
        import_module(module)
    before = os.environ.get(ENVIRONMENT_OF_THREADPOOLCTL)
    from threadpoolctl import ThreadpoolController  # here: its import changes the environment, which is put back

    if before is None:
        os.environ.pop(ENVIRONMENT_OF_THREADPOOLCTL, None)
    return [BlasLibrary(library) for library in ThreadpoolController().select(user_api="blas").lib_controllers]


class BlasLimit:
    """Keeps BLAS to one thread while at least one holder computes, and then restores the previous numbers of threads.

    Threads may hold it at the same time and more than once. Nothing may hold it across a `yield`: an iterator that is
    never finished would keep it.
    """

    def __init__(self, libraries: Sequence[BlasLibrary] | None = None) -> None:
        """libraries: those to limit; None for all BLAS libraries that are loaded when the limit is first held."""
        self.libraries = libraries
        self._lock = Lock()
        self._holders, self._own = 0, local()  # times that it is held, by all threads and by each
        self._previous: list[tuple[BlasLibrary, int]] = []

    @property
    def is_held(self) -> bool:
        """Whether any thread holds the limit."""
        return self._holders > 0

    @contextmanager
    def held(self) -> Iterator[None]:
        """Holds the limit during a `with` block, or during each call of a function that it decorates."""
        own = self._take()
        try:
            yield
        finally:
            self._release(own)

    @contextmanager
    def alone(self) -> Iterator[bool]:
        """Whether no other thread holds the limit; during a `with` block none takes it or gives it back."""
        with self._lock:
            yield self._holders == self._times

    def _take(self) -> list[tuple[BlasLibrary, int]]:
        """Counts one holder more. Returns the previous numbers that belong to this thread alone."""
        shared, own = self._by_scope()
        with self._lock:
            if not self._holders:
                self._previous = _set_to_one(shared)
            self._holders += 1
            self._own.times = self._times + 1
        return _set_to_one(own)

    def _release(self, own: list[tuple[BlasLibrary, int]]) -> None:
        """Counts one holder less. The last one restores the numbers that the first one found."""
        _restore(own)
        with self._lock:
            self._holders -= 1
            self._own.times = self._times - 1
            if not self._holders:
                _restore(self._previous)

    @property
    def _times(self) -> int:
        """How often this thread holds it."""
        return getattr(self._own, "times", 0)

    def _by_scope(self) -> tuple[list[BlasLibrary], list[BlasLibrary]]:
        """The libraries with one number for the process, and those with one for each thread."""
        with self._lock:
            if self.libraries is None:
                self.libraries = loaded_blas()
        shared = [library for library in self.libraries if not library.per_thread]
        return shared, [library for library in self.libraries if library.per_thread]


def _set_to_one(libraries: Sequence[BlasLibrary]) -> list[tuple[BlasLibrary, int]]:
    """Sets each library to one thread. Returns the numbers before."""
    before = [(library, library.get_num_threads()) for library in libraries]
    for library in libraries:
        library.set_num_threads(1)
    return before


def _restore(numbers: Sequence[tuple[BlasLibrary, int]]) -> None:
    for library, number in numbers:
        library.set_num_threads(number)


BLAS_LIMIT = BlasLimit()  # the one of this process: the libraries have one number for all who use them
