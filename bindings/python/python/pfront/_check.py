"""What is told of an assembly."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from ._errors import NotSolid
from ._questions import Relation

__all__ = ["CheckedPair", "CheckReport", "ContactSize"]


@dataclass(frozen=True)
class ContactSize:
    """The contact of two bodies, in numbers.

    Attributes
    ----------
    dimension : int
        0 for points alone, 1 for curves, 2 if there are areas.
    patches : int
        How many connected patches it has.
    length, area : (float, float)
        Intervals that hold the length of curves and of the outlines of areas, and the area.
    """

    dimension: int
    patches: int
    length: tuple[float, float]
    area: tuple[float, float]


@dataclass(frozen=True)
class CheckedPair:
    """Two bodies that are not surely apart, since their boxes overlap. What was not asked is None.

    Attributes
    ----------
    bodies : (int, int)
        Their ids, that which was added first before the other.
    names : (object, object)
        Their names.
    relation : str or None
        What the first is to the second, as `pfront.relation` tells; None if it is undetermined, or a body is no solid.
    allowed : bool
        Whether that is allowed. What is undetermined is not.
    meets : bool
        Whether their surfaces meet, as those of nested solids may.
    overlap_volume : (float, float) or None
        An interval that holds their common volume, if they cross and neither meets itself.
    contact : ContactSize or None
        Their contact, if it was asked for and their surfaces meet.
    gap : (float, float) or None
        An interval that holds their smallest distance, if they are near.
    pair : (int, int) or None
        Two faces that show it; those on which it hangs, if it is undetermined. They may differ between executors.
    place : (float, float, float) or None
        A point in the world where these faces meet.
    """

    bodies: tuple[int, int]
    names: tuple[Any, Any]
    relation: Relation | None
    allowed: bool
    meets: bool
    overlap_volume: tuple[float, float] | None
    contact: ContactSize | None
    gap: tuple[float, float] | None
    pair: tuple[int, int] | None
    place: tuple[float, float, float] | None


@dataclass(frozen=True, repr=False)
class CheckReport:
    """What the bodies of an assembly are to each other, and whether that is allowed.

    Attributes
    ----------
    pairs : list of CheckedPair
        All bodies whose boxes overlap and that are not ignored, in the order of their ids.
    refused : dict of int to NotSolid
        The bodies among them that are no solids, and why.
    allowed : bool
        Whether every pair is allowed.
    counts : dict of str to int
        How many pairs have each relation; those that have none are "undetermined".
    """

    pairs: list[CheckedPair]
    refused: dict[int, NotSolid] = field(compare=False)

    @property
    def allowed(self) -> bool:
        return all(pair.allowed for pair in self.pairs)

    @property
    def counts(self) -> dict[str, int]:
        return dict(Counter(pair.relation or "undetermined" for pair in self.pairs))

    def __repr__(self) -> str:
        wrong = sum(not pair.allowed for pair in self.pairs)
        return f"CheckReport({len(self.pairs)} pairs, {wrong} not allowed)"

    def to_dict(self) -> dict[str, npt.NDArray[Any]]:
        """Columns by their names, as ``pandas.DataFrame(report.to_dict())`` takes them; NaN and -1 where there is nothing.

        Examples
        --------
        >>> import pfront as pf
        >>> report = pf.check({"lid": pf._box(), "jar": pf._box()})
        >>> columns = report.to_dict()
        >>> list(columns)[:5], columns["relation"].tolist()
        (['body_a', 'body_b', 'name_a', 'name_b', 'relation'], ['equal'])
        """
        rows, pairs = len(self.pairs), self.pairs

        def objects(values: list[Any]) -> Any:
            found = np.empty(rows, object)
            found[:] = values
            return found

        def numbers(values: list[Any], empty: Any) -> Any:
            return np.array([empty if value is None else value for value in values], type(empty[0])).reshape(rows, len(empty)).T

        two = (np.nan, np.nan)
        bodies, faces = (numbers(values, (np.int64(-1),) * 2) for values in ([pair.bodies for pair in pairs], [pair.pair for pair in pairs]))
        volumes, gaps = numbers([pair.overlap_volume for pair in pairs], two), numbers([pair.gap for pair in pairs], two)
        sizes = [pair.contact for pair in pairs]
        lengths, areas = numbers([size and size.length for size in sizes], two), numbers([size and size.area for size in sizes], two)
        places = numbers([pair.place for pair in pairs], (*two, np.nan))
        return {
            **dict(zip(("body_a", "body_b"), bodies)),
            **{f"name_{side}": objects([pair.names[k] for pair in pairs]) for k, side in enumerate("ab")},
            "relation": objects([pair.relation for pair in pairs]),
            "allowed": np.array([pair.allowed for pair in pairs], bool),
            "meets": np.array([pair.meets for pair in pairs], bool),
            **dict(zip(("volume_low", "volume_high"), volumes)),
            **dict(zip(("length_low", "length_high"), lengths)),
            **dict(zip(("area_low", "area_high"), areas)),
            **dict(zip(("gap_low", "gap_high"), gaps)),
            **dict(zip(("face_a", "face_b"), faces)),
            **dict(zip("xyz", places)),
        }
