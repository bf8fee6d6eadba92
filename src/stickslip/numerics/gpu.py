"""Running kernels on a GPU: is there one, scratch arrays of a thread, launching.

The CPU's kernels run there. Only this module and the templates named ``_cuda_..._kernels`` know
numba's CUDA target, which is imported when somebody asks for it.
"""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Iterator, Sequence
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.numerics.targets import write_module

# Threads of a block: small, because a motion needs many registers.
THREADS = 128


def gpu_fault() -> str:
    """Tell why motions cannot run on a GPU (or on numba's simulator of one); "" if they can."""
    try:
        from numba import cuda

        return "" if cuda.is_available() else "none was found"
    except Exception as error:  # versions of packages that do not fit raise what they meet
        return f"importing numba-cuda gave {error!r}"


def require_gpu() -> None:
    """Raise ValueError unless motions can run on a GPU."""
    if fault := gpu_fault():
        raise ValueError(
            "device = 'cuda' needs an NVIDIA GPU, its driver and the package numba-cuda "
            f"(pip install 'stickslip[gpu]'); {fault}. Take device='cpu', or look at what "
            "`stickslip doctor` says."
        )


def gpu_name() -> str:
    """Name and compute capability of the GPU that is used."""
    from numba import cuda

    if not hasattr(cuda, "get_current_device"):
        return "numba's simulator"
    device = cuda.get_current_device()
    name = device.name.decode() if isinstance(device.name, bytes) else device.name
    major, minor = device.compute_capability
    return f"{name}, compute {major}.{minor}"


def device_array(shape: tuple[int, ...], dtype: Any) -> Any:
    """Make an array on the device, an input of `launch_on_gpu` that never leaves it."""
    from numba import cuda

    return cuda.device_array(shape, dtype)


def launch_on_gpu(
    kernel: Any,
    size: int,
    inputs: Sequence[Any],
    outputs: Sequence[NDArray[Any]],
    *,
    filled: bool = False,
) -> None:
    """Run a kernel, called with inputs and outputs, with one thread for each of `size` items.

    The kernel writes every entry of the outputs, unless they are `filled`: copied there before.
    """
    from numba import cuda

    if size == 0:
        return
    sent = [cuda.to_device(x) if isinstance(x, np.ndarray) else x for x in inputs]
    place = cuda.to_device if filled else cuda.device_array_like
    received = [place(x) for x in outputs]
    with warnings.catch_warnings():
        # How many items there are is the caller's question; that few leave a device idle is clear.
        warnings.filterwarnings("ignore", ".*Grid size")
        kernel[-(-size // THREADS), THREADS](*sent, *received)
    for array, there in zip(outputs, received, strict=True):
        if array.size > 0:
            array[...] = there.copy_to_host()


def local_arrays(stem: str, **examples: tuple[NDArray[Any] | tuple[Any, ...], ...]) -> ModuleType:
    """Write device functions that make arrays like the given ones, zeros, local to a thread.

    Numba wants shapes of local arrays in the text, and these functions inlined into the kernel.
    """
    functions = [_maker(name, example) for name, example in examples.items()]
    classes = {kind for example in examples.values() for kind in _classes(example)}
    imports = sorted(f"from {kind.__module__} import {kind.__name__}" for kind in classes)
    head = ["from numba import cuda, float64, int8, int64", *imports]
    return write_module(stem, "\n".join([*head, *functions]) + "\n")


def _classes(value: Any) -> Iterator[type]:
    if not isinstance(value, np.ndarray | None):
        if type(value) is not tuple:
            yield type(value)
        for part in value:
            yield from _classes(part)


def _maker(name: str, example: tuple[Any, ...]) -> str:
    counter = itertools.count()
    lines: list[str] = []
    names: dict[int, str] = {}  # of arrays by identity

    def made(value: Any) -> str:
        if value is None:
            return "None"
        if isinstance(value, np.ndarray):
            array = names[id(value)] = f"a{next(counter)}"
            whole = names.get(id(value.base)) if value.size else None
            lines.extend(_part_lines(array, value, whole) if whole else _array_lines(array, value))
            return array
        parts = ", ".join([made(part) for part in value])
        return f"({parts},)" if type(value) is tuple else f"{type(value).__name__}({parts})"

    result = made(example)
    body = "\n".join(f"    {line}" for line in [*lines, f"return {result}"])
    return f'\n\n@cuda.jit(device=True, inline="always")\ndef {name}():\n{body}'


def _part_lines(name: str, array: NDArray[Any], whole: str) -> Iterator[str]:
    """Make an array of some rows of another one."""
    assert array.base is not None
    first = (array.ctypes.data - array.base.ctypes.data) // array.strides[0]
    yield f"{name} = {whole}[{first} : {first + len(array)}]"


def _array_lines(name: str, array: NDArray[Any]) -> Iterator[str]:
    """Make an array like this one, of zeros."""
    # Memory cannot be empty: an empty array is a part of a longer one, and a slice of several
    # dimensions would not be contiguous, which is another type to numba.
    if array.size == 0:
        yield f"{name} = cuda.local.array(1, {array.dtype.name})[:0].reshape({array.shape})"
        return
    yield f"{name} = cuda.local.array({array.shape}, {array.dtype.name})"
    indices = [f"i{k}" for k in range(array.ndim)]
    for depth, (index, length) in enumerate(zip(indices, array.shape, strict=True)):
        yield f"{'    ' * depth}for {index} in range({length}):"
    yield f"{'    ' * array.ndim}{name}[{', '.join(indices)}] = 0"
