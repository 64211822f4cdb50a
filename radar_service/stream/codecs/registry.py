"""The protocols of this server. A new protocol is one line here."""

from radar_service.stream.codecs.codec import Codec
from radar_service.stream.codecs.native.codec import NativeCodec

CODECS: dict[str, Codec] = {
    "native": NativeCodec(),
}
