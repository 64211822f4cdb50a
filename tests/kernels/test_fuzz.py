"""No call of a kernel ends a process, whatever it is given: in a child process, whose last line names the kernel that did."""

import subprocess
import sys

import pytest


def fuzzed(seed: int, rounds: int) -> None:
    command = [sys.executable, "-m", "tests.kernels.fuzz", str(seed), str(rounds)]
    child = subprocess.run(command, capture_output=True, text=True)
    assert (child.returncode, child.stdout.split()[-1]) == (0, "done"), child.stderr


def test_kernels_survive_what_is_odd_and_refuse_what_is_wrong() -> None:
    fuzzed(1, 30)


@pytest.mark.study
@pytest.mark.parametrize("seed", range(2, 12))
def test_kernels_survive_a_thousand_calls_each(seed: int) -> None:
    fuzzed(seed, 1000)
