"""Runs functions with the compiled kernels, and with their witnesses in numpy."""

from collections.abc import Callable
from typing import TypeVar

import pytest

from radar_service.kernels.library import KERNELS
from tests.reference.kernel_witnesses import WITNESSES

T = TypeVar("T")


def both(function: Callable[[], T]) -> tuple[T, T]:
    """What a function returns with kernels, and with what does the same in numpy."""
    compiled = function()
    with pytest.MonkeyPatch.context() as patch:
        use_witnesses(patch)
        return compiled, function()


def use_witnesses(patch: pytest.MonkeyPatch) -> None:
    """Puts the witnesses in the place of the kernels."""
    for name, witness in WITNESSES.items():
        patch.setattr(KERNELS, name, witness)
