"""The cache: one computation per key whichever threads ask, a bounded size, and pickles without results."""

import pickle
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import pytest

from radar_service.numerics.result_cache import STEADY, ResultCache, Revision

THREADS, KEYS = 8, 5


def test_each_key_is_computed_once_by_any_number_of_threads() -> None:
    """All threads start together and ask for all keys, each from another key on."""
    cache: ResultCache[int, object] = ResultCache(KEYS)
    computed, start = list[int](), Barrier(THREADS)

    def compute(key: int) -> Callable[[], object]:
        def result() -> object:
            computed.append(key)
            return object()

        return result

    def results(first: int) -> dict[int, object]:
        start.wait(30)
        return {key % KEYS: cache.get(key % KEYS, compute(key % KEYS)) for key in range(first, first + KEYS)}

    with ThreadPoolExecutor(THREADS) as pool:
        each = list(pool.map(results, range(THREADS)))
    assert sorted(computed) == list(range(KEYS))
    assert all(one[key] is each[0][key] for one in each for key in range(KEYS))


def test_the_results_used_last_are_kept() -> None:
    cache: ResultCache[str, int] = ResultCache(2)
    computed: list[str] = []

    def get(key: str) -> None:
        cache.get(key, lambda: computed.append(key) or len(computed))  # type: ignore[func-returns-value]

    for key in "abacab":  # c drops b, as a was used after it; then b drops c
        get(key)
    assert computed == ["a", "b", "c", "b"] and len(cache) == 2


def test_the_size_may_be_raised() -> None:
    cache: ResultCache[int, int] = ResultCache(1)
    for size in (3, 2):  # it never falls
        cache.grow(size)
    for key in range(5):
        cache.get(key, lambda: 0)
    assert len(cache) == 3


def test_another_revision_ends_all_results() -> None:
    revision = Revision()
    cache: ResultCache[str, int] = ResultCache(4, revision)
    cache.get("a", lambda: 1)
    cache.get("b", lambda: 1)
    assert cache.get("a", lambda: 2) == 1
    revision.change()
    assert cache.get("a", lambda: 2) == 2 and len(cache) == 1


def test_a_result_of_a_revision_that_changes_meanwhile_is_not_kept() -> None:
    revision = Revision()
    cache: ResultCache[str, int] = ResultCache(4, revision)

    def compute() -> int:
        revision.change()
        return 1

    assert cache.get("a", compute) == 1 and cache.get("a", lambda: 2) == 2


def test_a_pickle_holds_the_size_and_no_results() -> None:
    """A lambda among the results would stop the pickle."""
    cache: ResultCache[str, Callable[[], int]] = ResultCache(3)
    cache.get("a", lambda: lambda: 1)
    copy = pickle.loads(pickle.dumps(cache))
    assert copy.size == 3 and len(copy) == 0 and len(cache) == 1
    assert copy.get("a", lambda: 7) == 7


def test_a_failure_is_not_kept_and_blocks_nobody() -> None:
    cache: ResultCache[str, int] = ResultCache(2)

    def fail() -> int:
        raise ArithmeticError("no result")

    with pytest.raises(ArithmeticError):
        cache.get("a", fail)
    assert len(cache) == 0 and cache.get("a", lambda: 5) == 5


def test_each_change_has_another_number() -> None:
    revision = Revision()
    numbers = [revision.number]
    for _ in range(3):
        revision.change()
        numbers.append(revision.number)
    assert len(set(numbers)) == 4 and STEADY.number == 0
