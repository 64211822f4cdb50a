"""Finds the tests that compare bytes of what they compute, for the marker `same_bytes`. Such a test may fail under one
arithmetic alone."""

import inspect
from collections.abc import Callable, Iterator
from types import CodeType, FunctionType
from typing import Any

COMPARES = {"tobytes", "array_equal", "assert_array_equal"}


def compares_bytes(test: Callable[..., Any]) -> bool:
    """Whether a test, or a function of the tests that it calls, compares arrays to the bit."""
    inner = getattr(getattr(test, "hypothesis", None), "inner_test", test)
    return any(COMPARES & set(code.co_names) for code in _codes(inspect.unwrap(inner), set()))


def _codes(function: Callable[..., Any], seen: set[CodeType]) -> Iterator[CodeType]:
    """The code of a function, of the functions in it, and of those of the tests that it names."""
    if not isinstance(function, FunctionType) or function.__code__ in seen:
        return
    for code in _nested(function.__code__):
        seen.add(code)
        yield code
        for name in code.co_names:
            other = function.__globals__.get(name)
            if (getattr(other, "__module__", "") or "").startswith("tests."):
                yield from _codes(inspect.unwrap(other) if callable(other) else other, seen)


def _nested(code: CodeType) -> Iterator[CodeType]:
    yield code
    for part in code.co_consts:
        if isinstance(part, CodeType):
            yield from _nested(part)
