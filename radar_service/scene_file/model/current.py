"""The model of an area with a tidal stream in a scene file: a polygon or a circle."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from radar_service.stages.fields import Bearing, EastNorth, Latitude, Longitude, Number, Section, Size

MAX_CURRENTS = 100
MAX_CORNERS = 200

LatitudeLongitude = tuple[Latitude, Longitude]
Corners = Annotated[tuple[EastNorth, ...], Field(min_length=3, max_length=MAX_CORNERS)]
GeographicCorners = Annotated[tuple[LatitudeLongitude, ...], Field(min_length=3, max_length=MAX_CORNERS)]


class CurrentModel(Section):
    """An area with a tidal stream, which adds to that of `[environment]` and to those of other areas."""

    current_kn: Number = Field(gt=0, le=20)
    current_to_deg: Bearing = Field(description="where the stream flows to")
    corners_m: Corners | None = Field(None, description="of a polygon, in order round it: east, north")
    corners_deg: GeographicCorners | None = Field(None, description="or these: latitude, longitude")
    position_m: EastNorth | None = Field(None, description="or the centre of a circle: east, north")
    latitude_deg: Latitude | None = Field(None, description="or this centre, with longitude_deg")
    longitude_deg: Longitude | None = None
    radius_m: Size | None = Field(None, description="of the circle")
    border_m: Number = Field(
        200.0, ge=1, le=100_000, description="width over which the stream rises, half of it on either side of the border"
    )

    @property
    def is_geographic(self) -> bool:
        """Whether latitudes and longitudes say where it is."""
        return self.corners_deg is not None or self.latitude_deg is not None

    @model_validator(mode="after")
    def _check_place(self) -> Self:
        if (self.latitude_deg is None) != (self.longitude_deg is None):
            raise ValueError("latitude_deg: this key needs latitude_deg and longitude_deg together; give both or none")
        places = ("corners_m", "corners_deg", "position_m", "latitude_deg")
        given = [key for key in places if getattr(self, key) is not None]
        if len(given) != 1:
            raise ValueError(
                "corners_m: an area has exactly one of corners_m, corners_deg, position_m, and latitude_deg with longitude_deg; "
                f"this one has {', '.join(given) or 'none'}"
            )
        is_circle = given[0] in ("position_m", "latitude_deg")
        if is_circle != (self.radius_m is not None):
            raise ValueError(f"radius_m: a circle has radius_m, a polygon has none; {'add' if is_circle else 'remove'} it")
        return self
