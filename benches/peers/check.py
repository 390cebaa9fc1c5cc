"""Writes the poses of a scene's start, or checks a run's frames: `check.py start SCENE FILE`, `check.py frames SCENE FILE`."""

import json
import pathlib
import sys

import checker
import numpy
import scene as scenes


def main():
    what, name, file = sys.argv[1:]
    scene = scenes.SCENES[name]
    if what == "start":
        scenes.write_poses(file, scenes.start(scene))
        return
    times, frames = scenes.read_frames(pathlib.Path(file), scene["side"] ** 3)
    overlaps = [checker.largest(scene, poses) for poses in frames]
    x = frames[-1][:, :3]
    spread = x - x.mean(axis=0)
    found = {
        "frames": len(frames),
        "max_overlap": max(overlaps),
        "end_overlap": overlaps[-1],
        "end_time": float(times[-1]),
        "gyration": float(numpy.sqrt((spread**2).sum(1).mean())),
    }
    print(json.dumps({key: None if value != value or value == float("inf") else value for key, value in found.items()}))


if __name__ == "__main__":
    main()
