"""REST: commands to own ship and to bodies while the radar runs, and errors on purpose."""

import asyncio
import math
from collections.abc import Mapping
from dataclasses import MISSING, fields
from typing import Annotated, Any

from fastapi import APIRouter, Body, Request
from pydantic import BaseModel, ConfigDict, Field, create_model

from radar_service.numerics import KNOT
from radar_service.ports.rest.answers import (
    BUSY,
    CONFLICT,
    FORBIDDEN,
    REFUSED,
    UNKNOWN,
    UNREADABLE,
    api_router,
    check_knows_truth,
    station_of,
)
from radar_service.ports.rest.bodies import StrictRoute
from radar_service.ports.rest.schemas import ErrorsState, RequestBody
from radar_service.ports.roles import needs
from radar_service.scene_file import ErrorsModel
from radar_service.scene_file.error_tables import error_tables
from radar_service.service.radio.station import Station
from radar_service.stages.fields import Flag, Number
from radar_service.world import Command, ErrorSettings

READ = {**UNKNOWN, **CONFLICT, **REFUSED}
CHANGE = {**READ, **UNREADABLE, **BUSY}


class CommandChange(RequestBody):
    """A command to own ship or a body, from the first spoke that is not sent yet; what is left out does not change.

    Limits of speed and turn rate are those of the scene.
    """

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"course_deg": 90, "speed_kn": 12}, {"position_m": [500, 800], "present": True}]}
    )

    course_deg: Number | None = Field(
        None, ge=-360, le=360, description="reached at turn_rate_deg_s, or at the highest rate"
    )
    speed_kn: Number | None = Field(None, ge=0, description="over the ground, at once")
    turn_rate_deg_s: Number | None = Field(None, description="positive to starboard; without course_deg it goes on")
    heading_deg: Number | None = Field(
        None, ge=-360, le=360, description="of the bow, at once; keeps its angle to the course"
    )
    position_m: tuple[Number, Number] | None = Field(None, description="east, north, at once")
    present: Flag | None = Field(None, description="of a body: whether it is there")
    at_once: Flag | None = Field(None, description="the course jumps to course_deg, and turn_rate_deg_s goes on from there")


_fields: dict[str, Any] = {each.name: (each.type, ... if each.default is MISSING else None) for each in fields(Command)}
_CommandFields: Any = create_model("_CommandFields", body=_fields.pop("body"), **_fields)


class CommandState(_CommandFields):  # its fields are those of Command
    """A command as it is carried out: to own ship where body is null, from its first spoke on, at the time of that spoke [s], by
    rest, poses or nmea."""


class SteerableState(BaseModel):
    """What may be commanded, and the latest command; null before the first one."""

    body: str | None
    max_speed_kn: float
    max_turn_rate_deg_s: float
    latest: CommandState | None


ERROR_EXAMPLES = [{"gyro": {"bias_deg": 1.5}, "feed": {"drop_rate": 0.1}}, {"profile": "imo-a823"}]
ErrorsChange = Annotated[ErrorsModel, Body(examples=ERROR_EXAMPLES)]


def command_routes(stations: Mapping[str, Station]) -> APIRouter:
    """Returns the routes of what may be steered."""
    router = api_router("commands", StrictRoute)

    @router.get("/radars/{radar}/own-ship", responses={**READ, **FORBIDDEN})
    @needs("read")
    async def get_own_ship(radar: str, request: Request) -> SteerableState:
        """Returns the limits of commands to own ship, and the latest one, to clients that may know them."""
        check_knows_truth(request, station_of(stations, radar), "own-ship")
        return _state(station_of(stations, radar), None)

    @router.patch("/radars/{radar}/own-ship", responses=CHANGE)
    @needs("command")
    async def command_own_ship(radar: str, command: CommandChange) -> CommandState:
        """Commands own ship from the first spoke that is not sent yet."""
        return await _commanded(station_of(stations, radar), None, command)

    @router.get("/radars/{radar}/bodies/{name:path}", responses={**READ, **FORBIDDEN})
    @needs("read")
    async def get_body(radar: str, name: str, request: Request) -> SteerableState:
        """Returns the limits of commands to a body, and the latest one, to clients that may know them."""
        check_knows_truth(request, station_of(stations, radar), "bodies")
        return _state(station_of(stations, radar), name)

    @router.patch("/radars/{radar}/bodies/{name:path}", responses=CHANGE)
    @needs("command")
    async def command_body(radar: str, name: str, command: CommandChange) -> CommandState:
        """Commands a body from the first spoke that is not sent yet."""
        return await _commanded(station_of(stations, radar), name, command)

    return router


def error_routes(stations: Mapping[str, Station]) -> APIRouter:
    """Returns the routes of errors on purpose."""
    router = api_router("radars", StrictRoute)

    @router.get("/radars/{radar}/errors", responses={**UNKNOWN, **FORBIDDEN})
    @needs("read")
    async def get_errors(radar: str, request: Request) -> ErrorsState:
        """Returns the errors on purpose that are in force, to clients that may know them."""
        check_knows_truth(request, station_of(stations, radar), "errors")
        return _errors(station_of(stations, radar).errors.errors)

    @router.patch("/radars/{radar}/errors", responses={**UNKNOWN, **REFUSED, **UNREADABLE})
    @needs("command")
    async def change_errors(radar: str, requested: ErrorsChange) -> ErrorsState:
        """Changes errors on purpose, from the first spoke that was not yet sent; answers with all.

        A table replaces the present one whole; null or {} switches it off, and tables that are not given stay. A profile
        replaces the tables that it has. Another scene begins with the errors of its file; another rpm goes on with them.
        """
        return await _changed(station_of(stations, radar), requested.model_dump(exclude_unset=True))

    @router.delete("/radars/{radar}/errors", responses=UNKNOWN)
    @needs("command")
    async def delete_errors(radar: str) -> ErrorsState:
        """Switches all errors on purpose off, from the first spoke that was not yet sent."""
        return await _changed(station_of(stations, radar), None)

    return router


def _state(station: Station, body: str | None) -> SteerableState:
    limits = station.epoch.info.scene.steerable.limits_of(body)
    latest = station.epoch.commands.latest(body)
    return SteerableState(
        body=body,
        max_speed_kn=limits.max_speed / KNOT,
        max_turn_rate_deg_s=math.degrees(limits.max_turn_rate),
        latest=None if latest is None else CommandState.model_validate(latest.as_dict()),
    )


async def _commanded(station: Station, body: str | None, change: CommandChange) -> CommandState:
    values = change.model_dump(exclude_none=True)
    command = await station.commands.command(body, lambda time: values, by="rest")
    return CommandState.model_validate(command.as_dict())


async def _changed(station: Station, tables: Mapping[str, Any] | None) -> ErrorsState:
    await asyncio.to_thread(station.errors.set_errors, tables)  # which may import scipy
    return _errors(station.errors.errors)


def _errors(errors: ErrorSettings | None) -> ErrorsState:
    return ErrorsState.model_validate(error_tables(errors or ErrorSettings()))
