"""Poses, made of whatever holds matrices."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NoReturn, Protocol, Union

import numpy as np
import numpy.typing as npt

from ._arrays import array as as_array
from ._errors import PoseError

__all__ = ["HasMatrix", "OnePose", "Pose", "Poses", "SomePoses", "matrix"]


class HasMatrix(Protocol):
    """A rotation or transform, as scipy's are: one, or many."""

    def as_matrix(self) -> npt.NDArray[Any]: ...


_Real = np.dtype[Union[np.floating[Any], np.integer[Any]]]
OnePose = Union["np.ndarray[tuple[int, int], _Real]", Sequence[Sequence[float]], None]
Poses = Union["np.ndarray[tuple[int, int, int], _Real]", Sequence[Sequence[Sequence[float]]]]
# One or many: no type says of these how many they are. A shape of no dimensions that exist is that of an array of any shape.
_AnyShape = np.ndarray[tuple[NoReturn, NoReturn, NoReturn], _Real]
SomePoses = Union[_AnyShape, Sequence["np.ndarray[Any, _Real]"], HasMatrix]
Pose = Union[OnePose, Poses, SomePoses]


def matrix(pose: Any) -> npt.NDArray[Any]:
    """A pose, or poses, as an aligned array of float32 or float64 in C order, whose last row has been looked at.

    This may be a view of what the caller holds.
    """
    array = as_array(pose.as_matrix() if hasattr(pose, "as_matrix") else pose, "a pose is")
    if array.dtype.kind not in "fiu" or array.dtype.itemsize > 8:
        raise TypeError(f"a pose of dtype {array.dtype} is no matrix of real numbers of at most 64 bits")
    if array.ndim < 2 or array.ndim > 3 or array.shape[-2:] not in ((3, 3), (3, 4), (4, 4)):
        raise PoseError(f"a pose of shape {array.shape} is not (4, 4), (3, 4) or (3, 3), nor are these (k, ...)")
    kind = np.float32 if array.dtype.kind == "f" and array.dtype.itemsize <= 4 else np.float64
    if array.dtype.kind in "iu" and array.dtype.itemsize == 8 and array.size:
        if max(abs(int(array.min())), abs(int(array.max()))) > 2**53:
            raise TypeError("a pose has integers beyond 2^53, which float64 does not hold")
    if array.shape[-2] == 4:
        wrong = _is_wrong(np.require(array[..., 3, :], kind, ("C", "A")))
        if wrong.any():
            at = int(np.argmax(wrong)) if array.ndim == 3 else None
            error = PoseError(f"{'' if at is None else f'pose {at}: '}the last row of a pose, row 3, is not 0, 0, 0, 1")
            error.row = 3
            error.pose = at
            raise error
        if array.ndim == 3:
            array = array[:, :3]
    elif array.shape[-1] == 3:
        array = np.concatenate([array, np.zeros((*array.shape[:-1], 1), array.dtype)], axis=-1)
    return np.require(array, kind, ("C", "A"))


def _is_wrong(rows: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
    """Which last rows are not 0, 0, 0, 1. Zeros are looked at by their bits: some environments take subnormal numbers for zeros."""
    bits = np.abs(rows[..., :3]).view(np.uint32 if rows.dtype == np.float32 else np.uint64)
    wrong: npt.NDArray[np.bool_] = (bits != 0).any(axis=-1) | (rows[..., 3] != 1)
    return wrong
