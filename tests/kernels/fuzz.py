"""Calls every kernel with arguments that are drawn, odd and wrong: `python -m tests.kernels.fuzz SEED ROUNDS [KERNEL ...]`.

It prints each kernel before it is called, so that the last line of a process that ends names it, and "done" at its end.
"""

import re
import sys
from collections.abc import Callable
from typing import Any

import numpy as np

from radar_service.kernels.library import DTYPES, KERNELS, Argument, Prototype

ODD = np.array([np.nan, np.inf, -np.inf, 0.0, -0.0, 1e300, -1e300, 1e-300, 1e18, -1.0])
MOST = 6  # of a count


def drawn_sizes(prototype: Prototype, draw: np.random.Generator) -> dict[str, Any]:
    """Numbers of a kernel, and the sizes that no argument has, within their ranges."""
    sizes: dict[str, Any] = {name: int(draw.integers(0, MOST)) for name in prototype.free}
    numbers = [argument for argument in prototype.arguments if argument.shape is None]
    for argument in numbers:
        sizes[argument.name] = int(draw.integers(1, MOST)) if argument.kind == "int64_t" else float(draw.uniform(0.0, 50.0))
    for _ in range(3):  # a range may hold the number after it
        for argument in numbers:
            if argument.low or argument.limit:
                low, limit = (int(eval(bound, {}, sizes)) if bound else None for bound in (argument.low, argument.limit))
                low = low or 0
                sizes[argument.name] = int(
                    draw.integers(low, max(low + 1, low + MOST if limit is None else min(limit, low + MOST)))
                )
    if "groups" in sizes:
        sizes["groups"] = sizes["parts"] << min(sizes["halvings"], 2)
        sizes["halvings"], sizes["count"] = min(sizes["halvings"], 2), sizes["groups"] * int(draw.integers(1, MOST))
    if "origins" in sizes:
        sizes["origins"] = int(draw.choice([1, sizes["count"]]))
    if "room" in sizes:
        sizes["room"] = int(draw.choice([sizes["room"], 40]))
    return sizes


def drawn_array(argument: Argument, sizes: dict[str, Any], draw: np.random.Generator, odd: bool) -> Any:
    """An array that a kernel takes; odd: with some numbers that are not finite, or far away."""
    shape = tuple(max(0, int(eval(size, {}, sizes))) for size in argument.shape or ())
    dtype = DTYPES[argument.kind][0]
    if argument.kind == "int64_t":
        low, limit = (int(eval(bound, {}, sizes)) if bound else None for bound in (argument.low, argument.limit))
        low, limit = low or 0, MOST if limit is None else limit
        return np.sort(draw.integers(low, max(limit, low + 1), shape)) if argument.name in ("begin", "first_fine") else (
            draw.integers(low, max(limit, low + 1), shape)
        )  # fmt: skip
    if dtype.itemsize == 1:
        return draw.integers(0, 2, shape).astype(dtype)
    values = draw.normal(0.0, 10.0 ** draw.uniform(-3.0, 3.0), shape)
    values = np.where(draw.random(shape) < 0.2, draw.choice(ODD, shape), values) if odd else np.abs(values) + 1e-3
    if argument.name == "longest":  # triangles that are cut into thousands of parts take seconds
        values *= 1e3
    with np.errstate(over="ignore"):
        return np.ascontiguousarray(values.astype(dtype))


def arguments_of(prototype: Prototype, draw: np.random.Generator, odd: bool) -> dict[str, Any]:
    """All arguments of a call."""
    sizes = drawn_sizes(prototype, draw)
    made: dict[str, Any] = {}
    for argument in prototype.arguments:
        if argument.shape is None:
            finite = argument.kind == "int64_t" or not odd or draw.random() < 0.8
            made[argument.name] = sizes[argument.name] if finite else float(draw.choice(ODD))
            made[argument.name] *= 1000 if argument.name == "longest" else 1
        else:
            made[argument.name] = drawn_array(argument, sizes, draw, odd)
    return made


def spoilt(value: Any, argument: Argument, prototype: Prototype, draw: np.random.Generator) -> Any:
    """An array that a kernel must refuse."""
    ways = [np.zeros(value.shape, dtype=np.int16), value.tolist(), None, value[None]]
    if argument.name not in {name for name, _ in prototype.free.values()}:  # else its length is as it says
        ways += [np.concatenate([value, np.zeros((1, *value.shape[1:]), value.dtype)]), *([value[1:]] if len(value) else [])]
    if value.size > 1:
        ways.append(np.repeat(value, 2, axis=-1)[..., ::2])
    if argument.is_written:
        ways.append(locked := value.copy())
        locked.flags.writeable = False
    return ways[int(draw.integers(len(ways)))]


def fuzz(name: str, seed: int, rounds: int) -> None:
    """Calls a kernel with what is right, odd and wrong in turn."""
    draw, kernel, prototype = np.random.default_rng(seed), getattr(KERNELS, name), KERNELS.prototype(name)
    for turn in range(rounds):
        made = arguments_of(prototype, draw, odd=turn % 3 > 0)
        if turn % 3 < 2:
            call(kernel, made)
            continue
        arrays = [argument for argument in prototype.arguments if argument.shape is not None]
        chosen = arrays[int(draw.integers(len(arrays)))]
        wrong = spoilt(made[chosen.name], chosen, prototype, draw)
        assert (why := call(kernel, {**made, chosen.name: wrong})) is not None, f"{name}: {chosen.name} passed: {wrong!r}"
        assert re.match(rf"{name}: \w+ ", why), why
        counts = [of.name for of in prototype.arguments if of.kind == "int64_t" and of.shape is None and of.low is None]
        if counts:
            negative = counts[int(draw.integers(len(counts)))]
            why = call(kernel, {**made, negative: int(draw.integers(-9, 0))})
            assert why is not None, f"{name}: {negative} passed"


def call(kernel: Callable[..., int], arguments: dict[str, Any]) -> str | None:
    """Why a kernel refused a call; None where it did not."""
    try:
        assert kernel(**arguments) >= 0
    except (ValueError, MemoryError) as error:
        return str(error)
    return None


if __name__ == "__main__":
    for name in sys.argv[3:] or KERNELS.names:
        print(name, flush=True)
        fuzz(name, int(sys.argv[1]), int(sys.argv[2]))
    print("done")
