"""What the rules of a simulation see and set: all cells before a step, and the cells of a division."""

_SEEN = (
    "time", "positions", "orientations", "axes", "velocities", "angular_velocities", "lengths", "shapes", "sizes",
    "exponents", "ids", "parents", "births", "generations",
)  # fmt: skip


class Cells:
    """All cells before a step, one row each, for `update(cells)` of a simulation's rules.

    `rates`, `division_lengths` and `groups` may be set, in place or as a whole; `cells["name"]` is a column of your own,
    which daughters inherit and states hold. All else is read-only: `time`, `positions`, `orientations`, `axes`,
    `velocities`, `angular_velocities`, `lengths`, `shapes`, `sizes`, `exponents`, `ids`, `parents`, `births`,
    `generations`, `ages` and `pressures`.
    """

    __slots__ = ("_bodies", "_columns", "group_names", "rates", "division_lengths", "groups")

    def __init__(self, bodies, rates, division_lengths, groups, columns, group_names):
        set_slot = super().__setattr__
        set_slot("_bodies", bodies)
        set_slot("_columns", columns)
        set_slot("group_names", group_names)
        self.rates, self.division_lengths, self.groups = rates, division_lengths, groups

    def __len__(self):
        return len(self._bodies)

    def __getattr__(self, name):
        if name in _SEEN:
            return getattr(self._bodies, name)
        raise AttributeError(f"cells have no {name!r}; cells[{name!r}] is a column of your own")

    def __setattr__(self, name, value):
        if name not in ("rates", "division_lengths", "groups"):
            raise AttributeError(f"{name!r} cannot be set by a rule: only rates, division_lengths, groups and columns")
        super().__setattr__(name, value)

    @property
    def ages(self):
        """(N,): times since birth."""
        return self._bodies.time - self._bodies.births

    @property
    def pressures(self):
        """(N,): pressures by the contact forces of the last step."""
        return self._bodies._pressures()

    def __getitem__(self, name):
        return self._columns[name]

    def __setitem__(self, name, values):
        if not isinstance(name, str):
            raise TypeError(f"a column has a name, found {name!r}")
        self._columns[name] = values

    def __contains__(self, name):
        return name in self._columns

    def keys(self):
        """The names of your own columns."""
        return self._columns.keys()


class Cell:
    """One cell at a division, for `divide(mother, daughters)` of a simulation's rules.

    Of daughters, `length`, `rate`, `division_length`, `group` (a name or None) and `cell["name"]` may be set; `id` is
    read-only. Both lengths are tip to tip, of a mother before the step, of daughters after it; those of two daughters
    keep their sum.
    """

    __slots__ = ("_id", "_columns", "length", "rate", "division_length", "group")

    def __init__(self, id, length, rate, division_length, group, columns):
        self._id, self._columns = id, columns
        self.length, self.rate, self.division_length, self.group = length, rate, division_length, group

    @property
    def id(self):
        """Its id, unique over a run."""
        return self._id

    def __getitem__(self, name):
        return self._columns[name]

    def __setitem__(self, name, value):
        self._columns[name] = float(value)

    def __contains__(self, name):
        return name in self._columns

    def __repr__(self):
        return f"Cell(id={self.id}, length={self.length}, rate={self.rate}, group={self.group!r})"
