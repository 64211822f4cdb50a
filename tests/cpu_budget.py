"""Processor time of the tests by folder, held against a budget: `pytest --cpu-budget tests/cpu_budget.toml`.

The time of a test is that of its process, and of the processes that ended meanwhile, with its set-up and teardown. What a fixture
of a module or session costs counts for the test that begins or ends it. Workers send theirs with each report.
"""

import os
import tomllib
from collections import defaultdict
from collections.abc import Generator, Mapping
from pathlib import Path
from statistics import median_low
from typing import Any

import pytest

COLLECTION = "(collection)"  # what processes of the tests take before their first test
PROPERTY = "cpu_s"
COSTLY = 20  # rows of the second table


def cpu_s() -> float:
    """Returns the processor time of this process and of its children that have ended [s]."""
    return sum(os.times()[:4])


def folder_of(nodeid: str) -> str:
    """Returns the folder in `tests` that a test lies in, or `.` for those beside the folders."""
    parts = nodeid.split("::")[0].split("/")
    return parts[1] if len(parts) > 2 else "."


def pace(spent: Mapping[str, float], budget: Mapping[str, float]) -> float:
    """Returns what this machine takes for a second of the budgets: the median of the folders; 1 at least."""
    paces = [seconds / budget[folder] for folder, seconds in spent.items() if budget.get(folder)]
    return max(1.0, median_low(paces or [1.0]))


def excesses(spent: Mapping[str, float], budget: Mapping[str, float], factor: float) -> list[str]:
    """Returns a sentence for each folder that spent more than `factor` times its budget [s], at this machine's pace."""
    slower = pace(spent, budget)
    return [
        f"{folder} took {seconds:.1f} s of processor time, more than {factor:g} times its budget of {budget.get(folder, 0):g} s "
        f"on a machine that takes {slower:.2g} s for one: make its tests cheaper, or raise its budget and say why in the commit"
        for folder, seconds in spent.items()
        if seconds > factor * slower * budget.get(folder, 0)
    ]


def costliest(spent: Mapping[str, float]) -> list[tuple[str, float]]:
    """Returns names and what they spent [s], the largest first."""
    return sorted(spent.items(), key=lambda row: -row[1])


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--cpu-budget", metavar="FILE", help="print processor time by folder; fail far above this budget")


def pytest_configure(config: pytest.Config) -> None:
    if config.getoption("--cpu-budget"):
        config.pluginmanager.register(CpuBudget(config))


class CpuBudget:
    """The plugin. It measures in the processes that run tests and adds up in the one that reports."""

    def __init__(self, config: pytest.Config) -> None:
        table = tomllib.loads(Path(config.getoption("--cpu-budget")).read_text(encoding="utf-8"))
        self.budget: dict[str, float] = table["seconds"]
        self.factor: float = table["factor"]
        self.worker_output: dict[str, Any] = getattr(config, "workeroutput", {})
        self.tests: defaultdict[str, float] = defaultdict(float)  # by nodeid [s]
        self.folders: defaultdict[str, float] = defaultdict(float)  # [s]
        self.last = 0.0  # reading of cpu_s at the end of what has been counted

    def lap(self) -> float:
        """Returns the processor time since the last call [s]."""
        before, self.last = self.last, cpu_s()
        return self.last - before

    @pytest.hookimpl(trylast=True)
    def pytest_collection_finish(self) -> None:
        self.worker_output[PROPERTY] = seconds = self.lap()
        self.folders[COLLECTION] += seconds

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self) -> Generator[None, pytest.TestReport, pytest.TestReport]:
        report = yield
        report.user_properties = [*report.user_properties, (PROPERTY, self.lap())]
        return report

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        values = (value for name, value in report.user_properties if name == PROPERTY)  # none where a worker crashed
        seconds = sum(value for value in values if isinstance(value, float))
        self.tests[report.nodeid] += seconds
        self.folders[folder_of(report.nodeid)] += seconds

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: Any) -> None:
        self.folders[COLLECTION] += getattr(node, "workeroutput", {}).get(PROPERTY, 0.0)

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        if excesses(self.folders, self.budget, self.factor) and session.exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        lines = [f"{'folder':16}{'CPU s':>8}{'budget':>8}"]
        rows = [("all", sum(self.folders.values())), *costliest(self.folders)]
        budget = {**self.budget, "all": sum(self.budget.values())}
        lines += [f"{name:16}{seconds:8.1f}{budget.get(name, 0):8g}" for name, seconds in rows]
        lines += ["", *(f"{seconds:6.1f} s  {nodeid}" for nodeid, seconds in costliest(self.tests)[:COSTLY]), ""]
        terminalreporter.section("processor time")
        terminalreporter.write("\n".join([*lines, *excesses(self.folders, self.budget, self.factor), ""]))
