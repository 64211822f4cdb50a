"""Culling: bodies that a scene does not need, each with the reason and the error of culling it."""

import math
from dataclasses import dataclass

from radar_service.echo import max_echo_range, max_power, nearest_and_top
from radar_service.plan.budget import ErrorBudget
from radar_service.receive import receiver_noise_power
from radar_service.records import Fidelity
from radar_service.scattering import height_over_horizon
from radar_service.world import Body, Scene

MARGIN = 1.0  # m, for rounding
MAIN_LOBE = 4.0  # c / 2B: no window here has a wider main lobe


@dataclass(frozen=True)
class CulledBody:
    """A culled body.

    reason: why it is culled.
    error_db: maximum change of the power of any cell [dB].
    occludes: whether it may still occlude other bodies.
    """

    reason: str
    error_db: float
    occludes: bool


def cull(scene: Scene, fidelity: Fidelity) -> dict[int, CulledBody]:
    """The bodies that the error budget of a fidelity allows to cull, by index in the scene; none where it allows no error."""
    if fidelity.error_db == 0.0 or fidelity.engine == "documented":
        return {}
    reasons = {key: _never_visible(body, scene, fidelity) for key, body in enumerate(scene.bodies)}
    culled = {key: reason for key, reason in reasons.items() if reason is not None}
    return culled | _below_noise(scene, fidelity, [key for key in reasons if key not in culled])


def _never_visible(body: Body, scene: Scene, fidelity: Fidelity) -> CulledBody | None:
    """Why a body is never visible: out of range, below the sea or beyond the horizon at all times; else None.

    Such a body occludes nothing visible: it lies farther away, or below the line of sight that touches the sea. No horizon counts
    for bodies that have echoes beyond it.
    """
    (x, y, z), (own_x, own_y, _) = body.motion.position[0].tolist(), scene.own_ship.position[0].tolist()
    afloat = z + (0.0 if body.mesh is None else body.mesh.top) >= 0.0
    if afloat and math.hypot(x - own_x, y - own_y) + MARGIN < min(max_echo_range(scene.radar), scene.horizon()):
        return None  # it is in range at the start, as most are
    nearest, top = nearest_and_top(body, scene)
    if nearest > max_echo_range(scene.radar):
        return CulledBody(f"always out of range: never nearer than {nearest / 1000:.1f} km", 0.0, occludes=False)
    if top < 0.0:
        return CulledBody(f"always under the sea: its top is {-top:.1f} m below", 0.0, occludes=False)
    if nearest <= (horizon := scene.horizon(top)) or height_over_horizon(body, scene, fidelity.sampler) > 0.0:
        return None
    text = f"always beyond the radar horizon: {horizon / 1000:.1f} km for its top at {top:.0f} m, never nearer than "
    return CulledBody(f"{text}{nearest / 1000:.1f} km", 0.0, occludes=False)


def _below_noise(scene: Scene, fidelity: Fidelity, keys: list[int]) -> dict[int, CulledBody]:
    """The bodies of `keys` whose maximum powers together keep the budget below the noise, weakest first."""
    if not scene.environment.noise:
        return {}
    radar, budget = scene.radar, ErrorBudget(fidelity.error_db)
    noise = receiver_noise_power(radar)
    lobe = MAIN_LOBE * radar.sample_rate / radar.bandwidth  # samples that an echo fills
    spoke_share = 10.0 ** (budget.field_db / 10.0) * radar.bins / lobe
    allowed = noise * min(budget.share, spoke_share)
    powers = {key: max_power(scene.bodies[key], scene, fidelity) for key in keys}
    culled, total = {}, 0.0
    for key in sorted(keys, key=lambda k: (powers[k], k)):
        total += powers[key]
        if total > allowed:
            break
        level, error = 10.0 * math.log10(powers[key] / noise), 10.0 * math.log10(1.0 + total / noise)
        culled[key] = CulledBody(f"always below the noise: at most {level:.0f} dB of it", error, occludes=True)
    return culled
