"""The library of compiled kernels: that it is built, what its functions are made of, and what they refuse."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from radar_service.__main__ import main
from radar_service.kernels import library
from radar_service.kernels.library import KERNELS, Argument, prototypes
from radar_service.scattering.physical_optics import picture

TEXT = """
typedef struct {
    int64_t count;
    const float *weight;
    Complex *total;
} Sums;

/* Adds. */
/* Arrays: weight (count, 3);
 * total (2 * count) */
KERNEL int64_t summed(const Sums *sums) {
}

/* Arrays: some from -1 < count; points (V, 3); corner (3, count) from -1 < V; seen (count) */
KERNEL int64_t lit(int64_t count, int64_t some, double water, const double *points, const int64_t *corner, uint8_t *seen) {
}
"""


def test_the_text_declares_types_writability_shapes_and_ranges() -> None:
    found = prototypes(TEXT)
    assert found["summed"].is_struct and not found["lit"].is_struct
    assert found["summed"].arguments[1:] == (
        Argument("weight", "float", False, ("count", "3"), None, None),
        Argument("total", "Complex", True, ("2 * count",), None, None),
    )
    assert found["lit"].arguments[1:] == (
        Argument("some", "int64_t", False, None, "-1", "count"),
        Argument("water", "double", False, None, None, None),
        Argument("points", "double", False, ("V", "3"), None, None),
        Argument("corner", "int64_t", False, ("3", "count"), "-1", "V"),
        Argument("seen", "uint8_t", True, ("count",), None, None),
    )
    assert found["lit"].free == {"V": ("points", 0)}
    with pytest.raises(AssertionError, match="seen: an array needs its shape"):
        prototypes(TEXT.replace("; seen (count)", ""))


def test_a_library_that_was_built_from_other_sources_is_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a checkout whose sources have changed since `pip install -e .`."""
    built = library.library_file()
    assert built is not None
    for file in (built, *library.FOLDER.glob("*.[ch]")):
        shutil.copy(file, tmp_path)
    monkeypatch.setattr(library, "FOLDER", tmp_path)
    assert library.library_file() == tmp_path / built.name
    (tmp_path / "geometry.h").write_text("/* another one */")
    assert library.library_file() is None
    (tmp_path / built.name).unlink()
    (tmp_path / built.name).write_bytes(b"of no machine")
    assert library.library_file() is None


LOCKED = np.zeros(4, dtype=np.complex128)
LOCKED.flags.writeable = False
PHASE, RESULT, CORNER = np.zeros(4), np.zeros(4, dtype=np.complex128), np.zeros((3, 2), dtype=np.int64)


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        ((5, PHASE, RESULT), r"phasors: phase has shape (4,): it takes (5,) = (count)"),
        ((4, np.zeros((4, 1)), RESULT), r"phasors: phase has shape (4, 1): it takes (count)"),
        ((4, np.zeros(8)[::2], RESULT), r"phasors: phase has strides (16,): it takes a C-contiguous array"),
        ((4, PHASE.astype(np.float32), RESULT), r"phasors: phase is of float32: it takes an array of float64"),
        ((4, PHASE, LOCKED), r"phasors: result may not be written"),
        ((4, PHASE, [0.0] * 4), r"phasors: result is <class 'list'>: it takes an array of complex128"),
        ((-1, PHASE, RESULT), r"phasors: count is -1: it must be at least 0"),
        ((4.0, PHASE, RESULT), r"phasors: argument 1: TypeError: wrong type"),
    ],
    ids=["short", "another shape", "gaps", "single", "read-only", "list", "negative", "real"],
)
def test_what_a_kernel_would_misread_is_refused_by_name(arguments: tuple[object, ...], why: str) -> None:
    with pytest.raises(ValueError, match=re.escape(why)):
        KERNELS.phasors(*arguments)


def test_indices_and_numbers_out_of_range_are_refused() -> None:
    for wrong in (-1, 7):
        with pytest.raises(ValueError, match="lattice_between: corner has an index that is not from 0 to 6"):
            KERNELS.lattice_between(2, np.full((8, 2), wrong), np.zeros((8, 2)), np.zeros(7), np.zeros(2))
    nodes = np.zeros((8, 3)), np.zeros((8, 1), dtype=np.int64), np.zeros((8, 1))
    with pytest.raises(ValueError, match="lattice_nodes: a number is not finite, or out of range"):
        KERNELS.lattice_nodes(1, 0, 8, np.full((1, 3), np.nan), np.ones(3), np.zeros(3), *nodes)


def test_what_is_only_read_may_be_locked_and_arrays_may_be_empty() -> None:
    locked = np.ones(4)
    locked.flags.writeable = False
    assert KERNELS.phasors(4, locked, result := np.zeros(4, dtype=np.complex128)) == 4
    np.testing.assert_allclose(result, np.exp(1j))
    assert KERNELS.phasors(0, np.zeros(0), np.zeros(0, dtype=np.complex128)) == 0


def test_a_program_without_kernels_says_so_in_a_sentence(tmp_path: Path) -> None:
    """In a copy of the package that was never built."""
    root = library.FOLDER.parents[1]
    ignored = shutil.ignore_patterns("__pycache__", f"{library.NAME}.*")
    shutil.copytree(root / "radar_service", tmp_path / "radar_service", ignore=ignored)
    for name in ("clients", "scenes"):
        (tmp_path / name).symlink_to(root / name)
    run = subprocess.run(
        [sys.executable, "-m", "radar_service", "check", "far-target"], cwd=tmp_path, capture_output=True, text=True
    )
    assert (run.returncode, run.stderr) == (2, f"{library.ABSENT}\n")
    assert main(["check", "far-target"]) == 0


def test_constants_in_c_are_those_of_python() -> None:
    """Of windows in the antenna's picture, which both compute."""
    source = (library.FOLDER / "windows.c").read_text(encoding="utf-8")
    declared = re.findall(r"^(?:static const \w+|enum) (.*);", source, flags=re.M)
    both = [
        (float(value), getattr(picture, name))
        for name, value in re.findall(r"([A-Z_]{4,}) = ([-\w.]+)", " ".join(declared))
        if hasattr(picture, name)
    ]
    assert both and all(in_c == in_python for in_c, in_python in both)
