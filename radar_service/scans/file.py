"""The file of scans: one .npz layout for the simulator, the command line and the client.

A file holds S scans, one or more, of the same radar: A azimuths and N range cells. Format 1 has these arrays:

| name | shape | type | unit and meaning |
|---|---|---|---|
| format | () | int | 1, the version of this layout |
| number | (S,) | int64 | number of each scan |
| spoke | (S, A) | int64 | number of each spoke, -1 where it is missing |
| time | (S, A) | float64 | s of simulation |
| heading, course | (S, A) | float64 | rad, own ship's |
| speed | (S, A) | float64 | m/s, own ship's |
| position | (S, A, 2) | float64 | m east and north, own ship's |
| azimuth | (A,) | float64 | rad from true north, clockwise, the boresight |
| reported_azimuth, optional | (S, A) | float64 | rad, as the radar reports it, with errors on purpose |
| range | (N,) | float64 | m, of each sample |
| range_step | () | float64 | m from sample to sample |
| power, optional | (S, A, N) | float32 | W |
| field, optional | (S, A, N) | complex64 | sqrt(W) |
| labels, optional | (S, A, N) | uint32 | number of the strongest source |
| powers, optional | (S, P, A, N) | float32 | W, of each source alone |
| power_sources, optional | (P,) | uint32 | the numbers of these sources |
| label_numbers, label_names, optional | (L,) | uint32, str | the numbers and names of all sources |
| samples, optional | (S, A, N) | any | as the feed sent them |
| blind, optional | (S, A) | bool | whether the radar does not transmit (blind sector) |
| name, fidelity, optional | () | str | of the scene, of the simulator |
| seed, optional | () | int | of the simulator |
| hello, optional | () | str | the feed's hello as JSON |

For a missing spoke floats are NaN and samples are 0. A spoke of scan k has a number from k A to k A + A - 1; a client
counts from the start of an epoch, and its scan begins with the first azimuth that it received.
`numpy.load` reads such a file too.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from radar_service.terminal import written

FORMAT = 1
SUFFIX = ".npz"
SHAPES = {
    "number": "S", "spoke": "SA", "time": "SA", "heading": "SA", "course": "SA", "speed": "SA", "position": "SA2",
    "azimuth": "A", "range": "N", "range_step": "",
}  # fmt: skip
OPTIONAL = {
    "power": "SAN", "field": "SAN", "samples": "SAN", "blind": "SA", "labels": "SAN", "powers": "SPAN", "power_sources": "P",
    "label_numbers": "L", "label_names": "L", "name": "", "fidelity": "", "seed": "", "hello": "", "reported_azimuth": "SA",
}  # fmt: skip


def write_arrays(path: str | Path, arrays: Mapping[str, Any], compress: bool = False) -> None:
    """Write a file of the arrays named above, all but `format`. Raises ValueError for another suffix, name or shape."""
    if Path(path).suffix.lower() != SUFFIX:
        raise ValueError(f"{path}: a file of scans ends in {SUFFIX}; give it that ending")
    checked = _checked(arrays, str(path))
    with written(Path(path)) as part, part.open("wb") as file:
        (np.savez_compressed if compress else np.savez)(file, allow_pickle=False, format=np.array(FORMAT), **checked)


def read_arrays(path: str | Path) -> dict[str, Any]:
    """The arrays of a file by name. Raises ValueError where it is not a file of scans of this format; OSError."""
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = dict(file)
    except (ValueError, EOFError, TypeError, BadZipFile) as fault:
        raise ValueError(f"{path}: not a file of scans ({fault}); give one that Scan.save or a scan command wrote") from None
    version = arrays.pop("format", None)
    if version is None or int(version) != FORMAT:
        raise ValueError(f"{path}: format {version} is not {FORMAT}; write the file again with this version")
    return _checked(arrays, str(path))


def _checked(arrays: Mapping[str, Any], path: str) -> dict[str, Any]:
    """The arrays, each of the number of dimensions and the sizes that the layout gives it."""
    missing, unknown = SHAPES.keys() - arrays.keys(), arrays.keys() - SHAPES.keys() - OPTIONAL.keys()
    if missing or unknown:
        raise ValueError(f"{path}: arrays {sorted(missing)} are missing and {sorted(unknown)} not known; see the layout")
    checked, sizes = {name: np.asarray(array) for name, array in arrays.items()}, {"2": 2}
    for name, array in checked.items():
        letters = (SHAPES | OPTIONAL)[name]
        if array.ndim != len(letters) or any(sizes.setdefault(a, n) != n for a, n in zip(letters, array.shape, strict=True)):
            raise ValueError(
                f"{path}: {name} has shape {array.shape}, which does not fit ({', '.join(letters)}) of the others"
            )
    return checked
