"""The public surface: each name of each public package is there, documented, and costs nothing until it is used."""

import subprocess
import sys
from importlib import import_module

import pytest

from tests.reference.docs_tables import PUBLIC

LAZY = [name for name in PUBLIC if name != "radar_service.wire"]


@pytest.mark.parametrize("name", PUBLIC)
def test_each_public_name_is_there(name: str) -> None:
    package = import_module(name)
    assert {*package.__all__} <= {*dir(package)} and len({*package.__all__}) == len(package.__all__) > 0
    for public in package.__all__:
        assert getattr(package, public) is not None, public


@pytest.mark.parametrize("name", LAZY)
def test_a_name_that_is_none_is_refused_by_name(name: str) -> None:
    with pytest.raises(AttributeError, match=f"module '{name}' has no attribute 'nothing'"):
        import_module(name).nothing  # noqa: B018


def test_packages_import_nothing_heavy_until_a_name_is_used() -> None:
    code = f"import sys; [__import__(name) for name in {LAZY}]; print(*sys.modules)"
    imported = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert not {"numpy", "scipy", "pydantic", "mcap", "stonesoup", "matplotlib"} & {*imported}
