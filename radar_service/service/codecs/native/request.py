"""The query string of the native feed."""

import re
from collections.abc import Mapping
from typing import cast

from radar_service import wire
from radar_service.records.cell_sources import powers_from_text
from radar_service.scene_file.model.radar import MAX_BINS
from radar_service.service.feed_request import FeedRequest, Mode, View

PARAMETERS = ("encoding", "bins", "truth", "mode", "since", "sector", "spokes", "compress", "labels", "powers")
MAX_MERGED = 32  # spokes in a row; a message holds no more
TICKET = "ticket"  # the security layer has read it before the request arrives here


def request_from_query(query: Mapping[str, str], is_local: bool = True) -> FeedRequest:
    """Returns the request of a query string. is_local: the client runs here, and `compress=auto` means none.

    Raises ValueError that names the parameter, its value and what is allowed.
    """
    for key in query:
        if key not in (*PARAMETERS, TICKET):
            raise ValueError(f"{key[:40]}: the feed has no such parameter; it takes {', '.join(PARAMETERS)}")
    compression = _one_of("compress", query.get("compress", "none"), ("none", "auto", *wire.COMPRESSIONS))
    truth, labels = (_flag(name, query.get(name, "0")) for name in ("truth", "labels"))
    view = View(
        _one_of("encoding", query.get("encoding", "u8"), tuple(wire.DTYPES)),
        _whole("bins", query.get("bins", ""), MAX_BINS, "leave it out for every cell"),
        _sector(query.get("sector", "")),
        _whole("spokes", query.get("spokes", ""), MAX_MERGED, "leave it out for every spoke") or 1,
        {"none": "", "auto": "" if is_local else "zstd"}.get(compression, compression),
        labels=labels, powers=powers_from_text(query.get("powers", "")),
    )  # fmt: skip
    mode = cast(Mode, _one_of("mode", query.get("mode", "live"), ("live", "lossless")))
    return FeedRequest(view, mode, truth, _since(query.get("since", "")))


def _flag(name: str, text: str) -> bool:
    if text not in ("0", "1"):
        raise ValueError(f'{name}: "{text[:40]}" is not 0 or 1')
    return text == "1"


def _one_of(name: str, text: str, allowed: tuple[str, ...]) -> str:
    if text not in allowed:
        raise ValueError(f'{name}: "{text[:40]}" is not one of {", ".join(allowed)}')
    return text


def _whole(name: str, text: str, maximum: int, otherwise: str) -> int | None:
    if not text:
        return None
    if not re.fullmatch(r"[0-9]{1,6}", text) or not 1 <= int(text) <= maximum:
        raise ValueError(f'{name}: "{text[:40]}" is not a whole number from 1 to {maximum}; {otherwise}')
    return int(text)


def _sector(text: str) -> tuple[int, int] | None:
    if not text:
        return None
    match = re.fullmatch(r"([0-9]{1,3}),([0-9]{1,3})", text)
    if not match or int(match[1]) > 360 or int(match[2]) > 360:
        raise ValueError(f'sector: "{text[:40]}" is not FROM,TO: true bearings from 0 to 360 in whole degrees, clockwise')
    return int(match[1]), int(match[2])


def _since(text: str) -> tuple[str, int] | None:
    if not text:
        return None
    match = re.fullmatch(r"([^:]{1,64}):([0-9]{1,18})", text)
    if not match:
        raise ValueError(f'since: "{text[:80]}" is not EPOCH:SEQ, the epoch and the number of the first missing spoke')
    return match[1], int(match[2])
