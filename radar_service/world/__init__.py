"""The world in SI units: bodies, platforms, motion, steering, presence, materials, environment, and scenes of these."""

from typing import TYPE_CHECKING

from radar_service.public_names import lazily

if TYPE_CHECKING:
    from radar_service.world.ais import Ais, AisSettings, AisShip
    from radar_service.world.ais_reporting import TENTHS, Reporting
    from radar_service.world.atmosphere import gas_attenuation_db_per_km
    from radar_service.world.body import Body, Material, Mesh, Plating, Reflector, used_rows
    from radar_service.world.commands import (
        KEYS, Command, CommandError, CommandLog, NotSteerableError, Steerable, UnknownBodyError, command_from
    )  # fmt: skip
    from radar_service.world.environment import Attenuator, Environment, SightLines
    from radar_service.world.error import SceneError
    from radar_service.world.error_settings import (
        AntennaErrors, ErrorSettings, FeedErrors, GyroErrors, LogErrors, PositionErrors
    )  # fmt: skip
    from radar_service.world.geo import Origin, geographic_from_map, map_bearing, map_from_geographic, true_bearing
    from radar_service.world.hull_response import MAX_FROUDE, HullForm
    from radar_service.world.hull_types import HULL_TYPES, PLAIN, hull_mesh
    from radar_service.world.large_mesh import mesh_sample, outward_winding, row_marks
    from radar_service.world.manoeuvres import Knot, Manoeuvre, motion_with_manoeuvres
    from radar_service.world.materials import (
        GROUND_ROUGHNESS, MATERIALS, VESSEL_MATERIALS, is_diffuse_land, is_ground, is_land, is_metal, material_from_name,
        permittivity, power_reflectivity
    )  # fmt: skip
    from radar_service.world.motion import Motion, Pose, in_stream, segment_headings
    from radar_service.world.outline import NOT_STEERABLE, SceneOutline, outline_of
    from radar_service.world.platform import Installation, Platform
    from radar_service.world.poses import (
        MAP_POSE, BodyPose, BodyPoses, PoseArrays, map_from_bodies, map_from_ordered_bodies, merged_mesh, pose_at
    )  # fmt: skip
    from radar_service.world.presence import Fading, Presence, Presences
    from radar_service.world.scene import Scene, World, known_radar, scene_at_rpm
    from radar_service.world.seaway import (
        PEAK_PERIOD, PERIOD_HEIGHT, Seaway, Waves, sea_state_of, significant_wave_height, wind_speed
    )  # fmt: skip
    from radar_service.world.seaway_motion import Bounds, SeawayMotion, bounds_of, bounds_on_any_course, easing_of
    from radar_service.world.shapes import SHAPES, shape_mesh
    from radar_service.world.steered_motion import MAX_SEGMENTS, MotionSegment, PastMotion, SteeredMotion, SteeringLimits
    from radar_service.world.steering import Steering, same_at_first
    from radar_service.world.stream import NO_STREAM, Stream, through_water
    from radar_service.world.sway import Path, Sway
    from radar_service.world.wave_drawing import WAVES, drawn_waves
    from radar_service.world.waypoint_arcs import RoundedRoute, round_corners
else:
    __getattr__, __dir__ = lazily(__name__)
