"""The parts of the package `mcap` that recordings use."""

from radar_service.terminal import extra

with extra("record", "recordings"):
    from mcap.data_stream import ReadDataStream
    from mcap.opcode import Opcode
    from mcap.records import Channel, Chunk, Header, Message
    from mcap.stream_reader import breakup_chunk
    from mcap.writer import MCAP0_MAGIC, CompressionType, Writer

__all__ = [
    "MCAP0_MAGIC", "Channel", "Chunk", "CompressionType", "Header", "Message", "Opcode", "ReadDataStream", "Writer",
    "breakup_chunk",
]  # fmt: skip
