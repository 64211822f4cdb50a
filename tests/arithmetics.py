"""Runs the tests that compare bytes under other arithmetics than that of the suite: `python -m tests.arithmetics [NAME ...]`.

Names: kernels of OpenBLAS (Haswell, Nehalem, Sandybridge, SkylakeX); `baseline`, numpy without the vector instructions that it
chooses for the processor. Without a name all run that this processor has and that differ from the suite's.
"""

import os
import subprocess
import sys
from collections.abc import Mapping

from radar_service.numerics.arithmetic_name import CPU_FEATURES, arithmetic, dispatched
from tests.conftest import SAME_BYTES

KERNELS = {"Haswell": "AVX2", "Nehalem": "SSE42", "Sandybridge": "AVX", "SkylakeX": "AVX512_SKX"}  # and what each needs
NAME = "from radar_service.numerics.arithmetic_name import arithmetic; print(arithmetic())"


def arithmetics() -> dict[str, dict[str, str]]:
    """Returns the environment of each arithmetic that this processor can have, by name."""
    made = {core: {"OPENBLAS_CORETYPE": core} for core, needed in KERNELS.items() if CPU_FEATURES.get(needed)}
    if groups := dispatched():
        made["baseline"] = {"NPY_DISABLE_CPU_FEATURES": " ".join(groups)}
    return made


def name_under(changes: Mapping[str, str]) -> str:
    """Returns the name of the arithmetic that a process has."""
    command = [sys.executable, "-c", NAME]
    return subprocess.run(command, env={**os.environ, **changes}, capture_output=True, text=True, check=True).stdout.strip()


def differing() -> dict[str, dict[str, str]]:
    """Returns those of `arithmetics` that differ from this process's and from each other, by name."""
    seen, result = {arithmetic()}, {}
    for name, changes in arithmetics().items():
        if (its := name_under(changes)) not in seen:
            seen.add(its)
            result[name] = changes
    return result


def main(names: list[str]) -> int:
    """Returns 0 where all tests pass under each arithmetic."""
    known = arithmetics()
    if unknown := [name for name in names if name not in known]:
        print(f"{', '.join(unknown)}: not known here; one or more of {', '.join(known)}", file=sys.stderr)
        return 2
    failed = []
    for name, changes in ({name: known[name] for name in names} if names else differing()).items():
        print(f"{name}: {name_under(changes)}", flush=True)
        if subprocess.run(
            [sys.executable, "-m", "pytest", "-q", "-m", SAME_BYTES], env={**os.environ, **changes}
        ).returncode:
            failed.append(name)
    print(f"bytes differ under {', '.join(failed)}" if failed else "bytes are equal under each arithmetic")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
