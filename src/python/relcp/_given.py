"""Values that users give, as arrays of the right type and shape. Errors name the argument."""

import numpy as np

from ._relcp import NO_GROUP


def rows(value, name, count, width):
    """`count` rows of `width` numbers, flat; a single row, or a single number, stands for all."""
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "fiub":
            raise TypeError(f"found {array.dtype}")
        array = array.astype(np.float64)
    except (TypeError, ValueError) as no:
        raise TypeError(f"{name}: expected an array of numbers: {no}") from no
    whole = (count,) if width == 1 else (count, width)
    if array.shape == whole[1:]:
        array = np.broadcast_to(array, whole)
    if array.shape != whole:
        raise ValueError(f"{name}: found the shape {array.shape}; expected {whole}, one row for each body")
    return array.reshape(-1).tolist()


def indices(of, count):
    """Indices of `count` bodies from indices, also negative ones, a slice, or a mask of booleans."""
    if isinstance(of, slice):
        return list(range(*of.indices(count)))
    array = np.atleast_1d(np.asarray(of))
    if array.dtype.kind == "b":
        if array.shape != (count,):
            raise IndexError(f"of: a mask of shape {array.shape}; there are {count} bodies")
        return np.flatnonzero(array).tolist()
    if array.size == 0:
        return []
    if array.ndim != 1 or array.dtype.kind not in "iu":
        raise TypeError("of: expected indices, a slice or a mask of booleans")
    wrong = array[(array < -count) | (array >= count)]
    if wrong.size:
        raise IndexError(f"of: index {wrong[0]}; there are {count} bodies, from 0")
    return [int(index) % count for index in array]


def ids(value):
    """Ids as integers."""
    array = np.atleast_1d(np.asarray(value))
    if array.size == 0:
        return []
    if array.ndim != 1 or array.dtype.kind not in "iu" or (array < 0).any():
        raise TypeError("ids: expected ids of bodies, as `simulation.ids` has them")
    return [int(own) for own in array]


def groups(value, count, names):
    """`count` indices of groups from names, None or indices; a single one stands for all."""
    if isinstance(value, np.ndarray) and value.dtype.kind in "iu" and value.shape == (count,):
        if (((value >= 0) & (value < len(names))) | (value == NO_GROUP)).all():
            return value.tolist()
    alone = value is None or isinstance(value, (str, int, np.integer)) or np.ndim(value) == 0
    given = [value] * count if alone else list(value)
    if len(given) != count:
        raise ValueError(f"group: found {len(given)} rows; expected {count}, one for each body")
    return [_group(own, row, names) for row, own in enumerate(given)]


def _group(value, row, names):
    if value is None:
        return NO_GROUP
    if isinstance(value, str):
        if value not in names:
            known = ", ".join(names) if names else "none"
            raise ValueError(f"group[{row}]: no body of the scene starts in the group {value!r}; its groups: {known}")
        return names.index(value)
    if isinstance(value, (int, np.integer)) and (0 <= value < len(names) or value == NO_GROUP):
        return int(value)
    raise ValueError(f"group[{row}]: expected a name, None or an index below {len(names)}, found {value!r}")
