"""Work done by several threads and handed over in order. numpy, scipy.fft and Embree let go of the interpreter's lock.

The matrix products of the engine are small and made by the thousand: spread over the cores by BLAS they spend more time on
waiting for each other than on multiplying (harbour at two cores, both busy: 1330 azimuths/s instead of 3230), and they would
contend with the engine's own threads. So BLAS is told to keep to one, which it hears if numpy is not imported before.
"""

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

Item = TypeVar("Item")
Result = TypeVar("Result")


def in_order(function: Callable[[Item], Result], items: Iterable[Item], threads: int) -> Iterator[Result]:
    """function(item) of each item, in order, up to `threads` of them at work and as many waiting to be taken."""
    if threads == 1:
        yield from map(function, items)
        return
    waiting: deque[Future[Result]] = deque()
    with ThreadPoolExecutor(threads) as pool:
        for item in items:
            waiting.append(pool.submit(function, item))
            if len(waiting) >= 2 * threads:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
