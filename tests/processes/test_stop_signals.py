"""The first signal ends the block, later ones change nothing, and afterwards the handlers are those of before."""

import os
import signal

import pytest

from radar_service.processes.stop_signals import STOP_SIGNALS, ended_by_signals


@pytest.mark.parametrize("number", STOP_SIGNALS)
def test_a_signal_ends_the_block_once(number: int) -> None:
    before, tidied = [signal.getsignal(each) for each in STOP_SIGNALS], False
    with pytest.raises(SystemExit) as end, ended_by_signals():
        try:
            os.kill(os.getpid(), number)
            signal.pause()
        finally:
            for again in STOP_SIGNALS:
                os.kill(os.getpid(), again)
            tidied = True
    assert end.value.code == 0 and tidied
    assert [signal.getsignal(each) for each in STOP_SIGNALS] == before
