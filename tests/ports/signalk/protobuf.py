"""The message of spokes as the library of Protocol Buffers decodes it, from the fields of the published description."""

from typing import Any

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

FIELDS = (  # name, number, type, whether presence counts
    ("angle", 1, "UINT32", False), ("bearing", 2, "UINT32", True), ("range", 3, "UINT32", False), ("time", 4, "UINT64", True),
    ("data", 5, "BYTES", False), ("lat", 6, "DOUBLE", True), ("lon", 7, "DOUBLE", True),
)  # fmt: skip


def _message_class() -> Any:
    file = descriptor_pb2.FileDescriptorProto(name="spokes.proto", syntax="proto3")
    outer = file.message_type.add(name="RadarMessage")
    spoke = outer.nested_type.add(name="Spoke")
    kinds = descriptor_pb2.FieldDescriptorProto
    for name, number, kind, is_optional in FIELDS:
        field = spoke.field.add(name=name, number=number, type=getattr(kinds, f"TYPE_{kind}"), label=kinds.LABEL_OPTIONAL)
        if is_optional:
            spoke.oneof_decl.add(name=f"_{name}")
            field.oneof_index, field.proto3_optional = len(spoke.oneof_decl) - 1, True
    outer.field.add(
        name="spokes", number=2, type=kinds.TYPE_MESSAGE, label=kinds.LABEL_REPEATED, type_name=".RadarMessage.Spoke"
    )
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName("RadarMessage"))


_CLASS = _message_class()


def spokes(message: bytes) -> list[dict[str, Any]]:
    """The spokes of a message, each with the fields that it has."""
    decoded = _CLASS.FromString(message)
    return [{field.name: value for field, value in spoke.ListFields()} for spoke in decoded.spokes]
