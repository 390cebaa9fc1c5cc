"""A run's folder, finished or running."""

import json
import os
import pathlib
import warnings
from collections.abc import Sequence

from ._page import Page
from ._relcp import RecordError, Recorded
from ._table import Table

# A state whose time is later than the one asked for by this part counts as of that time: the rounding of a sum.
_ROUNDING = 1e-9


class States(Sequence):
    """The recorded states of a run, in their order. Each is read from its file when it is asked for.

    `states[i]` is a `State`, `states[a:b:c]` a shorter sequence, `states.at(time)` the last state that is not later.
    """

    def __init__(self, recorded, heads, chosen):
        self._recorded, self._all_heads, self._chosen = recorded, heads, chosen

    def __len__(self):
        return len(self._chosen)

    def __getitem__(self, index):
        if isinstance(index, slice):
            return States(self._recorded, self._all_heads, self._chosen[index])
        try:
            chosen = self._chosen[index]
        except IndexError:
            raise IndexError(f"state {index}; there are {len(self)}") from None
        return self._recorded.state(chosen)

    def at(self, time):
        """The last of these states that is not later than `time`."""
        times = self.times.tolist()
        largest = max((abs(own) for own in times), default=0.0)
        within = [nth for nth, own in enumerate(times) if own <= time + _ROUNDING * max(abs(time), largest)]
        if not within:
            first = f"the first is at {times[0]}" if times else "there is none"
            raise ValueError(f"time {time}: no state is that early; {first}")
        return self[within[-1]]

    def _heads(self, name):
        array = self._all_heads()[name][list(self._chosen)]
        array.flags.writeable = False
        return array

    @property
    def times(self):
        """(K,): the times of the states."""
        return self._heads("time")

    @property
    def steps(self):
        """(K,): the numbers of steps before the states."""
        return self._heads("step")

    @property
    def n_bodies(self):
        """(K,): the numbers of bodies of the states."""
        return self._heads("bodies")

    def __repr__(self):
        return f"States({len(self)})"


class Pictures(Sequence):
    """Pictures of a run's states, (height, width, 4) uint8 each, drawn when they are asked for."""

    def __init__(self, reel):
        self._reel = reel

    def __len__(self):
        return len(self._reel)

    def __getitem__(self, index):
        chosen = range(len(self))[index]
        return [self._reel.picture(nth) for nth in chosen] if isinstance(index, slice) else self._reel.picture(chosen)

    def __repr__(self):
        return f"Pictures({len(self)})"


def _look(width, height, fit, look):
    """The arguments of pictures, checked by name."""
    unknown = set(look) - {"view", "colour", "range", "background", "words"}
    if unknown:
        names = ", ".join(sorted(unknown))
        raise TypeError(f"{names}: no such argument; view, colour, range, background and words are")
    return {"width": width, "height": height, "fit": fit, **look}


class Run:
    """The folder of a run, as `relcp run` or `relcp.run` writes it, finished or running.

    What it holds is read when it is asked for, and then kept; `refresh()` reads again, for a run that goes on. Raises
    RecordError if a file cannot be read.
    """

    def __init__(self, path):
        self.path = pathlib.Path(os.fspath(path))
        self._kept = {}
        self._recorded = Recorded(self.path)

    def refresh(self):
        """Reads again what the folder holds; returns this run."""
        self._recorded, self._kept = Recorded(self.path), {}
        return self

    def _keep(self, name, make):
        if name not in self._kept:
            self._kept[name] = make()
        return self._kept[name]

    @property
    def scene(self):
        """The scene, from `scene.json`."""
        return self._keep("scene", self._recorded.scene)

    @property
    def status(self):
        """"running", or how it ended: "done", "out_of_tolerance", "stopped", or "interrupted" if it can be resumed."""
        standing = self._recorded.standing()
        if standing != "ended":
            return "running" if standing == "running" else "interrupted"
        return self.summary["status"]

    @property
    def summary(self):
        """The content of `summary.json`, a dict. Raises RecordError before the run has ended or was interrupted."""
        return self._keep("summary", self._read_summary)

    def _read_summary(self):
        path = self.path / "summary.json"
        text = self._recorded.summary()
        if text is None:
            raise RecordError(f"{path}: there is none yet; a run writes it when it ends or is interrupted")
        try:
            return json.loads(text)
        except ValueError as no:
            raise RecordError(f"{path}: {no}") from no

    @property
    def states(self):
        """The recorded states, a sequence of `State`."""
        return States(self._recorded, self._heads, range(self._recorded.len()))

    @property
    def times(self):
        """(K,): the times of the states."""
        return self._heads()["time"]

    def _heads(self):
        # All files are read for it, once.
        return self._keep("heads", self._recorded.heads)

    def at(self, time):
        """The last state that is not later than `time`."""
        return self.states.at(time)

    def _table(self, name, otherwise):
        columns = self._recorded.table(name)
        if columns is None:
            raise RecordError(f"{self.path / name}.csv: there is none; {otherwise}")
        return Table(columns)

    @property
    def steps(self):
        """`steps.csv`, a `Table` with one row per recorded step."""
        return self._keep("steps", lambda: self._table("steps", "the run has not begun"))

    @property
    def measures(self):
        """`measures.csv`, a `Table` with one row per recorded step; of scenes with `output.measures`."""
        otherwise = "the scene has no output.measures; run.measure(name) measures the recorded states"
        return self._keep("measures", lambda: self._table("measures", otherwise))

    @property
    def lineage(self):
        """`lineage.csv`, a `Table` with one row per life that ended, by division, removal or a change; of scenes with
        `removal`, and with bodies that changes removed."""
        otherwise = ("the scene has no removal and no change removed a body; "
                     "ids, parents, births and generations of each state have the ancestry")
        return self._keep("lineage", lambda: self._table("lineage", otherwise))

    @property
    def contacts(self):
        """The contacts of bodies in all states that have contact forces, a `Table` with one row per contact: the last
        state, and with `output.forces` in the scene each. `id_a` and `id_b` are ids; forces are those on body b."""
        return self._keep("contacts", self._read_contacts)

    def _read_contacts(self):
        columns, states = self._recorded.contacts(None)
        if states == 0:
            raise RecordError(f"{self.path}: no state has contact forces; a scene with output.forces records them")
        return Table(columns)

    def measure(self, name, *, bin=None, neighbourhood=None, domain_angle=None, cutoff=None, seed=1):
        """A measure over all recorded states, as `relcp measure`: a `Table` with one row per state. Its `profile` is
        a second table, with the rows of each state, if the measure has one; `notes` say what is missing."""
        rows, profile, notes = self._recorded.measure(name, bin, neighbourhood, domain_angle, cutoff, seed)
        return Table(rows, None if profile is None else Table(profile), notes)

    def export(self, format, path=None, *, cutoff=None, last=False):
        """Writes the states as "gsd", "vtk", "lammps" or "xyz" into the folder `path`, by default one of that name in
        the run's; returns the files, the one to open first. `cutoff` selects the contacts of "vtk"."""
        files, notes = self._recorded.export(format, path, cutoff, last)
        warn(notes)
        return files

    def to_xarray(self):
        """The recorded states as a Dataset of xarray, over `time` and the `id`s of all bodies that ever were: NaN
        where a body is not there at a time. Raises ImportError without xarray."""
        from ._dataset import of_states

        return of_states(self.states, self.scene)

    def view(self, path=None, *, colour="orientation", every=1, start=None, end=None):
        """Writes the page of `relcp view`, by default `view.html` in the run's folder; returns its path. It has every
        `every`th state from time `start` to `end`."""
        file, notes = self._recorded.view(path, colour, every, start, end)
        warn(notes)
        return file

    def show(self, width=None, height=None, *, colour="orientation", every=1, start=None, end=None):
        """The page of `relcp view` as an object that notebooks show, a `Page`, as `Simulation.show`."""
        page, notes = self._recorded.page(colour, every, start, end)
        warn(notes)
        return Page(page, width, height)

    def render(self, time=None, width=960, height=None, **look):
        """A picture of the last state that is not later than `time`, by default the last of all, as
        `Simulation.render`: (height, width, 4) uint8."""
        state = self.states[-1] if time is None else self.at(time)
        return state.render(width, height, **look)

    def save_picture(self, path, time=None, width=960, height=None, **look):
        """Writes the picture of `render` into a file, `.png`, or vectors of a planar run seen from the top, `.svg` and
        `.pdf`; returns its path."""
        state = self.states[-1] if time is None else self.at(time)
        return state.save_picture(path, width, height, **look)

    def pictures(self, width=960, height=None, *, fit="run", every=1, start=None, end=None, **look):
        """Pictures of every `every`th state from time `start` to `end`, a sequence of arrays as `render` makes, each
        drawn when it is asked for. Camera and scale of colours are those of all together; with `fit="each"` they fit
        each. All states are read first."""
        return Pictures(self._recorded.reel(_look(width, height, fit, look), every, start, end))

    def movie(
        self, path, width=960, height=None, *, frames_a_second=25, fit="run", every=1, start=None, end=None, **look
    ):
        """Makes a movie of the `pictures` and returns its path: an animated PNG (`.png`), or by `ffmpeg`, if it is on
        the path, `.mp4`, `.mov` or `.mkv`."""
        look = _look(width, height, fit, look)
        return self._recorded.movie(path, frames_a_second, look, every, start, end)

    def resume(self, *, until=None, **arguments):
        """Goes on with the run in its folder, to its end or to a later one, and returns it: `relcp.run` with
        `resume=True`."""
        from ._record import run

        run(self.scene, self.path, resume=True, until=until, **arguments)
        return self.refresh()

    def __reduce__(self):
        return Run, (self.path,)

    def __repr__(self):
        return f"Run({os.fspath(self.path)!r}, {self.status})"


def warn(notes):
    """Warns the user of the package's caller."""
    for note in notes:
        warnings.warn(note, RuntimeWarning, stacklevel=3)
