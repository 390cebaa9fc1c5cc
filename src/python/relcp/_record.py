"""Runs that Python records, as `relcp run` does."""

import sys

from ._relcp import Recording
from ._run import Run, warn

# Wall time of the steps between two updates of the progress, in seconds.
_UPDATE_EVERY = 0.1


def _bar(shown, total, done):
    """A bar of tqdm, where it is installed and somebody looks; else None."""
    notebook = "ipykernel" in sys.modules
    if not shown or not (notebook or (sys.stderr is not None and sys.stderr.isatty())):
        return None
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return None
    return tqdm(total=total, initial=done, unit="step")


def run(
    scene,
    out=None,
    *,
    backend="cpu",
    threads=None,
    precision=None,
    adapter=None,
    resume=False,
    until=None,
    start_from=None,
    start_time=None,
    forces=(),
    rules=None,
    checkpoint_every=None,
    progress=True,
):
    """Runs a scene to its end and records it, as `relcp run`: the same files with the same bits. Returns the `Run`.

    `out` is its folder, which must be new or empty; by default a new one in `runs`, named after the scene. Ctrl-C ends
    it between two steps, with a checkpoint: `relcp.run(scene, out, resume=True)`, `Run.resume` or the program go on to
    the same bits. `until` is then a later end than the scene's. `start_from` is another run, whose last state that is
    not later than `start_time` this one begins with, as `relcp run --from`.

    `forces` are functions as for `Simulation.add_force`, `rules` an object as `Simulation.rules`. They are not in the
    folder, so give them again to resume.

    `checkpoint_every` is the wall time between checkpoints in seconds, a minute by default. `progress` shows a bar on a
    terminal or in a notebook, where tqdm is installed. A run that a failed step stops raises SimulationError; its
    folder has the state before that step.
    """
    if resume and out is None:
        raise ValueError("resume: name the folder of the run as `out`")
    if until is not None and not resume:
        raise ValueError("until: a later end is for a run that is resumed; set time.end of the scene for a new one")
    if start_time is not None and start_from is None:
        raise ValueError("start_time: is a time of the run `start_from`")
    if resume and start_from is not None:
        raise ValueError("start_from: a run that is resumed has begun already")
    origin = start_from.path if isinstance(start_from, Run) else start_from
    recording = Recording(
        scene, out, backend, threads, precision, adapter, resume, until,
        None if origin is None else (origin, start_time), list(forces), rules, checkpoint_every,
    )  # fmt: skip
    warn(recording.notes)
    bar = None
    try:
        done = False
        while not done:
            steps, time, bodies, done = recording.advance(_UPDATE_EVERY)
            if bar is None and not done:
                bar = _bar(progress, scene.steps, steps)
            if bar is not None:
                bar.update(steps - bar.n)
                bar.set_postfix(time=f"{time:.6g}", bodies=bodies, refresh=False)
    except KeyboardInterrupt:
        recording.finish()
        raise
    finally:
        if bar is not None:
            bar.close()
    recording.finish()
    return Run(recording.folder)
