"""Arrays and integers as users give them."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from typing import Any, Union

import numpy as np
import numpy.typing as npt

__all__ = ["Rows", "array", "integer", "rows"]

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
