"""The presets by name and in order."""

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

from radar_service.records.fidelity import PRESETS, PURPOSE, Fidelity, fidelity_from_name


def test_presets_of_the_engine_grow_finer_in_order() -> None:
    fast, balanced, reference = (PRESETS[name] for name in ("fast", "balanced", "reference"))
    for name in (
        "scatterers_per_cell",
        "kernel_width",
        "beam_extent",
        "bounces",
        "beam_kernel_width",
        "beam_table_oversampling",
    ):
        values = [getattr(preset, name) for preset in (fast, balanced, reference)]
        assert values == sorted(values), name
    assert fast.visibility_step > balanced.visibility_step > reference.visibility_step
    assert np.isinf(reference.beam_extent) and reference.azimuths_per_block == 1
    assert all(PRESETS[name].name == name for name in PRESETS)


def test_balanced_is_the_default() -> None:
    assert fidelity_from_name("balanced") == Fidelity("balanced")


def test_the_documented_preset_alone_is_of_the_printed_engine() -> None:
    assert [name for name, preset in PRESETS.items() if preset.engine == "documented"] == ["documented"]
    assert set(PURPOSE) == set(PRESETS)


@pytest.mark.parametrize("name", ["", "Balanced", "auto", "best"])
def test_an_unknown_name_is_refused_with_the_presets(name: str) -> None:
    with pytest.raises(ValueError, match=f'"{name}" is not one of auto, documented, fast, balanced, reference'):
        fidelity_from_name(name)


def test_a_fidelity_is_changed_by_a_copy_alone() -> None:
    preset = PRESETS["fast"]
    with pytest.raises(FrozenInstanceError):
        preset.bounces = 5  # type: ignore[misc]
    assert replace(preset, bounces=5) != preset and hash(replace(preset)) == hash(preset)
