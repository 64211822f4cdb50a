"""The protocols of this server. A new protocol is one line here."""

from radar_service.service.codecs.codec import Codec
from radar_service.service.codecs.native.messages import NativeCodec

_CODECS: tuple[Codec, ...] = (NativeCodec(),)

CODECS: dict[str, Codec] = {codec.name: codec for codec in _CODECS}
