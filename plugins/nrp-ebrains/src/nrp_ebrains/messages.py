"""The messages of Protocol Buffers that NRP-core 4 brings along, as classes of Google's library.

They are described here as data, so that no compiler is needed, and live in a pool of their own, so that they
do not collide with those of an installed NRP-core 4.
"""

from __future__ import annotations

from functools import cache
from types import ModuleType
from typing import Any, Final

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from google.protobuf.message import Message

_Fields = dict[str, str]
_SCALARS: Final = ("Bool", "Bytes", "Float", "Double", "Int32", "Int64", "String")
_ARRAYS: Final = (*_SCALARS, "SInt32", "SInt64", "UInt32", "UInt64")
_MOTION: Final = {
    "position": "float[]", "rotation": "float[]", "linearVelocity": "float[]", "angularVelocity": "float[]",
}  # fmt: skip
PACKAGES: Final[dict[str, dict[str, _Fields]]] = {
    "Gazebo": {
        "Camera": {
            "imageHeight": "uint32", "imageWidth": "uint32", "imageDepth": "uint32", "imageData": "bytes",
        },
        "Joint": {"position": "float", "velocity": "float", "effort": "float"},
        "Link": _MOTION,
        "Model": _MOTION,
    },
    "Dump": {
        "String": {"string_stream": "string"},
        "ArrayFloat": {"float_stream": "float[]", "dims": "uint32[]"},
    },
    "Wrappers": {f"{kind}Value": {"value": kind.lower()} for kind in _SCALARS},
    "NrpGenericProto": {
        **{f"Array{kind}": {"array": f"{kind.lower()}[]", "shape": "uint32[]"} for kind in _ARRAYS},
        "Image": {
            "height": "uint32", "width": "uint32", "step": "uint32", "type": "IMAGE_TYPE",
            "isBigEndian": "bool", "data": "bytes",
        },
    },
    "EngineTest": {"TestPayload": {"integer": "int32", "str": "string"}},
}  # fmt: skip
"""Fields of each message in each package; ``[]`` marks a repeated field."""
_IMAGE_TYPES: Final = (
    "OTHER", "RGB8", "RGBA8", "RGB16", "RGBA16", "BGR16", "BGRA16", "MONO8", "MONO16", "BAYER_RGGB8",
    "BAYER_BGGR8", "BAYER_GBRG8", "BAYER_GRBG8", "BAYER_RGGB16", "BAYER_BGGR16", "BAYER_GBRG16",
    "BAYER_GRBG16",
)  # fmt: skip
_ENUM: Final = "IMAGE_TYPE"


def _file(package: str) -> descriptor_pb2.FileDescriptorProto:
    field = descriptor_pb2.FieldDescriptorProto
    file = descriptor_pb2.FileDescriptorProto(
        name=f"{package.lower()}.proto", package=package, syntax="proto3"
    )
    if package == "NrpGenericProto":
        values = enumerate(_IMAGE_TYPES)
        file.enum_type.add(name=_ENUM, value=[{"name": name, "number": i} for i, name in values])
    for name, fields in PACKAGES[package].items():
        described = file.message_type.add(name=name)
        for number, (key, kind) in enumerate(fields.items(), 1):
            added = described.field.add(name=key, number=number)
            added.label = field.LABEL_REPEATED if kind.endswith("[]") else field.LABEL_OPTIONAL
            if kind == _ENUM:
                added.type, added.type_name = field.TYPE_ENUM, f".{package}.{_ENUM}"
            else:
                added.type = field.Type.Value(f"TYPE_{kind.removesuffix('[]').upper()}")
    return file


@cache
def message_classes() -> dict[str, dict[str, type[Message]]]:
    """Return the classes of all messages, by package and name."""
    pool = descriptor_pool.DescriptorPool()
    for package in PACKAGES:
        pool.Add(_file(package))
    find = pool.FindMessageTypeByName
    return {
        package: {name: message_factory.GetMessageClass(find(f"{package}.{name}")) for name in messages}
        for package, messages in PACKAGES.items()
    }


@cache
def message_modules() -> dict[str, ModuleType]:
    """Return the modules ``<package>_pb2``, by name, with a class for each message."""
    modules: dict[str, ModuleType] = {}
    for package, classes in message_classes().items():
        name = f"{package.lower()}_pb2"
        names: dict[str, Any] = dict(classes)
        if package == "NrpGenericProto":
            names[_ENUM] = _image_types()
        modules[name] = ModuleType(f"nrp_protobuf.{name}")
        vars(modules[name]).update(names, __all__=list(names))
    return modules


def _image_types() -> type:
    return type(_ENUM, (), {name: i for i, name in enumerate(_IMAGE_TYPES)})


def as_lines(message: Message, *, header: bool) -> str:
    """Return the values of the fields of a message, or their names, separated by commas.

    Numbers are printed as NRP-core 4 does: with six decimals, and truth values as 1 and 0.
    """
    names = [one.name for one in message.DESCRIPTOR.fields]
    return ",".join(names if header else (_printed(getattr(message, name)) for name in names))


def _printed(value: Any) -> str:
    if isinstance(value, bool):
        return str(int(value))
    return f"{value:.6f}" if isinstance(value, float) else str(value)
