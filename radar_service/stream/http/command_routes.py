"""REST: commands to own ship and to bodies while the radar runs."""

import math
from collections.abc import Mapping

from fastapi import APIRouter

from radar_service.constants import KNOT
from radar_service.stream.http.answers import BUSY, CONFLICT, REFUSED, UNKNOWN, UNREADABLE, station_of
from radar_service.stream.http.command_schemas import CommandChange, CommandState, SteerableState
from radar_service.stream.radio.station import Station

READ = {**UNKNOWN, **CONFLICT, **REFUSED}
CHANGE = {**READ, **UNREADABLE, **BUSY}


def command_routes(stations: Mapping[str, Station]) -> APIRouter:
    """Returns the routes of what may be steered."""
    router = APIRouter(tags=["commands"])

    @router.get("/radars/{radar}/own-ship", responses=READ)
    async def get_own_ship(radar: str) -> SteerableState:
        """Returns the limits of commands to own ship, and the latest one."""
        return _state(station_of(stations, radar), None)

    @router.patch("/radars/{radar}/own-ship", responses=CHANGE)
    async def command_own_ship(radar: str, command: CommandChange) -> CommandState:
        """Commands own ship from the first spoke that is not sent yet."""
        return await _commanded(station_of(stations, radar), None, command)

    @router.get("/radars/{radar}/bodies/{name:path}", responses=READ)
    async def get_body(radar: str, name: str) -> SteerableState:
        """Returns the limits of commands to a body, and the latest one."""
        return _state(station_of(stations, radar), name)

    @router.patch("/radars/{radar}/bodies/{name:path}", responses=CHANGE)
    async def command_body(radar: str, name: str, command: CommandChange) -> CommandState:
        """Commands a body from the first spoke that is not sent yet."""
        return await _commanded(station_of(stations, radar), name, command)

    return router


def _state(station: Station, body: str | None) -> SteerableState:
    engine = station.engine
    limits = engine.scene.steerable.limits_of(body)
    latest = engine.commands.latest(body)
    return SteerableState(
        body=body,
        max_speed_kn=limits.max_speed / KNOT,
        max_turn_rate_deg_s=math.degrees(limits.max_turn_rate),
        latest=None if latest is None else CommandState.model_validate(latest.as_dict()),
    )


async def _commanded(station: Station, body: str | None, change: CommandChange) -> CommandState:
    values = change.model_dump(exclude_none=True)
    command = await station.command(body, lambda time: values)
    return CommandState.model_validate(command.as_dict())
