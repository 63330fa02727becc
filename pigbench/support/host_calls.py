"""Calls from a compiled program into Python, by way of XLA's foreign function interface on CPUs.

`jax.pure_callback` does the same, but takes five times as long for small arrays, and JAX keeps no
program that has it in the persistent cache, so that every process would compile it again.

The structures are those of xla/ffi/api/c_api.h, which jaxlib has in its folder of headers.
"""

# ctypes has no types for the fields of structures.
# pyright: reportAttributeAccessIssue=false

import ctypes
import math
import traceback
from collections.abc import Callable, Sequence
from typing import Any

import jax
import numpy as np

from pigbench import devices

_TARGET = "pigbench_host_call"
_VERSION = (0, 3)  # of the interface; XLA refuses to start if it does not support it
_METADATA = 1  # the kind of an extension of a frame in which XLA asks for the version
_INTERNAL = 13  # the code of an error that is not the user's
_DTYPES = {1: np.dtype(bool), 4: np.dtype(np.int32), 11: np.dtype(np.float32)}

_functions: dict[str, Callable[..., list[Any]]] = {}  # programs in the cache know only the names


def host_call(name: str, function: Callable[..., Any], results: Any, *args: Any) -> Any:
    """`function(*args)`, run on the host in NumPy whenever a program gets there.

    Args:
        name: what the function computes. The first function of a name stays, and is taken for any
            other of that name.
        function: takes and returns trees of arrays; under vmap, all have the batch's dimensions in
            front. It must be pure, and its arguments are XLA's own memory, which is gone when
            it returns. An exception becomes JAX's `JaxRuntimeError`.
        results: the shapes and dtypes of what it returns.
        args: trees of arrays.
    """
    leaves, structure = jax.tree.flatten(args)
    shapes, result_structure = jax.tree.flatten(results)

    def flat(*arrays: Any) -> list[Any]:
        return jax.tree.leaves(function(*jax.tree.unflatten(structure, arrays)))

    if _can_call([*leaves, *shapes]):
        name = f"{name} of {structure}"
        _functions.setdefault(name, flat)
        # With a side effect, JAX waits for programs that run when Python ends.
        call = jax.ffi.ffi_call(_TARGET, shapes, vmap_method="broadcast_all", has_side_effect=True)
        found = call(*leaves, function=name)
    else:
        found = jax.pure_callback(flat, shapes, *leaves, vmap_method="broadcast_all")
    return jax.tree.unflatten(result_structure, found)


def _can_call(arrays: Sequence[Any]) -> bool:
    """Whether the interface can be used: with several devices, XLA could not divide the call."""
    alone = devices.backend() == "cpu" and jax.device_count() == 1
    return alone and all(jax.dtypes.result_type(x) in _DTYPES.values() for x in arrays)


def _structure(name: str, *fields: tuple[str, Any], headed: bool = True) -> type[ctypes.Structure]:
    """A structure; most begin with their size and a pointer to extensions."""
    head = [("size", ctypes.c_size_t), ("extension", ctypes.c_void_p)] if headed else []
    return type(name, (ctypes.Structure,), {"_fields_": [*head, *fields]})


_pointer, _many = ctypes.POINTER, lambda kind: ctypes.POINTER(ctypes.POINTER(kind))

_Buffer = _structure(
    "Buffer",
    ("dtype", ctypes.c_int),
    ("data", ctypes.c_void_p),
    ("rank", ctypes.c_int64),
    ("dims", _pointer(ctypes.c_int64)),
)
_Buffers = _structure(
    "Buffers", ("count", ctypes.c_int64), ("kinds", ctypes.c_void_p), ("items", _many(_Buffer))
)
_String = _structure("String", ("data", ctypes.c_void_p), ("length", ctypes.c_size_t), headed=False)
_Attributes = _structure(
    "Attributes",
    ("count", ctypes.c_int64),
    ("kinds", ctypes.c_void_p),
    ("names", ctypes.c_void_p),
    ("values", _many(_String)),
)
_Version = _structure("Version", ("major", ctypes.c_int), ("minor", ctypes.c_int))
_Error = _structure("Error", ("message", ctypes.c_char_p), ("code", ctypes.c_int))
_Api = _structure(
    "Api",
    ("version", _Version),
    ("internal", ctypes.c_void_p),
    ("create_error", ctypes.CFUNCTYPE(ctypes.c_void_p, _pointer(_Error))),
)
_Frame = _structure(
    "Frame",
    ("api", _pointer(_Api)),
    ("context", ctypes.c_void_p),
    ("stage", ctypes.c_int),
    ("arguments", _Buffers),
    ("results", _Buffers),
    ("attributes", _Attributes),
)
_Metadata = _structure("Metadata", ("size", ctypes.c_size_t), ("version", _Version), headed=False)
_Extension = _structure(
    "Extension",
    ("size", ctypes.c_size_t),
    ("kind", ctypes.c_int),
    ("next", ctypes.c_void_p),
    ("metadata", _pointer(_Metadata)),
    headed=False,
)


_outcomes: dict[int, int | None] = {}  # by frame: None, or the address of an error


@ctypes.CFUNCTYPE(None, _pointer(_Frame))
def _work(pointer: Any) -> None:
    """Call the function that the frame names, with its arguments, and fill in the results.

    A signal that came while XLA was running on Python's main thread is raised here before the first
    line, and the frame then has no outcome.
    """
    frame, address = pointer.contents, ctypes.addressof(pointer.contents)
    try:
        if not _introduced(frame):
            name = frame.attributes.values[0].contents
            function = _functions[ctypes.string_at(name.data, name.length).decode()]
            arguments, rooms = _arrays(frame.arguments), _arrays(frame.results)
            for argument in arguments:
                argument.flags.writeable = False
            for room, result in zip(rooms, function(*arguments), strict=True):
                _fill(room, result)
        _outcomes[address] = None
    except BaseException:
        _outcomes[address] = _error(frame, traceback.format_exc())


def _outcome(_: None, __: Any, arguments: tuple[Any]) -> int | None:
    """What the handler returns to XLA for the frame."""
    frame = arguments[0].contents
    address = ctypes.addressof(frame)
    if address in _outcomes:
        return _outcomes.pop(address)
    return _error(frame, "interrupted by a signal")


def _introduced(frame: Any) -> bool:
    """Whether XLA asks only for the version of the interface, which is then told."""
    if not frame.extension:
        return False
    extension = _Extension.from_address(frame.extension)
    if extension.kind != _METADATA:
        return False
    version = extension.metadata.contents.version
    version.major, version.minor = _VERSION
    return True


def _error(frame: Any, message: str) -> int:
    """The address of a new error."""
    text = message.encode(errors="backslashreplace")
    return frame.api.contents.create_error(_Error(ctypes.sizeof(_Error), None, text, _INTERNAL))


def _arrays(buffers: Any) -> list[np.ndarray]:
    return [_array(buffers.items[place].contents) for place in range(buffers.count)]


def _array(buffer: Any) -> np.ndarray:
    """The buffer's memory as an array, without a copy."""
    shape, dtype = buffer.dims[: buffer.rank], _DTYPES[buffer.dtype]
    memory = (ctypes.c_char * (dtype.itemsize * math.prod(shape))).from_address(buffer.data)
    return np.ndarray(shape, dtype, memory)


def _fill(room: np.ndarray, result: Any) -> None:
    if np.shape(result) != room.shape:
        raise ValueError(f"a result has the shape {np.shape(result)} instead of {room.shape}")
    np.copyto(room, result, casting="same_kind")


# An exception that leaves a function of ctypes makes it return an address at random. A signal that
# is due is raised by the first line of Python, which is that of `_work`, which returns nothing.
_guarded = ctypes.cast(_work, ctypes.PYFUNCTYPE(None, _pointer(_Frame)))
_guarded.errcheck = _outcome
_handle = ctypes.CFUNCTYPE(ctypes.c_void_p, _pointer(_Frame))(_guarded)
jax.ffi.register_ffi_target(_TARGET, jax.ffi.pycapsule(_handle), platform="cpu")
