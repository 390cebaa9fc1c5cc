"""Tables of a run: columns as arrays, by name."""

from collections.abc import Mapping

import numpy as np


class Table(Mapping):
    """A table: `table["name"]` is a column, a read-only array with one number per row, a list for text.

    It is a mapping from names to columns, in their order. NaN stands for a value that is not defined. `n_rows` is the
    number of rows, `to_pandas()` a DataFrame, where pandas is installed. `profile` is a second table where a measure
    has one, by distance, length or size, else None; `notes` are remarks on what is missing, and why.
    """

    def __init__(self, columns, profile=None, notes=()):
        self._columns = dict(columns)
        self.profile = profile
        self.notes = list(notes)

    def __getitem__(self, name):
        try:
            return self._columns[name]
        except KeyError:
            raise KeyError(f"{name!r}; the columns are {', '.join(self._columns)}") from None

    def __iter__(self):
        return iter(self._columns)

    def __len__(self):
        return len(self._columns)

    @property
    def n_rows(self):
        """The number of rows."""
        return len(next(iter(self._columns.values()), ()))

    def to_pandas(self):
        """The table as a DataFrame. Raises ImportError without pandas."""
        try:
            import pandas
        except ImportError as missing:
            raise ImportError("to_pandas needs pandas, which is not installed: pip install pandas") from missing
        return pandas.DataFrame({name: np.array(values) for name, values in self._columns.items()})

    def __repr__(self):
        return f"Table({self.n_rows} rows: {', '.join(self._columns)})"
