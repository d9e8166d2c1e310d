"""Poses, made of whatever holds matrices."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ._errors import PoseError

__all__ = ["Pose", "matrix"]

Pose = Any
_LAST = [0.0, 0.0, 0.0, 1.0]


def matrix(pose: Pose) -> npt.NDArray[Any]:
    """A pose, or poses, as an aligned array of float32 or float64 in C order, whose last row has been looked at."""
    array = np.asarray(pose.as_matrix() if hasattr(pose, "as_matrix") else pose)
    if array.dtype.kind not in "fiu" or array.dtype.itemsize > 8:
        raise TypeError(f"a pose of dtype {array.dtype} is no matrix of real numbers of at most 64 bits")
    if array.ndim < 2 or array.ndim > 3 or array.shape[-2:] not in ((3, 3), (3, 4), (4, 4)):
        raise PoseError(f"a pose of shape {array.shape} is not (4, 4), (3, 4) or (3, 3), nor are these (k, ...)")
    kind = np.float32 if array.dtype.kind == "f" and array.dtype.itemsize <= 4 else np.float64
    if array.shape[-2] == 4:
        wrong = (array[..., 3, :] != _LAST).any(axis=-1)
        if wrong.any():
            error = PoseError("the last row of a pose is not 0, 0, 0, 1")
            error.row = 3
            if array.ndim == 3:
                error.pose = int(np.argmax(wrong))
            raise error
        if array.ndim == 3:
            array = array[:, :3]
    elif array.shape[-1] == 3:
        array = np.concatenate([array, np.zeros((*array.shape[:-1], 1), array.dtype)], axis=-1)
    return np.require(array, kind, ("C", "A"))
