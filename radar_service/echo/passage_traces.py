"""Which nodes of a passage share what was traced of a body: those between which it turns little as the antenna sees it.

Nodes that count follow one another. They are divided into runs of equal turns, each of which is traced in its middle, so that no
node is farther from there than a step. Fainter nodes share the first run and the last one.
"""

from math import ceil
from typing import NamedTuple

import numpy as np

from radar_service.numerics.types import Flags, Floats, Indices


class TraceRun(NamedTuple):
    """Nodes of a passage that share a trace. spoke: at which the body is traced; nodes: those that count, as spokes."""

    spoke: int
    nodes: tuple[int, ...]


def trace_runs(nodes: Indices, counts: Flags, turned: Floats, step: float) -> dict[int, TraceRun]:
    """The run of each node, by its spoke; those of runs of one are absent: tracing such a node itself takes less.

    nodes: (K,) spokes, rising. counts: (K,) whether what is wrong there counts. turned: (K,) by how much the body has turned
    until each [rad], rising. step: by which it may have turned since it was traced [rad], more than 0.
    """
    ends = np.flatnonzero(counts)
    begin, end = (turned[ends[0]], turned[ends[-1]]) if len(ends) else (turned[0], turned[0])
    count = max(1, ceil((end - begin) / (2.0 * step)))
    share = (turned - begin) / (end - begin) if end > begin else np.zeros(len(nodes))
    number = np.clip((share * count).astype(np.int64), 0, count - 1)
    result: dict[int, TraceRun] = {}
    for run in range(count):
        members = np.flatnonzero(number == run)
        if len(members) < 2:
            continue
        middle = np.interp(begin + (run + 0.5) / count * (end - begin), turned, nodes)
        shared = TraceRun(round(float(middle)), tuple(nodes[members[counts[members]]].tolist()))
        result |= dict.fromkeys(nodes[members].tolist(), shared)
    return result
