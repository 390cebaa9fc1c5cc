"""Many runs of one scene, as `relcp batch` makes them."""

import builtins
import json
import operator
import os
import pathlib
import warnings
from collections.abc import Mapping, Sequence

import numpy as np

from ._record import _bar
from ._relcp import Planned, Scene
from ._run import Run
from ._table import Table

# The files beside the members' folders from which `relcp batch` goes on.
_SWEEP, _SCENE = "sweep.json", "scene.json"


class Batch(Sequence):
    """The runs of a sweep, in the order of its members: `batch[i]` is a `Run`.

    `path` is their folder, `table` a `Table` with one row per member: the varied keys, `status`, `steps`, `bodies`,
    `max_overlap`, `wall_seconds`, `folder`, `message` and more. A member that did not begin has no run: `batch[i]`
    then raises RecordError.
    """

    def __init__(self, path, columns, rows):
        self.path = pathlib.Path(path)
        self._folders = [row["folder"] for row in rows]
        self.table = _table(columns, rows)

    def __len__(self):
        return len(self._folders)

    def __getitem__(self, index):
        if isinstance(index, slice):
            return [Run(self.path / folder) for folder in self._folders[index]]
        try:
            folder = self._folders[index]
        except IndexError:
            raise IndexError(f"member {index}; there are {len(self)}") from None
        return Run(self.path / folder)

    def __repr__(self):
        counts = ", ".join(f"{self.table['status'].count(s)} {s}" for s in dict.fromkeys(self.table["status"]))
        return f"Batch({os.fspath(self.path)!r}: {counts or 'no members'})"


def _table(columns, rows):
    """Rows of `batch.json` as columns: numbers as arrays, all else as lists."""
    own = [key for key in rows[0] if key not in ("set", "values")] if rows else []
    table = {"index": [row["index"] for row in rows]}
    for key in columns:
        table[f"set.{key}" if key in own else key] = [row["values"].get(key) for row in rows]
    for key in own:
        table[key] = [row[key] for row in rows]
    return Table({name: _column(values) for name, values in table.items()})


def _column(values):
    def is_number(value):
        return isinstance(value, (int, float)) and not isinstance(value, bool)

    if not any(map(is_number, values)) or not all(value is None or is_number(value) for value in values):
        return values
    whole = all(isinstance(value, int) for value in values)
    array = np.array(values if whole else [np.nan if value is None else value for value in values])
    array.flags.writeable = False
    return array


def _plain(value):
    """Values of numpy, and other numbers, as JSON has them."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, (Scene, os.PathLike)):
        raise TypeError(f"a sweep varies values, not a {type(value).__name__}")
    return builtins.list(value)


def _seeds(seeds):
    try:
        count = operator.index(seeds)
    except TypeError:
        return [operator.index(seed) for seed in seeds]
    if count < 1:
        raise ValueError(f"seeds: expected at least one, found {count}")
    return {"from": 1, "count": count}


def _grid(grid):
    def values(key, given):
        if isinstance(given, (str, Mapping)) or not np.iterable(given):
            raise TypeError(f"grid: {key} needs a list of values, found {given!r}; `set` gives all members one value")
        return builtins.list(given)

    return {key: values(key, given) for key, given in (grid or {}).items()}


def _planned(scene, sweep, name):
    """The plan, its text, and the scene if it is one in code."""
    if isinstance(scene, Scene):
        document = {"name": name or scene.name, "scene": _SCENE, **sweep}
    else:
        text = os.fspath(scene)
        is_file = pathlib.Path(text).is_file()
        document = {"name": name or pathlib.Path(text).stem, "scene": os.path.abspath(text) if is_file else text, **sweep}
    text = json.dumps(document, indent=2, default=_plain)
    own = scene if isinstance(scene, Scene) else None
    return Planned(text, "the sweep", pathlib.Path(), own), text, own


def batch(
    scene=None,
    grid=None,
    *,
    list=None,
    seeds=None,
    set=None,
    sweep=None,
    out=None,
    name=None,
    backend="cpu",
    jobs=None,
    threads=None,
    precision=None,
    adapter=None,
    retry=False,
    progress=True,
):
    """Runs a scene in many variants, each in its own folder, as `relcp batch`. Returns a `Batch` with its `table`.

    `scene` is a Scene, the name of a built-in one, or a file. `grid` has a list of values for each dotted key, in all
    combinations; `list` is a list of dicts of values that belong together; `seeds` is a number of seeds from 1, or a
    list; `set` are values of all members. `sweep` is a sweep file in place of these. `out` is the folder, by default
    one in `runs` named after the scene, or `name`.

    `jobs` run at a time, by default one per core, and share `threads` threads; the bits do not depend on either. With
    `backend="gpu"` they are computed as an ensemble. The same call again runs only what has not ended, also after
    Ctrl-C, which stops all with a checkpoint; `retry` goes on with members that failed. Members that fail are in the
    table and do not stop the others; a warning counts them. The folder has `sweep.json`, with which the program goes
    on as well: `relcp batch OUT/sweep.json --out OUT`.
    """
    chosen = {"set": set, "grid": _grid(grid), "list": list, "seeds": None if seeds is None else _seeds(seeds)}
    chosen = {key: value for key, value in chosen.items() if value}
    if sweep is not None:
        if scene is not None or chosen or name is not None:
            raise ValueError("sweep: a sweep file has the scene, its values and the name")
        path = pathlib.Path(os.fspath(sweep))
        planned, text, own = Planned(path.read_text(encoding="utf-8"), os.fspath(path), path.parent, None), None, None
    elif scene is None:
        raise TypeError("batch: expected a scene, or `sweep`, a sweep file")
    else:
        planned, text, own = _planned(scene, chosen, name)
    out = planned.folder if out is None else pathlib.Path(os.fspath(out))
    bar = None

    def show(taken, every):
        nonlocal bar
        if bar is None:
            bar = _bar(progress, every, taken)
        if bar is not None:
            bar.update(taken - bar.n)

    try:
        failed = planned.run(out, backend, jobs, threads, precision, adapter, retry, show if progress else None)
    finally:
        if bar is not None:
            bar.close()
        if text is not None and out.is_dir():
            _keep(out, text, own)
    table = planned.table(out, failed)
    made = Batch(out, table["columns"], table["members"])
    ended = [status in ("done", "out_of_tolerance") for status in made.table["status"]]
    if not all(ended):
        said = f"{ended.count(False)} of {len(ended)} members did not reach their end; see table['status'], ['message']"
        warnings.warn(said, RuntimeWarning, stacklevel=2)
    return made


def _keep(out, text, scene):
    """Writes the sweep beside its runs, and the scene that it is of."""
    if scene is not None:
        # As pickles have it: without defaults, some of which follow from other keys.
        (out / _SCENE).write_text(scene.__reduce__()[1][0], encoding="utf-8")
    (out / _SWEEP).write_text(text + "\n", encoding="utf-8")
