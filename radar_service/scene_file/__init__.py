"""Scene files: their model (one file a table), readers of meshes, height maps and tracks, checks, and what they become."""

from typing import TYPE_CHECKING

from radar_service.public_names import lazily

if TYPE_CHECKING:
    from radar_service.scene_file.convert import radar_from_model
    from radar_service.scene_file.describe import json_schema, overview
    from radar_service.scene_file.document import (
        model_and_folder, model_at_range, packaged_folder, packaged_scenes, radar_table, scene_content, scene_path,
        validated
    )  # fmt: skip
    from radar_service.scene_file.error_tables import changed_errors, drawn_biases
    from radar_service.scene_file.key_paths import put
    from radar_service.scene_file.load import load_scene, model_from, scene_from_model
    from radar_service.scene_file.model.errors import (
        MAX_LATENCY_S, AntennaErrorsModel, ErrorsModel, FeedErrorsModel, GyroErrorsModel, LogErrorsModel,
        PositionErrorsModel
    )  # fmt: skip
    from radar_service.scene_file.model.platform import radar_entries
    from radar_service.scene_file.model.radar import MAX_BINS, MIN_CHIRP_PRODUCT
    from radar_service.scene_file.readers.file_format import IN_PROCESS
    from radar_service.scene_file.readers.sandbox import Sandbox
else:
    __getattr__, __dir__ = lazily(__name__)
