"""Makes the scenes of films of cells with a wavy surface: python3 films.py grow SEED, then cut SEED LENGTH."""
import json, math, sys
# Twice as large: 40, 10, 28, 2, with {"4": (150, .02, 11), "6": (250, .015, 5.5)}, 560 founders up to 16, 1,250 cells
# at most and a field of 80 x 56.
W, DEPTH, TOP, WAVE = 20.0, 5.0, 14.0, 1.0
# The length over which the front is fed: diffusion, step, end.
KINDS = {"0.75": (12, .03, 52), "1.25": (30, .03, 27), "2": (50, .02, 12), "3": (80, .015, 6.6)}
PHI = 0.85
ROD = {"rate_noise": .1, "division_length": 1.2, "division_length_noise": .1, "reorientation_degrees": 20}
WALL = [{"half_space": {"normal": [0, 1, 0], "offset": 0}}]
def grow(seed):
    return {"name": "film", "seed": seed, "planar": True, "time": {"dt": .01, "end": 9}, "periodic": {"lengths": [W, None, None]},
      "walls": WALL, "growth": {"rate": 1, **ROD, "stop": {"population": 320}},
      "generate": [{"isotropic": {"count": 140, "shape": {"spherocylinder": {"diameter": .5, "length": .8}},
        "lengths": {"uniform": {"from": .6, "to": 1.05}}, "region": {"box": {"minimum": [-W/2, 0, -1], "maximum": [W/2, 9, 1]}}}}],
      "output": {"every": 1}}
def cut(seed, name):
    D, dt, end = KINDS[name]
    length = float(name)
    uptake = D / (length**2 - D * dt) / PHI
    film = json.load(open(f"grown{seed}/final.json"))
    keep = []
    for body in film["bodies"]:
        x, y, _ = body["position"]
        if y < DEPTH + WAVE * math.cos(2 * math.pi * x / W): keep.append({k: body[k] for k in ("shape", "position", "orientation")})
    return {"name": "film-" + name, "seed": seed, "planar": True, "time": {"dt": dt, "end": end}, "periodic": {"lengths": [W, None, None]},
      "walls": WALL, "growth": {"rate": 15, **ROD, "nutrient": {"field": "food", "half": 15}, "stop": {"population": 4000}},
      "fields": {"food": {"cells": [40, int(2*TOP), 1], "spacing": .5, "center": [0, TOP/2, 0], "diffusion": D, "initial": 0,
        "boundary": {"y": ["closed", {"value": 1}]}, "exchange": [{"uptake": uptake * 15, "half": 15}]}},
      "bodies": keep, "output": {"every": end / 40}}
if sys.argv[1] == "grow": json.dump(grow(int(sys.argv[2])), open(f"grow{sys.argv[2]}.json", "w"))
else: json.dump(cut(int(sys.argv[2]), sys.argv[3]), open(f"film{sys.argv[3]}-{sys.argv[2]}.json", "w"))
