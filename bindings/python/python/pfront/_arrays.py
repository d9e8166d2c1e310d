"""Arrays and integers as users give them."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from typing import Any, Union

import numpy as np
import numpy.typing as npt

__all__ = ["Rows", "array", "integer", "point", "points", "rows"]

Rows = Union[slice, "npt.NDArray[np.bool_]", "npt.NDArray[np.integer[Any]]", Sequence[int], Sequence[bool]]


def array(values: Any, what: str) -> npt.NDArray[Any]:
    """An array of what was given; a masked one is refused, since what it hides would be tested.

    This may be a view of what the caller holds.
    """
    rows = values if isinstance(values, (list, tuple)) else ()
    if isinstance(values, np.ma.MaskedArray) or any(isinstance(row, np.ma.MaskedArray) for row in rows):
        raise TypeError(
            f"{what} in a masked array, whose mask is no part of a mesh or a pose: "
            "give x.filled(number) or the rows that are not masked, x.data[~np.ma.getmaskarray(x).any(axis=1)]"
        )
    return np.asarray(values)


def points(values: Any, what: str) -> npt.NDArray[np.float64]:
    """One point, (3,), or several, (n, 3), whose coordinates are numbers of at most 2^125."""
    found = np.ascontiguousarray(array(values, what), np.float64)
    if found.ndim not in (1, 2) or found.shape[-1] != 3:
        raise ValueError(f"{what} of shape {found.shape}: one point is (3,), and many are (n, 3)")
    if not (abs(found) <= 2.0**125).all():
        rows = np.nonzero(~(abs(found.reshape(-1, 3)) <= 2.0**125).all(axis=1))[0]
        raise ValueError(f"{what}: row {rows[0]} has a coordinate that is NaN, infinite or beyond 2^125")
    return found


def point(values: Any, what: str) -> tuple[float, float, float]:
    """One point, (3,)."""
    found = points(values, what)
    if found.ndim != 1:
        raise ValueError(f"{what} of shape {found.shape} is not one point, (3,)")
    x, y, z = found.tolist()
    return x, y, z


def integer(value: Any, what: str) -> int:
    """An integer of Python or NumPy; a TypeError for all else, a float of an integral value included."""
    try:
        return operator.index(value)
    except TypeError:
        raise TypeError(f"{what} is an integer, not {type(value).__name__}") from None


def rows(index: Rows, what: str) -> Any:
    """An index that selects rows: a slice, a mask or an array of indices."""
    if isinstance(index, (int, np.integer)):
        raise TypeError(f"{what} are selected by slices, masks and arrays of indices: [{index} : {index + 1}]")
    return index
