"""The library of compiled kernels: that it is built, what it refuses, and how it is turned off."""

import os
import re
import shutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from radar_service.__main__ import main
from radar_service.kernels import library
from radar_service.numerics.arithmetic import arithmetic
from tests.kernels.both import BUILT, NEEDS_KERNELS

LETTERS = {"int64_t": "n", "double": "r", "double *": "f", "float *": "s", "Complex *": "c", "int64_t *": "i"}
LETTERS |= {"int8_t *": "b", "uint8_t *": "b", "RayCall": "t"}


@pytest.mark.skipif(not shutil.which("cc"), reason="no C compiler")
def test_kernels_are_built_where_there_is_a_compiler() -> None:
    assert library.library_file() is not None, (
        "run `pip install -e .` again: it builds the kernels from the sources as they are"
    )


def test_python_calls_kernels_as_the_sources_declare_them() -> None:
    source = "".join(file.read_text(encoding="utf-8") for file in sorted(library.FOLDER.glob("*.c")))
    declared = {}
    source = source.replace("KERNEL int64_t sources(void)", "")
    for name, arguments in re.findall(r"^KERNEL int64_t (\w+)\(([^)]*)\)", source, flags=re.M):
        types = (re.sub(r"\w+$|const ", "", argument.strip()).strip() for argument in arguments.split(","))
        declared[name] = "".join(LETTERS[of_one] for of_one in types)
    assert declared == library.PROTOTYPES


@NEEDS_KERNELS
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


@NEEDS_KERNELS
@pytest.mark.parametrize(
    "phase",
    [np.zeros(4, dtype=np.float32), np.zeros(8)[::2], np.zeros(4, dtype=np.complex128)],
    ids=["single", "gaps", "complex"],
)
def test_an_array_that_a_kernel_would_misread_is_refused(phase: np.ndarray) -> None:
    assert BUILT is not None
    with pytest.raises(TypeError, match="C-contiguous"):
        BUILT.run("phasors", 4, phase, np.zeros(4, dtype=np.complex128))


@NEEDS_KERNELS
def test_the_environment_turns_kernels_off_and_the_arithmetic_says_so() -> None:
    command = "from radar_service.numerics.arithmetic import arithmetic; print(arithmetic())"
    environment = {**os.environ, library.SWITCH: "off"}
    off = subprocess.run([sys.executable, "-c", command], env=environment, capture_output=True, text=True, check=True)
    assert off.stdout.strip().endswith(", no compiled kernels")
    assert off.stdout.strip().rpartition(", ")[0] == arithmetic().rpartition(", ")[0]


@pytest.mark.parametrize(("choice", "told"), [("", True), ("off", False)])
def test_a_program_tells_once_that_it_has_no_kernels(
    choice: str, told: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(library, "LOADED", None)
    monkeypatch.setenv(library.SWITCH, choice)
    assert main(["check", "far-target"]) == 0
    assert capsys.readouterr().err.count("compiled kernels are absent") == told


OPTICS = "radar_service.scattering.physical_optics."
PYTHON = {  # modules whose constants C has too
    "own_shadows.c": (OPTICS + "own_shadows", "radar_service.trace.occluder"),
    "cast_shadows.c": (OPTICS + "silhouettes",),
    "shadow_edges.c": (OPTICS + "shadow_edges", OPTICS + "facets"),
    "windows.c": (OPTICS + "picture",),
    "kept_tubes.c": (OPTICS + "tube_tracing",),
    "tubes.h": (OPTICS + "tube_tracing", OPTICS + "facets"),
    "triangle_means.h": (OPTICS + "facet_integral",),
    "leg_rays.c": ("radar_service.propagation.legs",),
    "strata.c": ("radar_service.scattering.surface_sampling",),
}


@pytest.mark.parametrize("file", PYTHON)
def test_constants_in_c_are_those_of_python(file: str) -> None:
    source = (library.FOLDER / file).read_text(encoding="utf-8")
    declared = re.findall(r"^(?:static const \w+|enum) (.*);", source, flags=re.M)
    values = dict(re.findall(r"([A-Z_]{4,}) = ([-\w.]+)", " ".join(declared)))
    known: dict[str, float] = {}
    for module in PYTHON[file]:
        known |= {name.lstrip("_"): value for name, value in vars(import_module(module)).items() if name.isupper()}
    of_c_alone = {"NO_MEMORY", "NO_RAYS", "UNTRACED", "AXES", "TOGETHER", "SIZES", "PI", "NEEDLE"}
    assert {name: float(value) for name, value in values.items() if name not in of_c_alone} == {
        name: known[name] for name in values if name not in of_c_alone
    }
    assert len(values) > 0


@pytest.mark.parametrize("choice", ["Off", "0", "/nowhere/compiled.so"])
def test_a_choice_of_kernels_that_is_none_is_told(choice: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(library.SWITCH, choice)
    with pytest.raises(
        ValueError, match=f'{library.SWITCH}: "{choice}" is neither off nor the file of a library; leave it out'
    ):
        library.chosen_file()
