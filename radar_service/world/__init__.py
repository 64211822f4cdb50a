"""The world in SI units: bodies, platforms, motion, steering, presence, materials, environment, and scenes of these."""

from typing import TYPE_CHECKING

from radar_service.public_names import lazily

if TYPE_CHECKING:
    from radar_service.world.body import (
        GROUND_ROUGHNESS, MATERIALS, VESSEL_MATERIALS, Body, Material, Mesh, Plating, Reflector, is_diffuse_land, is_ground,
        is_land, is_metal, material_from_name, mesh_sample, outward_winding, permittivity, power_reflectivity, row_marks,
        used_rows
    )  # fmt: skip
    from radar_service.world.commands import (
        KEYS, Command, CommandError, CommandLog, NotSteerableError, Steerable, UnknownBodyError, command_from
    )  # fmt: skip
    from radar_service.world.courses import Knot, Manoeuvre, RoundedRoute, motion_with_manoeuvres, round_corners
    from radar_service.world.environment import Attenuator, Environment, SightLines, gas_attenuation_db_per_km
    from radar_service.world.error import SceneError
    from radar_service.world.geo import Origin, geographic_from_map, map_bearing, map_from_geographic, true_bearing
    from radar_service.world.motion import Motion, Pose, in_stream, segment_headings
    from radar_service.world.poses import (
        MAP_POSE, BodyPose, BodyPoses, PoseArrays, map_from_bodies, map_from_ordered_bodies, merged_mesh, pose_at
    )  # fmt: skip
    from radar_service.world.presence import Fading, Presence, Presences
    from radar_service.world.reporting import (
        TENTHS, Ais, AisSettings, AisShip, AntennaErrors, ErrorSettings, FeedErrors, GyroErrors, LogErrors, PositionErrors,
        Reporting
    )  # fmt: skip
    from radar_service.world.scene import (
        NOT_STEERABLE, Installation, Platform, Scene, SceneOutline, World, known_radar, outline_of, scene_at_rpm
    )  # fmt: skip
    from radar_service.world.seaway import (
        NO_STREAM, PEAK_PERIOD, PERIOD_HEIGHT, WAVES, Path, Seaway, Stream, Sway, Waves, drawn_waves, sea_state_of,
        significant_wave_height, through_water, wind_speed
    )  # fmt: skip
    from radar_service.world.seaway_motion import (
        MAX_FROUDE, Bounds, HullForm, SeawayMotion, bounds_of, bounds_on_any_course, easing_of
    )  # fmt: skip
    from radar_service.world.shapes import HULL_TYPES, PLAIN, SHAPES, hull_mesh, shape_mesh
    from radar_service.world.steered_motion import MAX_SEGMENTS, MotionSegment, PastMotion, SteeredMotion, SteeringLimits
    from radar_service.world.steering import Steering, same_at_first
else:
    __getattr__, __dir__ = lazily(__name__)
