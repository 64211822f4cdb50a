"""Of a test with many sets of parameters, the suite runs a sample; the others are studies.

`@pytest.mark.sample(6)` keeps the first and the last set, the corners of a product, and others drawn by the name of the test:
the same in each process and run. `pytest -m study` runs the rest.
"""

import random
from collections import defaultdict
from collections.abc import Iterable

import pytest


def name_of(item: pytest.Item) -> str:
    """The name of a test without its parameters."""
    return item.nodeid.split("[")[0]


def beyond_samples(items: Iterable[pytest.Item]) -> list[pytest.Item]:
    """Returns the tests that are in no sample. Raises ValueError for a marker without effect."""
    groups = defaultdict[str, list[pytest.Item]](list)
    for item in items:
        if item.get_closest_marker("sample") and not item.get_closest_marker("study"):
            groups[name_of(item)].append(item)
    return [item for name, group in groups.items() for item in _others(name, group)]


def _others(name: str, group: list[pytest.Item]) -> list[pytest.Item]:
    marker = group[0].get_closest_marker("sample")
    assert marker is not None
    (count,) = marker.args
    if count < 2:
        raise ValueError(f"{name}: a sample of {count} has not both corners; give 2 or more")
    middle = group[1:-1]
    return random.Random(name).sample(middle, max(0, len(group) - count))
