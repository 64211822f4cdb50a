"""What all effects have in common."""

from radar_service.stages.interference.effect import InterferenceEffect
from tests.scenes import scene

OTHER = {"bearing_deg": 40, "level_db": 60}


def test_an_effect_is_in_a_scene_that_has_its_record() -> None:
    effect = InterferenceEffect()
    assert (
        effect.is_in(scene(interference=[OTHER])) and not effect.is_in(scene()) and not effect.is_in(scene(interference=[]))
    )
    assert len(effect.of_scene(scene(interference=[OTHER, OTHER]))) == 2 and effect.of_scene(scene()) is None
    assert effect.stage().__name__ == "InterferenceStage"
