"""A sealed program tries to find the truth: by files, by other processes, by disks. Each try is one that works unsealed."""

import os
import shlex
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from radar_service.bench.blind import can_seal
from radar_service.bench.trackers.process_tracker import ProcessTracker
from radar_service.bench.trackers.sealed_child import devices, granted
from tests.bench.trackers.test_stone_soup import given

pytestmark = pytest.mark.skipif(not can_seal(), reason="Landlock is absent: truth then stays in memory")

CHEAT = """
import json, os, sys
header = json.loads(sys.stdin.readline())
def tried():
    {code}
for line in sys.stdin:
    try:
        found = str(tried())[:90]
    except OSError as error:
        found = "refused"
    state = {{"track": found, "time": 0, "east": 0, "north": 0, "velocity_east": 0, "velocity_north": 0}}
    print(json.dumps({{"type": "tracks", "scan": json.loads(line)["scan"], "tracks": [state]}}), flush=True)
"""


@pytest.fixture
def secret(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bench-plots").mkdir()
    (tmp_path / "bench-plots" / "truth").write_text("the truth")
    (tmp_path / "link").symlink_to(tmp_path / "bench-plots" / "truth")
    yield tmp_path / "bench-plots"


def found(code: str, folder: Path, sealed: tuple[str, ...] | None) -> str:
    (folder / "cheat.py").write_text(CHEAT.format(code=code))
    with closing(ProcessTracker(f"{sys.executable} cheat.py", {}, sealed=sealed)) as tracker:
        return tracker.update(given(0, ()))[0].track


@pytest.mark.parametrize(
    "code",
    [
        "return open('{secret}/truth').read()",
        "return open('{secret}/../link').read()",
        "return os.popen('cat {secret}/truth').read() or open('{secret}/truth').read()",
        "os.rename('{secret}', '{secret}-mine'); os.rename('{secret}-mine', '{secret}'); return open('{secret}/truth').read()",
        "return open('{secret}/truth', 'a').write('lies')",
        "return os.mknod(f'{secret}/{{os.getpid()}}')",
        "return open('{secret}/../notes', 'a').write('plots of this command for the next one')",
        "return os.mkdir(f'{secret}/../{{os.getpid()}}')",
        "return open(f'/proc/{{os.getppid()}}/cmdline').read()",
        "return open(f'/proc/{{os.getppid()}}/environ', 'rb').read()",
        "return open(f'/proc/{{os.getppid()}}/maps').read()",
        "return open(f'/proc/{{os.getppid()}}/mem', 'rb').seek(0)",
        "return open(f'/proc/{{os.getppid()}}/cwd/bench-plots/truth').read()",
    ],
    ids="file|link|child|renamed|written|made|notes|folders|command line|environment|maps|memory|its folder".split("|"),
)
def test_a_cheat_that_works_in_an_open_run_is_refused_in_a_blind_one(code: str, secret: Path) -> None:
    code = code.format(secret=secret)
    assert found(code, secret.parent, None) != "refused"
    assert found(code, secret.parent, (str(secret),)) == "refused"
    assert (secret / "truth").read_text().startswith("the truth")


def test_it_works_in_a_folder_of_its_own_and_reads_all_else(secret: Path) -> None:
    (secret.parent / "weights").write_text("mine")
    code = f"open('note', 'w').write('x'); return (open('{secret.parent}/weights').read(), open('note').read(), os.getcwd())"
    mine, note, folder = eval(found(code, secret.parent, (str(secret),)))
    assert (mine, note) == ("mine", "x") and Path(folder).name.startswith("tracker-") and not Path(folder).exists()


@pytest.mark.skipif(os.geteuid() != 0, reason="others stay who they are, at home")
def test_a_program_of_root_s_has_a_home_in_which_it_may_write(secret: Path) -> None:
    state = '{"track": "%s", "time": 0, "east": 0, "north": 0, "velocity_east": 0, "velocity_north": 0}'
    answer = f'{{"type": "tracks", "scan": 0, "tracks": [{state}]}}'
    code = f"read header; read scan; touch $HOME/note; printf '{answer}\n' $(ls $HOME); read end"
    with closing(ProcessTracker(shlex.join(["sh", "-c", code]), {}, sealed=(str(secret),))) as tracker:
        assert tracker.update(given(0, ()))[0].track == "note"


def test_all_but_the_sealed_folders_is_granted_and_no_disk(secret: Path) -> None:
    (secret.parent / "other").mkdir()
    paths = {*granted(str(secret.parent), {str(secret)})}
    assert paths == {str(secret.parent / "other")}
    assert "/dev/null" in {*devices()} and not {"/dev/mem", "/dev/kmem"} & {*devices()}


def test_what_it_forked_ends_with_it(secret: Path) -> None:
    """A child that outlives its program, and holds its standard output: the answer is missed, and the child is killed."""
    code = "import time; child = os.fork(); time.sleep(60) if child == 0 else None; return child"
    child = int(found(code, secret.parent, (str(secret),)))
    with pytest.raises(ProcessLookupError):
        for _ in range(1000):  # until init has reaped it
            os.kill(child, 0)
            os.sched_yield()
            if Path(f"/proc/{child}/stat").read_text().rpartition(")")[2].split()[0] == "Z":
                raise ProcessLookupError
