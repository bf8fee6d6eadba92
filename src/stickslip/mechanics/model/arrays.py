"""Checks of the vectors and matrices that models are built from."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.checks import dimensions, finite_number, real_numbers, shown, whole_number

if TYPE_CHECKING:
    from stickslip.numerics.arrays import Floats


MOST_BLOCKS: Final = 2000
"""Springs and modes of so many fill a small memory, and take a minute."""

ROUNDING = 64 * np.finfo(np.float64).eps
"""Of a matrix' size: asymmetry and negative eigenvalues that rounding explains."""


def one_per_block(name: str, values: Any, n_blocks: int, *, above: float, why: str) -> Floats:
    """Return one finite number above a bound per block; one number stands for all."""
    if dimensions(values) == 0:
        return np.full(n_blocks, finite_number(name, values, above=above, why=why))
    what = "blocks: a model has a matrix with a row for each"
    whole_number(f"len({name})", n_blocks, at_most=MOST_BLOCKS, what=what)
    entries = list(values)
    if len(entries) != n_blocks or any(dimensions(entry) for entry in entries):
        raise ValueError(
            f"{name} = {shown(values)} for {n_blocks} blocks: give one number per block."
        )
    return np.array(
        [
            finite_number(f"{name}[{i}]", entry, above=above, why=why)
            for i, entry in enumerate(entries)
        ]
    )


def symmetric(name: str, values: object, n_blocks: int) -> Floats:
    """Return a symmetric matrix with a row per block; ValueError if it is none."""
    matrix = real_numbers(name, values)
    if matrix.shape != (n_blocks, n_blocks):
        raise ValueError(
            f"{name} has the shape {matrix.shape}: {n_blocks} blocks need "
            f"({n_blocks}, {n_blocks}), as many rows and columns as masses."
        )
    if not np.isfinite(matrix).all():
        i, j = np.argwhere(~np.isfinite(matrix))[0]
        raise ValueError(f"{name}[{i}, {j}] = {matrix[i, j]} is not a finite number")
    apart = np.abs(matrix - matrix.T)
    if apart.max(initial=0.0) > ROUNDING * np.abs(matrix).max(initial=0.0):
        i, j = np.unravel_index(np.argmax(apart), apart.shape)
        raise ValueError(
            f"{name}[{i}, {j}] = {matrix[i, j]!r} but {name}[{j}, {i}] = {matrix[j, i]!r}: the "
            "matrix must be symmetric (forces between blocks come in equal and opposite pairs)."
        )
    return np.asarray(0.5 * (matrix + matrix.T))


def positive_definite(name: str, matrix: Floats) -> None:
    """Check that springs always pull back."""
    least = float(np.linalg.eigvalsh(matrix)[0])
    if least <= ROUNDING * np.abs(matrix).max():
        raise ValueError(
            f"{name} has the eigenvalue {least:.6g}: it must be positive definite. A direction "
            "without restoring force lets the belt carry the blocks away for ever."
        )


def semidefinite(name: str, matrix: Floats) -> None:
    """Check that dampers only take energy."""
    least = float(np.linalg.eigvalsh(matrix)[0])
    if least < -ROUNDING * np.abs(matrix).max():
        raise ValueError(
            f"{name} has the eigenvalue {least:.6g}: it must be positive semidefinite. A damper "
            "that feeds energy belongs into the friction law."
        )


def belt_velocity(value: object, name: str = "V", *, is_forced: bool = False) -> float:
    """Return the belt velocity: positive, or 0 in forced models."""
    remedy = (
        f"A belt that runs backward is the mirror image (X, V) -> -(X, V): take |{name}| and "
        "change the sign of all displacements and forces; a law with forward= exchanges its two "
        "functions."
    )
    if is_forced:
        why = "The belt moves towards positive displacements, or rests."
        return finite_number(name, value, at_least=0.0, why=why, remedy=remedy)
    why = (
        "The belt loads the springs by moving towards positive displacements (V = 0 makes sense "
        "for forced models only)."
    )
    return finite_number(name, value, above=0.0, why=why, remedy=remedy)
