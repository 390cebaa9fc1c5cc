import enum
import os
import pathlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, Literal, Optional, Union, final, overload

import numpy as np
import numpy.typing as npt

_Path = Union[str, os.PathLike[str]]
_Overrides = Union[Mapping[str, Any], Iterable[str], None]
_Backend = Literal["cpu", "gpu", "auto"]
_Precision = Optional[Literal["f32", "f64"]]
_Status = Literal[
    "solved", "max_iterations", "no_progress", "rounding_floor", "infeasible", "least_overlap", "held_friction",
    "too_large", "not_finite"
]
_Floats = npt.NDArray[np.float64]
_Vectors = npt.ArrayLike
_Numbers = Any  # read as an array of floats, set by all that numpy makes one of
_Which = Union[Sequence[int], slice, npt.NDArray[Any], None]
_Size = Union[int, str, None]
_View = Optional[Literal["top", "front", "right", "oblique"]]
_Colour = Literal[
    "orientation", "age", "generation", "length", "speed", "contacts", "overlap", "force", "pressure", "group", "plain"
]
_Range = Optional[tuple[float, float]]
_Background = Literal["white", "dark", "transparent"]
_Force = Callable[["Bodies"], Union[_Vectors, tuple[_Vectors, Optional[_Vectors]]]]

__all__ = [
    "NO_GROUP",
    "NO_PARENT",
    "Batch",
    "Bodies",
    "Cell",
    "Cells",
    "Contacts",
    "DeviceError",
    "Ensemble",
    "Error",
    "Page",
    "Pictures",
    "RecordError",
    "Run",
    "Scene",
    "SceneError",
    "Shape",
    "Simulation",
    "SimulationError",
    "State",
    "States",
    "StepReport",
    "Table",
    "WallContacts",
    "__version__",
    "batch",
    "devices",
    "measures",
    "run",
    "scenes",
]

__version__: str
NO_GROUP: int
"""The group of a body without one: -1."""
NO_PARENT: int
"""A founder's parent: -1."""

class Shape(enum.IntEnum):
    """The shapes, as `shapes` has them."""

    SPHERE = 0
    SPHEROCYLINDER = 1
    ELLIPSOID = 2
    TORUS = 3
    SUPERELLIPSOID = 5

class Error(Exception):
    """The base class of all exceptions of relcp."""

class SceneError(Error):
    """A scene was refused."""

    kind: str
    """io, syntax, unknown_key, missing_key, duplicate_key, wrong_type, bad_value, too_large, bad_override, placement,
    interrupted or unknown_scene."""
    key: str
    """Dotted, as in overrides; empty for the scene as a whole."""
    message: str
    help: Optional[str]
    origin: Optional[str]
    """The file, built-in scene, text or override concerned."""
    line: Optional[int]
    """From 1; None if the scene is not text."""
    column: Optional[int]
    """In characters, from 1; None if the scene is not text."""

class SimulationError(Error):
    """A simulation could not be started, or a step failed."""

class DeviceError(Error):
    """There is no usable GPU, it does not support the scene, or it failed."""

class RecordError(Error):
    """A file of a run, or a state file, could not be read or written."""

@final
class Scene:
    """Everything that determines a run: validated and immutable."""

    def __new__(cls, value: dict[str, Any], overrides: _Overrides = None) -> Scene:
        """A scene from a dict, as `from_dict`."""

    @staticmethod
    def load(source: _Path, overrides: _Overrides = None) -> Scene:
        """A built-in scene by name, or else a scene file by path; `overrides` replaces values by dotted keys."""

    @staticmethod
    def from_json(text: str, overrides: _Overrides = None, origin: str = "text") -> Scene:
        """A scene from JSON text; `origin` names the text in messages."""

    @staticmethod
    def from_dict(value: dict[str, Any], overrides: _Overrides = None) -> Scene:
        """A scene from a dict with a scene file's keys; numpy arrays may replace lists."""

    @property
    def name(self) -> str: ...
    @property
    def seed(self) -> int: ...
    @property
    def dt(self) -> float: ...
    @property
    def start(self) -> float: ...
    @property
    def end(self) -> float: ...
    @property
    def steps(self) -> int: ...
    @property
    def planar(self) -> bool: ...
    @property
    def group_names(self) -> list[str]: ...
    @property
    def hash(self) -> str: ...
    def to_json(self) -> str:
        """JSON with every default written out."""

    def to_dict(self) -> dict[str, Any]:
        """A dict with every default written out."""

    def __eq__(self, other: object, /) -> bool: ...
    def __copy__(self) -> Scene: ...
    def __deepcopy__(self, memo: Any, /) -> Scene: ...
    def __reduce__(self) -> tuple[Callable[[str], Scene], tuple[str]]: ...

@final
class StepReport:
    """What one step did; lengths in the scene's unit, wall times in seconds."""

    @property
    def step(self) -> int:
        """Its number, from 1."""

    @property
    def time(self) -> float:
        """Time after it."""

    @property
    def bodies(self) -> int:
        """Bodies after it."""

    @property
    def removed(self) -> int:
        """Bodies removed at its end. The report's pairs have the indices before."""

    @property
    def constraints(self) -> int:
        """Rows of its last LCP."""

    @property
    def recursions(self) -> int:
        """Recursions after its first solve."""

    @property
    def iterations(self) -> int:
        """LCP iterations, over all its solves."""

    @property
    def products(self) -> int:
        """Applications of the LCP's matrix `A`, over all its solves."""

    @property
    def fallbacks(self) -> int:
        """Solves that the safeguard of the solver `auto` went on with."""

    @property
    def residual(self) -> float:
        """Residual that its last solve ended with, a length; the largest of those that did not reach their tolerance,
        where some did not."""

    @property
    def unconverged(self) -> int:
        """Solves that did not reach the solver's tolerance."""

    @property
    def status(self) -> _Status:
        """`Solved`, or how the last of its solves that did not converge ended."""

    @property
    def velocity_residual(self) -> float:
        """Residual of the solves behind the accepted velocities, a length: of the last solve; in a midpoint step, the
        larger one of both halves; of a step in pieces the largest one. It is what velocities times `dt` may be off
        by."""

    @property
    def first_violation(self) -> float:
        """Largest overlap of smooth surfaces in the trial of its first solve, a length: what the recursion then takes
        away. Of a midpoint step its second half's."""

    @property
    def max_overlap(self) -> float:
        """Largest true overlap of smooth surfaces, with each other or with walls, in the accepted configuration, a
        length."""

    @property
    def worst_pair(self) -> Optional[tuple[int, int]]:
        """The pair of bodies that overlaps by `max_overlap`, where one does."""

    @property
    def worst_wall(self) -> Optional[tuple[int, int]]:
        """The body and the wall (by its index in the scene) that overlap by it, if they do."""

    @property
    def passed(self) -> int:
        """Pairs of bodies that went through each other on the step's way; none where no pair did."""

    @property
    def proxy_overlap(self) -> Optional[float]:
        """Largest overlap between sub-spheres, where the method makes its rows from them."""

    @property
    def pieces(self) -> int:
        """The number of pieces that it was taken in: 1 for a whole step."""

    @property
    def by_cpu(self) -> bool:
        """Whether the CPU took the step instead of a device."""

    @property
    def parted(self) -> bool:
        """Whether bodies overlapped too deeply for the step and were separated before it, without advancing time."""

    @property
    def squeezed(self) -> int:
        """Pieces that were taken as well as they go, off by less than the cutoff, and then parted in no time."""

    @property
    def turned_less(self) -> int:
        """Pieces in which daughters turned less than they drew, as there was no room."""

    @property
    def shaken(self) -> int:
        """Pieces before which cells that pressed each other and found no way out were moved by a draw."""

    @property
    def restitution_dropped(self) -> int:
        """Pieces whose contacts had no restitution, as it would have made energy."""

    @property
    def waiting(self) -> int:
        """Cells that had to wait, as there was no room for them."""

    @property
    def failed_attempts(self) -> int:
        """Attempts that failed before it was taken."""

    @property
    def relaxed(self) -> int:
        """Solves whose rows contradict each other, or nearly do, and that were solved in the sense of the least
        overlap."""

    @property
    def tilts(self) -> int:
        """How often rows that contradict each other were tilted."""

    @property
    def loosened(self) -> int:
        """Rows that were rebuilt because they pushed bodies that no longer touched."""

    @property
    def largest_move(self) -> float:
        """The farthest that contact moved a body's centre from where its free motion leads, a length; of a step in
        pieces that of all pieces together at most."""

    @property
    def moved(self) -> Optional[int]:
        """The body that it moved so far; of a step in pieces that of the piece that moved one farthest."""

    @property
    def largest_push_gap(self) -> float:
        """The largest separation of a contact that pushes, a length; zero where contact parts no bodies by more than
        0.005 of the thinner one's thickness."""

    @property
    def contact_energy(self) -> float:
        """The energy that contact added, if bodies have inertia; negative if it removed some."""

    @property
    def axial_spin(self) -> float:
        """The largest angle by which contact turned a body of revolution about its own axis."""

    @property
    def broken_bonds(self) -> int:
        """Bonds that broke. On a device they are not counted by step."""

    @property
    def sliding(self) -> Optional[int]:
        """Contacts that push and slide, so that their friction is at its limit; none in a scene without friction."""

    @property
    def sticking(self) -> Optional[int]:
        """Contacts with friction that push and stick."""

    @property
    def friction_work(self) -> Optional[float]:
        """The energy that friction took, with what the springs of stick took up."""

    @property
    def friction_held(self) -> int:
        """Solves in which the law of friction was not met to the tolerance, so that its corrections were held."""

    @property
    def friction_gap(self) -> float:
        """What friction's law is off by, a length: the largest gap at a contact that pushes, or slip of one that has
        friction left."""

    @property
    def passed_pair(self) -> Optional[tuple[int, int]]:
        """The first pair that went through each other, where there is one."""

    @property
    def wall_seconds(self) -> float:
        """Wall time of the step."""

    @property
    def broad_phase_seconds(self) -> float:
        """Finding candidate pairs."""

    @property
    def narrow_phase_seconds(self) -> float:
        """Separations, rows, violations."""

    @property
    def solve_seconds(self) -> float:
        """The LCPs."""

    @property
    def integrate_seconds(self) -> float:
        """Forces, mobilities, trial configurations."""

    @property
    def growth_seconds(self) -> float:
        """Growth and division."""

    def to_dict(self) -> dict[str, Any]: ...

@final
class Contacts:
    """Pairs of near bodies, one row each, sorted by pair. M is their number."""

    def __len__(self) -> int: ...
    @property
    def pairs(self) -> npt.NDArray[np.uint64]:
        """(M, 2): the rows of both bodies, the lower first."""

    @property
    def separation(self) -> _Floats:
        """(M,): signed distance of the surfaces, negative if they overlap."""

    @property
    def normal(self) -> _Floats:
        """(M, 3): unit normal from the first body to the second."""

    @property
    def point_a(self) -> _Floats:
        """(M, 3): the contact point on the first body's surface, in space."""

    @property
    def point_b(self) -> _Floats:
        """(M, 3): the contact point on the second body's surface, in space."""

    @property
    def gamma(self) -> _Floats:
        """(M,): the contact force of the last step, summed over the rows of the pair; zero without contact."""

    @property
    def force(self) -> _Floats:
        """(M, 3): the force of the first body on the second: `gamma` along the normal, and friction."""

@final
class WallContacts:
    """Bodies near a wall's surface, one row each, sorted by body. M is their number."""

    def __len__(self) -> int: ...
    @property
    def body(self) -> npt.NDArray[np.uint64]:
        """(M,): the body's row."""

    @property
    def wall(self) -> npt.NDArray[np.uint64]:
        """(M,): the index of the wall in the scene."""

    @property
    def face(self) -> npt.NDArray[np.uint64]:
        """(M,): which of the wall's surfaces: of a channel the side that its normal points away from, then the other;
        of a box the low and the high side along x, y and z; of a cylinder the tube, then the ends."""

    @property
    def separation(self) -> _Floats:
        """(M,): the body's signed distance from the surface."""

    @property
    def normal(self) -> _Floats:
        """(M, 3): unit normal towards the wall."""

    @property
    def point(self) -> _Floats:
        """(M, 3): the contact point on the body's surface, in space."""

    @property
    def gamma(self) -> _Floats:
        """(M,): the normal force of the last step, summed over the places where the body touches; zero without
        contact."""

    @property
    def force(self) -> _Floats:
        """(M, 3): the force of the body on the wall: along the normal, and friction."""

@final
class Bonds:
    """Bonds and joints that hold, one row each, sorted by number. M is their number. Broken ones are not among them."""

    def __len__(self) -> int: ...
    @property
    def number(self) -> npt.NDArray[np.uint32]:
        """(M,): the scene's `bonds` first, then those of chains, `joints`, and bonds of daughters."""

    @property
    def bodies(self) -> npt.NDArray[np.uint64]:
        """(M, 2): the rows of both bodies."""

    @property
    def point_a(self) -> _Floats:
        """(M, 3): the end on the first body, in space."""

    @property
    def point_b(self) -> _Floats:
        """(M, 3): the end on the second body, in space; in a periodic cell at the image nearest to the first body."""

    @property
    def length(self) -> _Floats:
        """(M,): the distance of the ends."""

    @property
    def rest_length(self) -> _Floats:
        """(M,): the length at rest."""

    @property
    def tension(self) -> _Floats:
        """(M,): the force along the bond, positive where it pulls its ends together; of one of length 0 all of its
        force."""

    @property
    def force(self) -> _Floats:
        """(M, 3): the force on the second body at its end, that of the last step; NaN where it is not known."""

    @property
    def torque(self) -> _Floats:
        """(M, 3): the torque on the second body about its end, as `force`."""

    @property
    def bending_energy(self) -> _Floats:
        """(M,): the energy of bends and turns that it resists."""

    @property
    def contact(self) -> npt.NDArray[np.bool_]:
        """(M,): whether its bodies collide."""

class Bodies:
    """All bodies at the time at which a force is evaluated, one row per body; arrays are read-only copies."""

    def __len__(self) -> int: ...
    @property
    def time(self) -> float: ...
    @property
    def positions(self) -> _Floats:
        """(N, 3): centres."""

    @property
    def orientations(self) -> _Floats:
        """(N, 4): unit quaternions [w, x, y, z], body axes to space."""

    @property
    def axes(self) -> _Floats:
        """(N, 3): each body's own z in space, the axis of a rod and of a ring."""

    @property
    def velocities(self) -> _Floats:
        """(N, 3): length / time; under the overdamped law those of the last step."""

    @property
    def angular_velocities(self) -> _Floats:
        """(N, 3): in space axes, 1 / time."""

    @property
    def lengths(self) -> _Floats:
        """(N,): length of the major axis, tip to tip for a rod."""

    @property
    def shapes(self) -> npt.NDArray[np.uint32]:
        """(N,): a `Shape` each: 0 sphere, 1 spherocylinder, 2 ellipsoid, 3 torus, 5 superellipsoid."""

    @property
    def sizes(self) -> _Floats:
        """(N, 3): radius; diameter, length; three radii; major and minor radius; zero where a shape has none."""

    @property
    def exponents(self) -> _Floats:
        """(N, 2): exponents [n1, n2] of superellipsoids, zero of other shapes."""

    @property
    def groups(self) -> npt.NDArray[np.int32]:
        """(N,): index into the scene's `group_names`, or NO_GROUP."""

    @property
    def shape_labels(self) -> list[str]:
        """The name of each body's shape."""

    @property
    def group_labels(self) -> list[Optional[str]]:
        """The name of each body's group; None without one."""

    @property
    def columns(self) -> dict[str, _Floats]:
        """The columns of your own, (N,) each."""

    @property
    def ids(self) -> npt.NDArray[np.int64]:
        """(N,): unique over a run; a division ends one and begins two."""

    @property
    def parents(self) -> npt.NDArray[np.int64]:
        """(N,): the id that divided into this one, or NO_PARENT."""

    @property
    def births(self) -> _Floats:
        """(N,): times of birth."""

    @property
    def generations(self) -> npt.NDArray[np.uint32]:
        """(N,): divisions since the founder."""

@final
class State(Bodies):
    """A recorded state of a run, one row per body; arrays are read-only copies."""

    @property
    def step(self) -> int:
        """The number of steps before it."""

    @property
    def n_bodies(self) -> int: ...
    @property
    def has_forces(self) -> bool:
        """Whether it was recorded with its contact forces."""

    @property
    def rates(self) -> _Floats:
        """(N,): relative growth rates without pressure; zero for a body that does not grow."""

    @property
    def division_lengths(self) -> _Floats:
        """(N,): lengths at which cells divide; infinite by a timer, and for a body that does not grow."""

    def contacts(self, cutoff: Optional[float] = None) -> Contacts:
        """All pairs of bodies whose separation is at most `cutoff`, by default a thousandth of the thinnest body's
        thickness; `gamma` and `force` are NaN in a state without forces."""

    def wall_contacts(self, cutoff: Optional[float] = None) -> WallContacts:
        """All bodies and surfaces of walls whose separation is at most `cutoff`, as `contacts`."""

    @property
    def fields(self) -> dict[str, _Floats]:
        """The concentrations of the scene's fields by name, each indexed by x, y and z."""

    @property
    def bonds(self) -> Bonds:
        """The bonds and joints that hold. `force`, `torque` and `tension` are NaN in a state without forces."""

    def measure(self, name: str) -> dict[str, Any]:
        """A measure of this state: values by column, `remark`, and `profile` if it has one."""

    def render(
        self,
        width: int = 960,
        height: Optional[int] = None,
        *,
        view: _View = None,
        colour: _Colour = "orientation",
        range: _Range = None,
        background: _Background = "white",
        words: bool = True,
    ) -> npt.NDArray[np.uint8]:
        """A picture, (height, width, 4), as `Simulation.render`."""

    def save_picture(
        self,
        path: _Path,
        width: int = 960,
        height: Optional[int] = None,
        *,
        view: _View = None,
        colour: _Colour = "orientation",
        range: _Range = None,
        background: _Background = "white",
        words: bool = True,
    ) -> pathlib.Path:
        """Writes a picture: `.png`, or vectors of a planar scene seen from the top, `.svg` and `.pdf`."""

    def show(self, width: _Size = None, height: _Size = None, *, colour: _Colour = "orientation") -> Page:
        """The page of `relcp view` of this state."""

class States(Sequence[State]):
    """The recorded states of a run; each is read from its file when it is asked for."""

    def __len__(self) -> int: ...
    @overload
    def __getitem__(self, index: int) -> State: ...
    @overload
    def __getitem__(self, index: slice) -> States: ...
    def at(self, time: float) -> State:
        """The last of these states that is not later than `time`."""

    @property
    def times(self) -> _Floats:
        """(K,): the times of the states."""

    @property
    def steps(self) -> npt.NDArray[np.int64]:
        """(K,): the numbers of steps before the states."""

    @property
    def n_bodies(self) -> npt.NDArray[np.int64]:
        """(K,): the numbers of bodies of the states."""

class Table(Mapping[str, Any]):
    """Columns by name: read-only arrays with one number per row, lists for text; NaN is a value that is not defined."""

    profile: Optional[Table]
    """The rows by distance, length or size of a measure that has them."""
    notes: list[str]
    """What is missing, and why."""

    def __init__(
        self, columns: Mapping[str, Any], profile: Optional[Table] = None, notes: Iterable[str] = ()
    ) -> None: ...
    def __getitem__(self, name: str) -> Any: ...
    def __iter__(self) -> Iterator[str]: ...
    def __len__(self) -> int: ...
    @property
    def n_rows(self) -> int: ...
    def to_pandas(self) -> Any:
        """The table as a DataFrame; ImportError without pandas."""

class Page:
    """A page that shows states in any browser; a notebook shows it as a frame."""

    html: str
    width: str
    height: str
    def __init__(self, text: str, width: _Size = None, height: _Size = None) -> None: ...
    def save(self, path: _Path) -> pathlib.Path:
        """Writes the page, whole or not at all; returns its path."""

    def _repr_html_(self) -> str: ...

class Pictures(Sequence[npt.NDArray[np.uint8]]):
    """Pictures of a run's states, (height, width, 4) each, drawn when they are asked for."""

    def __len__(self) -> int: ...
    @overload
    def __getitem__(self, index: int) -> npt.NDArray[np.uint8]: ...
    @overload
    def __getitem__(self, index: slice) -> list[npt.NDArray[np.uint8]]: ...

class Run:
    """The folder of a run, finished or running."""

    path: pathlib.Path
    def __init__(self, path: _Path) -> None: ...
    def refresh(self) -> Run:
        """Reads again what the folder holds; returns this run."""

    @property
    def scene(self) -> Scene: ...
    @property
    def status(self) -> str:
        """running, done, out_of_tolerance, stopped or interrupted."""

    @property
    def summary(self) -> dict[str, Any]:
        """The content of `summary.json`."""

    @property
    def states(self) -> States: ...
    @property
    def times(self) -> _Floats:
        """(K,): the times of the states."""

    def at(self, time: float) -> State:
        """The last state that is not later than `time`."""

    @property
    def steps(self) -> Table:
        """`steps.csv`, one row per recorded step."""

    @property
    def measures(self) -> Table:
        """`measures.csv`, one row per recorded step, of scenes with `output.measures`."""

    @property
    def lineage(self) -> Table:
        """`lineage.csv`, one row per life that ended, of scenes with `removal`."""

    @property
    def contacts(self) -> Table:
        """The contacts of bodies in all states that have contact forces, one row per contact."""

    def measure(
        self,
        name: str,
        *,
        bin: Optional[float] = None,
        neighbourhood: Optional[float] = None,
        domain_angle: Optional[float] = None,
        cutoff: Optional[float] = None,
        seed: int = 1,
    ) -> Table:
        """A measure over all recorded states, one row per state."""

    def to_xarray(self) -> Any:
        """The recorded states as a Dataset of xarray, over `time` and `id`. Raises ImportError without xarray."""

    def export(
        self,
        format: Literal["gsd", "vtk", "lammps", "xyz"],
        path: Optional[_Path] = None,
        *,
        cutoff: Optional[float] = None,
        last: bool = False,
    ) -> list[pathlib.Path]:
        """Writes the states in another program's format; returns the files, the one to open first."""

    def view(
        self,
        path: Optional[_Path] = None,
        *,
        colour: _Colour = "orientation",
        every: int = 1,
        start: Optional[float] = None,
        end: Optional[float] = None,
    ) -> pathlib.Path:
        """Writes the page of `relcp view`; returns its path."""

    def show(
        self,
        width: _Size = None,
        height: _Size = None,
        *,
        colour: _Colour = "orientation",
        every: int = 1,
        start: Optional[float] = None,
        end: Optional[float] = None,
    ) -> Page:
        """The page of `relcp view` as an object that notebooks show."""

    def render(
        self,
        time: Optional[float] = None,
        width: int = 960,
        height: Optional[int] = None,
        *,
        view: _View = None,
        colour: _Colour = "orientation",
        range: _Range = None,
        background: _Background = "white",
        words: bool = True,
    ) -> npt.NDArray[np.uint8]:
        """A picture of the last state that is not later than `time`, as `Simulation.render`."""

    def save_picture(
        self,
        path: _Path,
        time: Optional[float] = None,
        width: int = 960,
        height: Optional[int] = None,
        *,
        view: _View = None,
        colour: _Colour = "orientation",
        range: _Range = None,
        background: _Background = "white",
        words: bool = True,
    ) -> pathlib.Path:
        """Writes a picture: `.png`, or vectors of a planar scene seen from the top, `.svg` and `.pdf`."""

    def pictures(
        self,
        width: int = 960,
        height: Optional[int] = None,
        *,
        fit: Literal["run", "each"] = "run",
        every: int = 1,
        start: Optional[float] = None,
        end: Optional[float] = None,
        view: _View = None,
        colour: _Colour = "orientation",
        range: _Range = None,
        background: _Background = "white",
        words: bool = True,
    ) -> Pictures:
        """Pictures of the states with one camera and one scale of colours."""

    def movie(
        self,
        path: _Path,
        width: int = 960,
        height: Optional[int] = None,
        *,
        frames_a_second: int = 25,
        fit: Literal["run", "each"] = "run",
        every: int = 1,
        start: Optional[float] = None,
        end: Optional[float] = None,
        view: _View = None,
        colour: _Colour = "orientation",
        range: _Range = None,
        background: _Background = "white",
        words: bool = True,
    ) -> pathlib.Path:
        """Makes a movie of the pictures: an animated PNG, or by ffmpeg .mp4, .mov or .mkv; returns its path."""

    def resume(
        self,
        *,
        until: Optional[float] = None,
        backend: _Backend = "cpu",
        threads: Optional[int] = None,
        precision: _Precision = None,
        adapter: Optional[str] = None,
        forces: Iterable[_Force] = (),
        rules: Any = None,
        checkpoint_every: Optional[float] = None,
        progress: bool = True,
    ) -> Run:
        """Goes on with the run in its folder, to its end or to a later one."""

def run(
    scene: Scene,
    out: Optional[_Path] = None,
    *,
    backend: _Backend = "cpu",
    threads: Optional[int] = None,
    precision: _Precision = None,
    adapter: Optional[str] = None,
    resume: bool = False,
    until: Optional[float] = None,
    start_from: Union[Run, _Path, None] = None,
    start_time: Optional[float] = None,
    forces: Iterable[_Force] = (),
    rules: Any = None,
    checkpoint_every: Optional[float] = None,
    progress: bool = True,
) -> Run:
    """Runs a scene to its end and records it, as `relcp run`: the same files with the same bits."""

class Batch(Sequence[Run]):
    """The runs of a sweep, in the order of its members."""

    path: pathlib.Path
    table: Table
    """One row per member: the varied keys, `status`, `steps`, `bodies`, `folder`, `message` and more."""
    @overload
    def __getitem__(self, index: int, /) -> Run: ...
    @overload
    def __getitem__(self, index: slice, /) -> list[Run]: ...
    def __len__(self) -> int: ...

def batch(
    scene: Union[Scene, _Path, None] = None,
    grid: Optional[Mapping[str, Iterable[Any]]] = None,
    *,
    list: Optional[Sequence[Mapping[str, Any]]] = None,
    seeds: Union[int, Iterable[int], None] = None,
    set: Optional[Mapping[str, Any]] = None,
    sweep: Optional[_Path] = None,
    out: Optional[_Path] = None,
    name: Optional[str] = None,
    backend: Literal["cpu", "gpu"] = "cpu",
    jobs: Optional[int] = None,
    threads: Optional[int] = None,
    precision: _Precision = None,
    adapter: Optional[str] = None,
    retry: bool = False,
    progress: bool = True,
) -> Batch:
    """Runs a scene in many variants, each in its own folder, as `relcp batch`."""

class Cells:
    """All cells before a step, one row each, for `update(cells)` of a simulation's rules."""

    group_names: list[str]
    """Names of the groups, which `groups` indexes."""
    rates: _Numbers
    """(N,): relative growth per time, without pressure; zero for a body that does not grow. May be set."""
    division_lengths: _Numbers
    """(N,): lengths at which cells divide; infinite by a timer. May be set."""
    groups: Any
    """(N,): index into `group_names`, or NO_GROUP. May be set, by name, None or index."""

    def __len__(self) -> int: ...
    def __getitem__(self, name: str) -> Any:
        """A column of your own."""

    def __setitem__(self, name: str, values: npt.ArrayLike) -> None: ...
    def __contains__(self, name: str) -> bool: ...
    def keys(self) -> Iterable[str]:
        """The names of your own columns."""

    @property
    def time(self) -> float: ...
    @property
    def positions(self) -> _Floats: ...
    @property
    def orientations(self) -> _Floats: ...
    @property
    def axes(self) -> _Floats: ...
    @property
    def velocities(self) -> _Floats: ...
    @property
    def angular_velocities(self) -> _Floats: ...
    @property
    def lengths(self) -> _Floats: ...
    @property
    def sizes(self) -> _Floats: ...
    @property
    def exponents(self) -> _Floats: ...
    @property
    def shapes(self) -> npt.NDArray[np.uint32]: ...
    @property
    def ids(self) -> npt.NDArray[np.int64]: ...
    @property
    def parents(self) -> npt.NDArray[np.int64]: ...
    @property
    def births(self) -> _Floats: ...
    @property
    def generations(self) -> npt.NDArray[np.uint32]: ...
    @property
    def ages(self) -> _Floats:
        """(N,): times since birth."""

    @property
    def pressures(self) -> _Floats:
        """(N,): pressures by the contact forces of the last step."""

class Cell:
    """One cell at a division, for `divide(mother, daughters)` of a simulation's rules."""

    length: float
    """Tip to tip: of a mother before the step, of a daughter after it. Lengths that daughters are given keep their
    sum."""
    rate: float
    division_length: float
    group: Optional[str]
    @property
    def id(self) -> int: ...
    def __getitem__(self, name: str) -> float: ...
    def __setitem__(self, name: str, value: float) -> None: ...
    def __contains__(self, name: str) -> bool: ...

@final
class Simulation:
    """A scene's bodies and their backend.

    Every array is a read-only copy of the last accepted state, with one row per body; N is the number of bodies.
    """

    rules: Any
    """An object with `update(cells)`, called before each step, `divide(mother, daughters)`, called for each cell that
    divides, or both; None without rules."""

    def __new__(
        cls,
        scene: Scene,
        backend: _Backend = "cpu",
        threads: Optional[int] = None,
        precision: _Precision = None,
        adapter: Optional[str] = None,
    ) -> Simulation: ...
    @staticmethod
    def resume(
        scene: Scene,
        path: _Path,
        backend: _Backend = "cpu",
        threads: Optional[int] = None,
        precision: _Precision = None,
        adapter: Optional[str] = None,
    ) -> Simulation:
        """Continues from a state that `save` or the program wrote for the same scene."""

    def step(self, n: int = 1, *, past_end: bool = False) -> StepReport:
        """Takes `n` steps, those to the scene's end unless `past_end`, and returns the last one's report."""

    def run(
        self, *, until: Optional[float] = None, callback: Optional[Callable[[StepReport], object]] = None, every: int = 1
    ) -> dict[str, Any]:
        """Steps to the scene's end, or to the first step at or after `until`, and returns the summary.

        `callback` gets the report of every `every`th step, and of the last; the run ends if it returns False.
        """

    def set(
        self,
        of: _Which = None,
        *,
        ids: Union[Sequence[int], npt.NDArray[Any], None] = None,
        position: Optional[_Vectors] = None,
        orientation: Optional[_Vectors] = None,
        velocity: Optional[_Vectors] = None,
        angular_velocity: Optional[_Vectors] = None,
        length: Optional[npt.ArrayLike] = None,
        rate: Optional[npt.ArrayLike] = None,
        division_length: Optional[npt.ArrayLike] = None,
        group: Union[str, int, Sequence[Union[str, int, None]], npt.NDArray[Any], None] = None,
        columns: Optional[Mapping[str, npt.ArrayLike]] = None,
    ) -> None:
        """Sets values of bodies between two steps: of all, or of those of `of` (indices, a slice, a mask) or `ids`; all
        of them, or after an exception none. A single row stands for all of these bodies."""

    def add(self, bodies: Sequence[Mapping[str, Any]]) -> npt.NDArray[np.int64]:
        """Adds bodies, dicts as in a scene's `bodies`, after all others; returns their ids."""

    def change(self, keys: Mapping[str, Any]) -> None:
        """Gives dotted keys of the scene other values from the present state on; they become its `changes`."""

    def remove(
        self, of: _Which = None, *, ids: Union[Sequence[int], npt.NDArray[Any], None] = None
    ) -> None:
        """Removes the bodies of `of` (indices, a slice, a mask) or those with these `ids`."""

    def measure(self, name: str) -> dict[str, Any]:
        """A measure of the present state: values by column, `remark`, and `profile` if it has one."""

    def render(
        self,
        width: int = 960,
        height: Optional[int] = None,
        *,
        view: _View = None,
        colour: _Colour = "orientation",
        range: _Range = None,
        background: _Background = "white",
        words: bool = True,
    ) -> npt.NDArray[np.uint8]:
        """A picture of the present state as `relcp render` draws it: (height, width, 4), red, green, blue, opacity."""

    def save_picture(
        self,
        path: _Path,
        width: int = 960,
        height: Optional[int] = None,
        *,
        view: _View = None,
        colour: _Colour = "orientation",
        range: _Range = None,
        background: _Background = "white",
        words: bool = True,
    ) -> pathlib.Path:
        """Writes a picture: `.png`, or vectors of a planar scene seen from the top, `.svg` and `.pdf`."""

    def show(self, width: _Size = None, height: _Size = None, *, colour: _Colour = "orientation") -> Page:
        """The page of `relcp view` of the present state."""

    @property
    def rates(self) -> _Floats:
        """(N,): relative growth rates without pressure; zero for a body that does not grow."""

    @property
    def division_lengths(self) -> _Floats:
        """(N,): lengths at which cells divide; infinite by a timer, and for a body that does not grow."""

    @property
    def columns(self) -> dict[str, _Floats]:
        """The columns of your own, (N,) each."""

    @property
    def shape_labels(self) -> list[str]:
        """The name of each body's shape."""

    @property
    def group_labels(self) -> list[Optional[str]]:
        """The name of each body's group; None without one."""

    @property
    def n_bodies(self) -> int:
        """Bodies after the last accepted step."""

    @property
    def n_steps(self) -> int:
        """Steps accepted so far."""

    def add_force(self, force: _Force) -> None:
        """Adds a function that is called once per step and returns forces (N, 3), or forces and torques."""

    @property
    def scene(self) -> Scene: ...
    @property
    def steps(self) -> int: ...
    @property
    def bodies(self) -> int: ...
    @property
    def time(self) -> float: ...
    @property
    def done(self) -> bool: ...
    @property
    def backend(self) -> Literal["cpu", "gpu"]: ...
    @property
    def precision(self) -> Literal["f32", "f64"]: ...
    @property
    def adapter(self) -> Optional[str]: ...
    @property
    def positions(self) -> _Floats:
        """(N, 3): centres."""

    @property
    def orientations(self) -> _Floats:
        """(N, 4): unit quaternions [w, x, y, z], body axes to space."""

    @property
    def axes(self) -> _Floats:
        """(N, 3): each body's own z in space: the axis of rods and rings."""

    @property
    def velocities(self) -> _Floats:
        """(N, 3): length / time; under the overdamped law those of the last step."""

    @property
    def angular_velocities(self) -> _Floats:
        """(N, 3): in space axes, 1 / time."""

    @property
    def lengths(self) -> _Floats:
        """(N,): length of the major axis, tip to tip for a rod."""

    @property
    def shapes(self) -> npt.NDArray[np.uint32]:
        """(N,): a `Shape` each: 0 sphere, 1 spherocylinder, 2 ellipsoid, 3 torus, 5 superellipsoid."""

    @property
    def sizes(self) -> _Floats:
        """(N, 3): radius; diameter, length; three radii; major and minor radius; zero where a shape has none."""

    @property
    def exponents(self) -> _Floats:
        """(N, 2): exponents [n1, n2] of superellipsoids, zero of other shapes."""

    @property
    def groups(self) -> npt.NDArray[np.int32]:
        """(N,): index into the scene's `group_names`, or NO_GROUP."""

    @property
    def ids(self) -> npt.NDArray[np.int64]:
        """(N,): unique over a run; a division ends one and begins two."""

    @property
    def parents(self) -> npt.NDArray[np.int64]:
        """(N,): the id that divided into this one, or NO_PARENT."""

    @property
    def births(self) -> _Floats:
        """(N,): times of birth."""

    @property
    def generations(self) -> npt.NDArray[np.uint32]:
        """(N,): divisions since the founder."""

    @property
    def state_hash(self) -> str:
        """A hash of every bit of the state, as in `summary.json`."""

    def contacts(self, cutoff: float = 0.0) -> Contacts:
        """All pairs of bodies whose separation is at most `cutoff`, computed afresh in f64."""

    def wall_contacts(self, cutoff: float = 0.0) -> WallContacts:
        """All bodies and surfaces of walls whose separation is at most `cutoff`, computed afresh in f64."""

    @property
    def fields(self) -> dict[str, _Floats]:
        """The concentrations of the scene's fields by name, each indexed by x, y and z."""

    @property
    def bonds(self) -> Bonds:
        """The bonds and joints that hold, with the forces of the last step."""

    def summary(self) -> dict[str, Any]:
        """The summary of the run so far, with the keys of the program's `summary.json`."""

    def final_scene(self) -> Scene:
        """The state as a scene that continues from it, like the program's `final.json`."""

    def save(self, path: _Path) -> None:
        """Writes the state as the program's checkpoint (`.npz`), atomically."""

def devices(adapter: Optional[str] = None) -> list[dict[str, Any]]:
    """The GPU adapters of this machine, better ones first."""

def measures() -> dict[str, str]:
    """The measures: a description of each, by its name."""

def scenes() -> dict[str, str]:
    """The built-in scenes: a description of each, by its name."""

@final
class Ensemble:
    """Many scenes that run together: on a GPU as one, on the CPU over its cores."""

    def __new__(
        cls,
        scenes: Sequence[Scene],
        backend: Literal["cpu", "gpu"] = "cpu",
        threads: Optional[int] = None,
        precision: _Precision = None,
        adapter: Optional[str] = None,
    ) -> Ensemble: ...
    def __len__(self) -> int: ...
    def __getitem__(self, index: int, /) -> Simulation: ...
    def run(self, *, until: Optional[float] = None) -> list[Optional[Exception]]:
        """Runs every member to its end, or to `until`; returns for each None, or the exception that stopped it."""

    def summaries(self) -> list[dict[str, Any]]:
        """The members' summaries."""
