"""Runs functions with the compiled kernels and without them."""

from collections.abc import Callable
from typing import TypeVar

import pytest

from radar_service.kernels import library

T = TypeVar("T")
BUILT = library.LOADED or (library.Kernels(file) if (file := library.library_file()) else None)
NEEDS_KERNELS = pytest.mark.skipif(BUILT is None, reason="the compiled kernels were not built: there was no C compiler")


def both(function: Callable[[], T]) -> tuple[T, T]:
    """What a function returns with kernels, and by numpy."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(library, "LOADED", BUILT)
        compiled = function()
        patch.setattr(library, "LOADED", None)
        return compiled, function()
