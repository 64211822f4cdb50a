"""What takes minutes runs on request alone, whatever other markers are chosen by."""

import pytest


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Skip studies that `-m study` has not asked for."""
    if "study" in str(config.option.markexpr).replace("not study", ""):
        return
    for item in items:
        if item.get_closest_marker("study"):
            item.add_marker(pytest.mark.skip(reason="opt-in: -m study"))
