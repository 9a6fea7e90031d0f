"""What ROS 2's C libraries need of a type, made in Python: no code is generated and compiled.

ROS passes a message as a pointer to a C structure that only functions of its type read. Here this structure
holds the encoded bytes of the message. The functions that convert it from and to Python's messages are in
Python; those that the middleware calls are machine code. The structures are those of ``rosidl_runtime_c`` and
``rosidl_typesupport_fastrtps_cpp``, the same since ROS 2 Jazzy. The middlewares Fast DDS and Zenoh use this
type support; Cyclone DDS uses another.
"""

from __future__ import annotations

import ctypes
import mmap
import platform
import sys
from collections.abc import Callable, Iterable
from ctypes import (
    CFUNCTYPE,
    POINTER,
    Structure,
    c_bool,
    c_char,
    c_char_p,
    c_size_t,
    c_uint8,
    c_void_p,
)
from pathlib import Path
from typing import Any

from nrp_core.errors import NrpError

MIDDLEWARES = ("rmw_fastrtps_cpp", "rmw_zenoh_cpp")
"""Middlewares that use this type support."""

_IDENTIFIER = b"rosidl_typesupport_fastrtps_c"
_HEAD = 4
"""Length of the header of encoded data."""


class _Hash(Structure):
    _fields_ = (("version", c_uint8), ("value", c_uint8 * 32))


class _Sequence(Structure):
    """A sequence in C, for example of bytes; a message is one."""

    _fields_ = (("data", c_void_p), ("size", c_size_t), ("capacity", c_size_t))

    @property
    def bytes(self) -> bytes:
        """Its bytes."""
        return ctypes.string_at(self.data, self.size)


class _String(Structure):
    _fields_ = (("data", c_char_p), ("size", c_size_t), ("capacity", c_size_t))


class _Description(Structure):
    """Only the name of the type: the service with which nodes describe their types is for people."""

    _fields_ = (("name", _String), ("fields", _Sequence), ("referenced", _Sequence))


_ABOUT = (("hash", c_void_p), ("description", c_void_p), ("sources", c_void_p))


class _Message(Structure):
    _fields_ = (("identifier", c_char_p), ("data", c_void_p), ("find", c_void_p), *_ABOUT)


class _Service(Structure):
    _fields_ = (
        ("identifier", c_char_p), ("data", c_void_p), ("find", c_void_p), ("request", POINTER(_Message)),
        ("response", POINTER(_Message)), ("event", c_void_p), ("create_event", c_void_p),
        ("destroy_event", c_void_p), *_ABOUT,
    )  # fmt: skip


class _Action(Structure):
    _fields_ = (
        ("goal", c_void_p), ("result", c_void_p), ("cancel", c_void_p), ("feedback", c_void_p),
        ("status", c_void_p), *_ABOUT,
    )  # fmt: skip


_Create = CFUNCTYPE(c_void_p)
_Destroy = CFUNCTYPE(None, c_void_p)
_FromPython = CFUNCTYPE(c_bool, ctypes.py_object, c_void_p)
_ToPython = CFUNCTYPE(ctypes.py_object, c_void_p)


class _MessageFunctions(Structure):
    _fields_ = (
        ("namespace", c_char_p), ("name", c_char_p), ("encode", c_void_p), ("decode", c_void_p),
        ("size", c_void_p), ("max_size", c_void_p), ("key", c_void_p),
    )  # fmt: skip


class _ServiceTypes(Structure):
    _fields_ = (
        ("namespace", c_char_p), ("name", c_char_p), ("request", POINTER(_Message)),
        ("response", POINTER(_Message)),
    )  # fmt: skip


class MachineCode:
    """Functions that C calls while it holds a lock of the middleware.

    A function in Python may wait there for the interpreter, which another thread holds while it waits for the
    lock. These are a few instructions by the calling conventions of Linux, on x86-64 and on 64-bit Arm.
    """

    def __init__(self) -> None:
        self._memory = mmap.mmap(-1, 1 << 20, prot=mmap.PROT_READ | mmap.PROT_WRITE | mmap.PROT_EXEC)
        self._start = ctypes.addressof(c_char.from_buffer(self._memory))
        self._is_arm = platform.machine() == "aarch64"

    def returning(self, value: int, after: int) -> int:
        """Return the address of a function that calls the one at ``after`` and returns a number."""
        a, b = (each.to_bytes(8, "little") for each in (after, value))
        if self._is_arm:
            return self._add(bytes.fromhex("fd7bbfa9 a8000058 00013fd6 a0000058 fd7bc1a8 c0035fd6") + a + b)
        return self._add(b"\x48\x83\xec\x08\x48\xb8" + a + b"\xff\xd0\x48\x83\xc4\x08\x48\xb8" + b + b"\xc3")

    def clearing(self) -> int:
        """Return the address of a function that sets the byte at its argument to 0 and returns 0."""
        return self._add(bytes.fromhex("1f000039 000080d2 c0035fd6" if self._is_arm else "c60700 31c0 c3"))

    def size(self) -> int:
        """Return the address of a function that returns the size of a sequence, given its address."""
        return self._add(bytes.fromhex("000840b9 c0035fd6" if self._is_arm else "8b4708 c3"))

    def encoding(self, write: int) -> int:
        """Return the address of a function that writes a sequence to an encoder, its arguments.

        Args:
            write: the function of an encoder, data and their size.
        """
        a = write.to_bytes(8, "little")
        if self._is_arm:
            code = "fd7bbfa9 e30300aa e00301aa 610840a9 c4000058 80003fd6 20008052 fd7bc1a8 c0035fd6 1f2003d5"
            return self._add(bytes.fromhex(code) + a)
        before, after = "4889f8 4889f7 488b30 488b5008 4883ec08 48b8", "ffd0 4883c408 b801000000 c3"
        return self._add(bytes.fromhex(before) + a + bytes.fromhex(after))

    def decoding(self, buffer_at: int, data_at: int, copy: int) -> int:
        """Return the address of a function that copies all data of a decoder to a sequence, its arguments.

        Args:
            buffer_at: where the decoder has a pointer to its buffer.
            data_at: where the buffer has its data and their size, like a sequence.
            copy: the function that copies one sequence to another.
        """
        a = copy.to_bytes(8, "little")
        if self._is_arm:
            load, add = 0xF9400000 | buffer_at // 8 << 10, 0x91000000 | data_at << 10
            head = load.to_bytes(4, "little") + add.to_bytes(4, "little")
            return self._add(head + bytes.fromhex("42000058 40001fd6") + a)
        places = [each.to_bytes(4, "little") for each in (buffer_at, data_at)]
        return self._add(
            b"\x48\x8b\xbf" + places[0] + b"\x48\x81\xc7" + places[1] + b"\x48\xb8" + a + b"\xff\xe0"
        )

    def _add(self, code: bytes) -> int:
        place = self._memory.tell()
        self._memory.write(code.ljust(-(-len(code) // 16) * 16, b"\0"))
        return self._start + place


class TypeSupport:
    """Makes the type support of messages, services and actions, as the attributes of their metaclasses.

    Args:
        folders: those of an installation of ROS, in which its libraries are.
    """

    def __init__(self, folders: Iterable[Path]) -> None:
        runtime = _library(folders, "librosidl_runtime_c.so")
        cdr = _library(folders, "libfastcdr.so", "libfastcdr.so.2")
        self._code = MachineCode()
        self._reset_error = _function(_library(folders, "librcutils.so").rcutils_reset_error)
        self._find_message = ctypes.cast(runtime.get_message_typesupport_handle_function, c_void_p)
        self._find_service = ctypes.cast(runtime.get_service_typesupport_handle_function, c_void_p)
        self._copy = runtime.rosidl_runtime_c__uint8__Sequence__copy
        self._copy.argtypes = (c_void_p, c_void_p)
        self._end = runtime.rosidl_runtime_c__uint8__Sequence__fini
        self._end.argtypes = (c_void_p,)
        self._messages: dict[int, _Sequence] = {}
        self._kept: list[Any] = []  # C holds pointers to them as long as the process runs
        self._create, self._destroy = _Create(self._new), _Destroy(self._forget)
        write = _function(cdr._ZN8eprosima7fastcdr3Cdr15serialize_arrayEPKcm)
        self._functions = (
            self._code.encoding(write), self._code.decoding(*_cdr_layout(cdr), _function(self._copy)),
            self._code.size(), self._code.clearing(), None,
        )  # fmt: skip

    def message(
        self,
        name: str,
        digest: str,
        encode: Callable[[Any], bytes],
        decode: Callable[[bytes], Any],
        empty: Callable[[], Any],
    ) -> dict[str, Any]:
        """Return the attributes for a type of messages.

        Args:
            name: the type, ``package/msg/Type`` or ``package/srv/Type_Request``.
            digest: its hash, ``RIHS01_...``.
            encode: returns a message as bytes, with their header.
            decode: returns the message in bytes.
            empty: returns a message in place of bytes that cannot be decoded.
        """

        def from_python(message: Any, address: int) -> bool:
            try:
                data = encode(message)[_HEAD:]
            except NrpError as error:  # rclpy raises an error without a reason
                report(error)
                return False
            given = _Sequence(ctypes.cast(c_char_p(data), c_void_p), len(data))
            return bool(self._copy(ctypes.byref(given), address))

        def to_python(address: int) -> Any:
            try:
                return decode(self._messages[address].bytes)
            except NrpError as error:  # the sender has another type of that name
                report(error)
                return empty()

        functions = _MessageFunctions(*_dds_name(name), *self._functions)
        support = _Message(_IDENTIFIER, _address(functions), self._find_message, *self._about(name, digest))
        given = _FromPython(from_python), _ToPython(to_python)
        self._kept += functions, support, given
        return {
            "_TYPE_SUPPORT": _capsule(ctypes.addressof(support)),
            "_CREATE_ROS_MESSAGE": _capsule(_function(self._create)),
            "_DESTROY_ROS_MESSAGE": _capsule(_function(self._destroy)),
            "_CONVERT_FROM_PY": _capsule(_function(given[0])),
            "_CONVERT_TO_PY": _capsule(_function(given[1])),
        }

    def service(self, name: str, digest: str, request: type, response: type) -> dict[str, Any]:
        """Return the attributes for a type of services; its calls cannot be introspected.

        Args:
            name: the type, ``package/srv/Type``.
            digest: its hash.
            request: the class of requests.
            response: the class of responses.
        """
        ends = [ctypes.cast(_pointer(end), POINTER(_Message)) for end in (request, response)]
        types = _ServiceTypes(*_dds_name(name), *ends)
        about = self._about(name, digest)
        find = self._find_service
        support = _Service(_IDENTIFIER, _address(types), find, *ends, None, None, None, *about)
        self._kept += types, support
        return {"_TYPE_SUPPORT": _capsule(ctypes.addressof(support))}

    def action(self, name: str, digest: str, parts: Iterable[type]) -> dict[str, Any]:
        """Return the attributes for a type of actions.

        Args:
            name: the type, ``package/action/Type``.
            digest: its hash.
            parts: the classes of its services for goals, results and cancelling, and of its messages of
                feedback and status.
        """
        support = _Action(*map(_pointer, parts), *self._about(name, digest))
        self._kept.append(support)
        return {"_TYPE_SUPPORT": _capsule(ctypes.addressof(support))}

    def _about(self, name: str, digest: str) -> list[Any]:
        text = name.encode()
        version, _, value = digest.removeprefix("RIHS").partition("_")
        constants = (
            _Hash(int(version), (c_uint8 * 32)(*bytes.fromhex(value))),
            _Description(_String(text, len(text), len(text) + 1)),
            _Sequence(),
        )

        self._kept += (text, *constants)
        # Fast DDS has found no introspection, which it does not need, and has set an error
        after = self._reset_error
        return [self._code.returning(ctypes.addressof(each), after) for each in constants]

    def _new(self) -> int:
        made = _Sequence()
        address = ctypes.addressof(made)
        self._messages[address] = made
        return address

    def _forget(self, address: int) -> None:
        if address in self._messages:
            self._end(address)
            del self._messages[address]


def _word(address: int) -> int:
    return c_size_t.from_address(address).value


def _cdr_layout(cdr: Any) -> tuple[int, int]:
    """Return the offset of the buffer in a Fast CDR decoder, and that of the data in the buffer.

    It is read from a decoder of a known buffer, so it does not depend on the version of the library.

    Raises:
        StopIteration: the size is elsewhere.
    """
    size, words = 4242, 256
    data, buffer, decoder = (ctypes.create_string_buffer(each) for each in (size, 8 * words, 8 * words))
    places = [ctypes.addressof(each) for each in (data, buffer, decoder)]
    make_buffer = cdr._ZN8eprosima7fastcdr10FastBufferC1EPcm
    make_buffer.argtypes = (c_void_p, c_void_p, c_size_t)
    make_decoder = cdr._ZN8eprosima7fastcdr3CdrC1ERNS0_10FastBufferENS1_10EndiannessENS0_10CdrVersionE
    make_decoder.argtypes = (c_void_p, c_void_p, c_uint8, ctypes.c_int)
    make_buffer(places[1], places[0], size)
    make_decoder(places[2], places[1], 1, 1)

    def find(value: int, place: int) -> int:
        return next(offset for offset in range(0, 8 * words, 8) if _word(place + offset) == value)

    data_at = find(places[0], places[1])
    if find(size, places[1]) != data_at + 8:
        raise StopIteration("the size of a buffer does not follow its data")
    return find(places[1], places[2]), data_at


def report(error: Exception) -> None:
    """Print an error, which C cannot pass on."""
    print(f"error: {error}", file=sys.stderr, flush=True)


def _library(folders: Iterable[Path], *names: str) -> Any:
    """Return a library of ROS, which its client library has loaded already."""
    present = [folder / "lib" / name for folder in folders for name in names[:1]]
    return ctypes.CDLL(str(next((each for each in present if each.exists()), names[-1])))


def _dds_name(name: str) -> tuple[bytes, bytes]:
    space, _, short = name.rpartition("/")
    return space.replace("/", "::").encode(), short.encode()


def _address(structure: Structure) -> c_void_p:
    return c_void_p(ctypes.addressof(structure))


def _function(function: Any) -> int:
    address = ctypes.cast(function, c_void_p).value
    assert address is not None
    return address


def _capsule(address: int) -> Any:
    make = ctypes.pythonapi.PyCapsule_New
    make.argtypes, make.restype = (c_void_p, c_char_p, c_void_p), ctypes.py_object
    return make(address, None, None)


def _pointer(cls: Any) -> int:
    """Return the address of the type support of a class, of this ROS or made here."""
    if cls.__class__._TYPE_SUPPORT is None:
        cls.__class__.__import_type_support__()
    capsule = cls.__class__._TYPE_SUPPORT
    name, read = ctypes.pythonapi.PyCapsule_GetName, ctypes.pythonapi.PyCapsule_GetPointer
    name.argtypes, name.restype = (ctypes.py_object,), c_char_p
    read.argtypes, read.restype = (ctypes.py_object, c_char_p), c_void_p
    address: int = read(capsule, name(capsule))
    return address
