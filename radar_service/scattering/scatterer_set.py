"""The scattering models of a set of bodies, and the echoes of all of them at an instant."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import cast

import numpy as np

from radar_service.numerics import Floats, Indices
from radar_service.scattering.model import AspectModel, BodyEchoes, Instant, ScatteringContext, ScatteringModel
from radar_service.scattering.models import scattering_model
from radar_service.world import Body


@dataclass(frozen=True)
class ScattererSet:
    """Bodies (B,), their indices in the scene `key` (B,), rising, and the models that scatter for them."""

    bodies: tuple[Body, ...]
    key: Indices
    models: tuple[ScatteringModel, ...]

    def __len__(self) -> int:
        return len(self.bodies)

    @property
    def scatterers(self) -> Indices:
        """How many fixed scatterers each body (B,) has."""
        counts = np.zeros(len(self), dtype=np.int64)
        for model in self.models:
            counts[np.searchsorted(self.key, model.key)] = model.scatterers
        return counts

    @cached_property
    def steady(self) -> "ScattererSet":
        """The same bodies without those models whose echoes depend on aspect."""
        return replace(self, models=tuple(model for model in self.models if not model.by_aspect))

    @property
    def by_aspect(self) -> "ScattererSet":
        """Bodies whose echoes depend on aspect."""
        keys = np.sort(np.concatenate([np.zeros(0, dtype=np.int64), *(model.key for model in self.aspect_models)]))
        bodies = tuple(self.bodies[b] for b in np.searchsorted(self.key, keys))
        return ScattererSet(bodies, keys, tuple(self.aspect_models))

    def joined(self, other: "ScattererSet") -> "ScattererSet":
        """Bodies of both sets, which are of one scene."""
        keys = np.concatenate([self.key, other.key])
        order, bodies = np.argsort(keys), (*self.bodies, *other.bodies)
        return ScattererSet(tuple(bodies[b] for b in order.tolist()), keys[order], (*self.models, *other.models))

    @property
    def aspect_models(self) -> list[AspectModel]:
        """The models whose echoes depend on aspect."""
        return [cast(AspectModel, model) for model in self.models if model.by_aspect]

    def echoes(self, antenna: Floats, instant: Instant) -> BodyEchoes:
        """Echoes of all bodies, by rising body, as the antenna (3,) observes them at an instant."""
        parts = [(np.searchsorted(self.key, model.key), model.echoes(antenna, instant)) for model in self.models]
        joined = BodyEchoes.joined([part for _, part in parts])
        body = np.concatenate([np.zeros(0, dtype=np.int64), *(own[part.body] for own, part in parts)])
        if (np.diff(body) < 0).any():
            order = np.argsort(body, kind="stable")
            joined, body = joined.chosen(order), body[order]
        return replace(joined, body=body)


def build_scatterers(bodies: Sequence[Body], key: Sequence[int], context: ScatteringContext) -> ScattererSet:
    """The scatterers of `bodies`; key: (B,) the index of each in the scene, rising."""
    chosen = [scattering_model(body, context.fidelity.sampler) for body in bodies]
    models = []
    for model in dict.fromkeys(chosen):
        which = [b for b, model_of_body in enumerate(chosen) if model_of_body is model]
        keys = np.array([key[b] for b in which], dtype=np.int64)
        models.append(model.build([bodies[b] for b in which], keys, context))
    return ScattererSet(tuple(bodies), np.array(key, dtype=np.int64), tuple(models))
