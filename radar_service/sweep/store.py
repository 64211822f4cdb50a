"""The Zarr store of a sweep: laid out first, then written run by run, with the mark of a run last.

Each run is whole chunks of each array, which Zarr renames when they are written, and counts as absent without its mark. Format
and codec are pinned: the bytes of a store are those of its runs, in whatever order they came.
"""

import contextlib
import hashlib
import json
import os
import shutil
from collections.abc import Iterator, Mapping
from functools import cached_property
from importlib.metadata import version
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from radar_service.numerics import Flags
from radar_service.sources.numbers import BODY, LAND
from radar_service.sweep.inputs import Inputs, inputs_from_bytes
from radar_service.sweep.layout import StoreLayout
from radar_service.sweep.spec import SweepError
from radar_service.sweep.variables import Arrays, Variable
from radar_service.terminal import MissingExtra, extra

FORMAT = 3  # of Zarr
LEVEL = 3  # of Zstandard
FILE_CHUNK = 16 * 2**20  # bytes of a scene's file
PARTIAL = "*.partial"  # how Zarr names files that it has not renamed yet
DIGEST, FAILURE = "digest", "failure"  # the arrays of marks: of what a run is made, and why it failed


def library() -> Any:
    """Returns zarr. Raises MissingExtra."""
    with extra("xarray", "sweeps"):
        import zarr
    return zarr


def digest_of(made_of: Mapping[str, Any]) -> str:
    """Returns a hash of all that the values of a store depend on."""
    return hashlib.blake2b(json.dumps(made_of, sort_keys=True).encode(), digest_size=16).hexdigest()


class SweepStore:
    """A store that is laid out."""

    def __init__(self, address: str, write: bool = True) -> None:
        """address: of a folder, or with a protocol of fsspec. Raises SweepError where no sweep is laid out there."""
        with _told(address):
            group = _opened(address, "r+" if write else "r")
        if group is None or "sweep" not in group.attrs:
            raise SweepError(f"{address}: there is no sweep; give the store of one")
        self.address, self._group = address, group
        self.made_of: Mapping[str, Any] = group.attrs["sweep"]
        self.digest = digest_of(self.made_of)
        self._arrays: dict[str, Any] = {}

    @property
    def finished(self) -> Flags:
        """Which runs (R,) are finished."""
        marks = self._array(DIGEST)[:]
        return np.array([mark == self.mark(k) for k, mark in enumerate(marks)], dtype=np.bool_)

    @property
    def failures(self) -> dict[int, str]:
        """Why runs failed, by number."""
        return {k: str(reason) for k, reason in enumerate(self._array(FAILURE)[:]) if reason}

    def mark(self, number: int) -> str:
        """Returns the mark of a run that is finished."""
        return hashlib.blake2b(f"{self.digest} {number}".encode(), digest_size=16).hexdigest()

    def is_finished(self, number: int) -> bool:
        """Returns whether a run is finished."""
        return bool(self._array(DIGEST)[number] == self.mark(number))

    def write(self, number: int, first: int, arrays: Arrays) -> None:
        """Writes scans of a run. first: of a chunk; arrays: of whole chunks, or with the last scan. Raises OSError."""
        for name, values in arrays.items():
            to = self._array(name)
            if to.ndim == 1:
                to[number : number + 1] = values
            else:
                to[number, first : first + len(values)] = values

    def finish(self, number: int) -> None:
        """Marks a run as finished, after all else is written. Raises OSError."""
        self._array(DIGEST)[number] = self.mark(number)

    def fail(self, number: int, reason: str) -> None:
        """Notes why a run failed; an empty reason clears it. Raises OSError."""
        self._array(FAILURE)[number] = reason

    def clear(self) -> None:
        """Removes what killed commands have left in a folder, and why runs failed: they are tried again. Raises OSError."""
        if not _is_remote(self.address):
            for path in Path(self.address).rglob(PARTIAL):
                path.unlink(missing_ok=True)
        for number in self.failures:
            self.fail(number, "")

    @cached_property
    def inputs(self) -> Inputs:
        """What the sweep is made of."""
        group = self._group["inputs"]
        files = {
            int(name.removeprefix("file_")): group[name][:].tobytes() for name in group.array_keys() if name != "description"
        }
        return inputs_from_bytes(group["description"][:].tobytes(), files)

    @cached_property
    def variables(self) -> tuple[Variable, ...]:
        """The arrays that runs write."""
        return tuple(
            Variable(
                name, tuple(array.metadata.dimension_names), str(array.dtype), array.attrs["units"], array.attrs["long_name"],
                array.fill_value,
            )
            for name in self._group.attrs["arrays"]
            for array in (self._array(name),)
        )  # fmt: skip

    @cached_property
    def sizes(self) -> dict[str, int]:
        """The size of each dimension that these arrays have."""
        return {
            dim: size
            for variable in self.variables
            for dim, size in zip(variable.dims, self._array(variable.name).shape, strict=True)
        }

    @property
    def scans_per_chunk(self) -> int:
        """Number of scans in a chunk."""
        return int(self._array("time").chunks[1])

    def body_names(self) -> list[str]:
        """Returns the names of bodies that truth has the numbers of."""
        return [str(name) for name in self._group["body_name"][:]] if "body_name" in self._group else []

    def class_balance(self) -> dict[str, float]:
        """Returns the share of each class in the cells of finished runs, all land and all bodies as one; empty without labels."""
        if "label_cells" not in self._group:
            return {}
        cells, names = self._array("label_cells")[:].sum(axis=0), {BODY: "bodies", LAND: "land"}
        for of_scene in self._array("label_cells").attrs["names"].values():
            names |= {int(number): name for number, name in of_scene.items() if int(number) < LAND}
        ends = [*sorted(names), len(cells)]
        counts = {names[a]: int(cells[a:b].sum()) for a, b in pairwise(ends)}
        return {name: count / max(1, int(cells.sum())) for name, count in counts.items() if count}

    def _array(self, name: str) -> Any:
        """An array, opened once."""
        if name not in self._arrays:
            self._arrays[name] = self._group[name]
        return self._arrays[name]


def lay_out(address: str, inputs: Inputs, layout: StoreLayout, arithmetic: str) -> SweepStore:
    """Lays a store out where there is none, and opens it. What it is made of is noted last: without it, it is laid out again.

    Raises SweepError for what is no store, or one of another sweep; the text names the difference.
    """
    made_of = inputs.made_of(arithmetic)
    with _told(address):
        group = _opened(address, "r+")
        if group is not None and "sweep" in group.attrs:
            _check_same(address, group.attrs["sweep"], made_of)
            return SweepStore(address)
        if group is not None and "sweep_begun" not in group.attrs:
            raise SweepError(f"{address}: it holds another Zarr group; give another name")
        if group is None and not _is_free(address):
            raise SweepError(f"{address}: it exists, and is no Zarr store; give another name")
        group = _fresh_group(address)
        _lay_arrays(group, layout)
        _lay_inputs(group, inputs)
        group.update_attributes(_about(layout) | {"sweep": made_of})
    return SweepStore(address)


def _fresh_group(address: str) -> Any:
    """An empty group; of a folder what is in it goes, and it itself stays, as it may be locked."""
    if _is_remote(address):
        return library().open_group(address, mode="w", zarr_format=FORMAT, attributes={"sweep_begun": True})
    Path(address).mkdir(exist_ok=True)
    for child in Path(address).iterdir():
        shutil.rmtree(child) if child.is_dir() else child.unlink()
    return library().create_group(address, zarr_format=FORMAT, attributes={"sweep_begun": True})


def _about(layout: StoreLayout) -> dict[str, Any]:
    """The attributes of a store."""
    coordinates = [*layout.coordinates, *(array.name for array in layout.arrays if array.is_coordinate), DIGEST, FAILURE]
    return {
        "Conventions": "CF-1.11", "title": "sweep of simulated marine radars",
        "source": f"radar-service {version('radar-service')}", "coordinates": " ".join(coordinates),
        "arrays": [array.name for array in layout.arrays],
    }  # fmt: skip


def _lay_arrays(group: Any, layout: StoreLayout) -> None:
    codec = {"compressors": (library().codecs.ZstdCodec(level=LEVEL),)}
    for name, each in layout.coordinates.items():
        dtype = "string" if each.values.dtype == object else each.values.dtype
        array = group.create_array(
            name, shape=each.values.shape, chunks=each.values.shape, dtype=dtype, dimension_names=each.dims,
            attributes=dict(each.attributes), **codec,
        )  # fmt: skip
        array[:] = each.values
    for variable in layout.arrays:
        attributes: dict[str, Any] = {"units": variable.units, "long_name": variable.long_name}
        if variable.name in ("labels", "label_cells"):
            attributes["names"] = {scene: dict(names) for scene, names in layout.labels.items()}
        group.create_array(
            variable.name, shape=layout.shape(variable), chunks=layout.chunks(variable), dtype=variable.dtype,
            fill_value=variable.fill, dimension_names=variable.dims, attributes=attributes, **codec,
        )  # fmt: skip
    runs = layout.sizes["run"]
    for name, text in ((DIGEST, "what a finished run is made of; empty: not finished"), (FAILURE, "why a run failed")):
        group.create_array(
            name, shape=(runs,), chunks=(1,), dtype="string", fill_value="", dimension_names=("run",),
            attributes={"long_name": text}, **codec,
        )  # fmt: skip


def _lay_inputs(group: Any, inputs: Inputs) -> None:
    """Specification, scenes and files as arrays of bytes: any store takes these."""
    description, files = inputs.as_bytes()
    to = group.create_group("inputs")
    for name, content in {"description": description, **{f"file_{k}": content for k, content in enumerate(files)}}.items():
        array = to.create_array(
            name, shape=(len(content),), chunks=(min(len(content), FILE_CHUNK) or 1,), dtype="uint8",
            dimension_names=("byte",), compressors=(library().codecs.ZstdCodec(level=LEVEL),),
        )  # fmt: skip
        array[:] = np.frombuffer(content, dtype=np.uint8)


def _opened(address: str, mode: str) -> Any:
    """The group of a store; None where there is none. Raises SweepError for another format of Zarr."""
    zarr = library()
    if not _is_remote(address) and not Path(address).is_dir():
        return None  # zarr would make the folder
    try:
        return zarr.open_group(address, mode=mode, zarr_format=FORMAT)
    except zarr.errors.GroupNotFoundError:
        return None


def _is_remote(address: str) -> bool:
    return "://" in address


def _is_free(address: str) -> bool:
    """Whether a folder is absent, or has only unfinished files of an earlier layout; True for a remote address."""
    if _is_remote(address):
        return True
    path = Path(address)
    return not path.exists() or (path.is_dir() and all(child.match(PARTIAL) for child in path.iterdir()))


def _check_same(address: str, there: Mapping[str, Any], here: Mapping[str, Any]) -> None:
    """Raises SweepError that names the first difference of what a store is made of."""
    for key, before, now in _differences(there, here, ""):
        raise SweepError(
            f"{address}: it is of another sweep: {key} is {_short(before)} there, and {_short(now)} here; give another name, or "
            "what it was made of"
        )


def _differences(there: Any, here: Any, key: str) -> Iterator[tuple[str, Any, Any]]:
    """Where two plain values differ."""
    if isinstance(there, Mapping) and isinstance(here, Mapping):
        for name in dict.fromkeys([*there, *here]):
            yield from _differences(there.get(name), here.get(name), f"{key}.{name}" if key else name)
    elif there != here:
        yield key, there, here


def _short(value: Any) -> str:
    text = "absent" if value is None else str(value)
    return text if len(text) <= 100 else f"{text[:97]}..."


@contextlib.contextmanager
def _told(address: str) -> Iterator[None]:
    """Raises SweepError for protocols that nothing here serves, and for what an object store says."""
    try:
        yield
    except (ImportError, ValueError) as error:
        if isinstance(error, SweepError | MissingExtra):
            raise
        raise SweepError(
            f"{address}: it cannot be used ({str(error)[:200]}); give a folder, or an address that fsspec serves"
        ) from None


@contextlib.contextmanager
def held(address: str) -> Iterator[None]:
    """Keeps other commands off the store in a folder, which is made.

    Raises SweepError where another command of this machine has it, or a file is in its way. Object stores have no such lock:
    there two commands do the same work twice.
    """
    if _is_remote(address) or os.name == "nt":
        yield
        return
    import fcntl

    try:
        Path(address).mkdir(exist_ok=True)
    except FileExistsError:
        raise SweepError(f"{address}: it exists, and is no folder; give another name") from None
    descriptor = os.open(address, os.O_RDONLY)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise SweepError(f"{address}: another command writes to it; wait for its end, or give another name") from None
        yield
    finally:
        os.close(descriptor)
