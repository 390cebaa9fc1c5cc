"""Loads exports with the real readers and compares the surfaces that they make with the exact shapes of the states.

    check_export.py RUN --gsd FILE --vtk FOLDER

RUN is a run's folder or a state (.npz). It needs numpy, gsd and vtk; with ovito, that reads the GSD file too. It prints a line a check
and ends with status 1 where one fails, 3 where a package is missing.
"""
import argparse
import glob
import os
import sys
import time
import xml.etree.ElementTree as xml

try:
    import gsd.hoomd
    import numpy as np
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy
except ImportError as missing:
    print(f"SKIP: {missing}")
    sys.exit(3)
try:
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    import ovito.io
except ImportError:
    ovito = None

VTK_TOLERANCE = 1e-6
GSD_TOLERANCE = 1e-5  # positions are 32-bit floats
SPHERE, ROD, ELLIPSOID, TORUS, _, SUPERELLIPSOID = range(6)
KINDS = {"sphere": SPHERE, "spherocylinder": ROD, "ellipsoid": ELLIPSOID, "torus": TORUS, "superellipsoid": SUPERELLIPSOID}
MESHED = (TORUS, SUPERELLIPSOID)
MOST = 500  # bodies whose surfaces are compared, spread over a state
FAILED = []


def check(what, holds, said=""):
    print(f"{'ok  ' if holds else 'FAIL'} {what} {said}", flush=True)
    if not holds:
        FAILED.append(what)


def states(run):
    """The states of a run by step, the checkpoint's last."""
    if os.path.isfile(run):
        paths = [run]
    else:
        paths = sorted(glob.glob(os.path.join(run, "states", "state_*.npz"))) + [os.path.join(run, "checkpoint.npz")]
    import json

    found = {}
    for path in filter(os.path.exists, paths):
        state = np.load(path)
        header = json.loads(bytes(state["header"]))
        found[header["step"]] = (header["time"], state, path)
    return [(step, *found[step]) for step in sorted(found)]


def rotation(q):
    """Matrices of quaternions w, x, y, z."""
    w, x, y, z = np.moveaxis(np.asarray(q, float), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def off_surface(state, i, points):
    """How far points of space are from the surface of body i, the farthest of them."""
    local = (np.asarray(points, float) - state["position"][i]) @ rotation(state["orientation"][i])
    kind, (a, b, c) = int(state["shape"][i]), state["size"][i]
    x, y, z = local.T
    if kind == SPHERE:
        off = np.linalg.norm(local, axis=1) - a
    elif kind == ROD:
        half = 0.5 * (b - a)
        off = np.sqrt(x * x + y * y + (z - np.clip(z, -half, half)) ** 2) - 0.5 * a
    elif kind == TORUS:
        off = np.hypot(np.hypot(x, y) - a, z) - b
    elif kind == SUPERELLIPSOID:
        off = off_superellipsoid(np.array([a, b, c]), state["exponents"][i], local)
    else:
        radii = np.array([a, b, c])
        value = np.sqrt(((local / radii) ** 2).sum(axis=1))
        off = (value - 1) * value / np.linalg.norm(local / radii**2, axis=1)
    return np.abs(off).max()


def off_superellipsoid(radii, exponents, local):
    """The distance to first order: the gauge less 1, over its slope."""
    n1, n2 = exponents
    x, y, z = np.abs(local / radii).T
    across = (x**n2 + y**n2) ** (1 / n2)
    gauge = (across**n1 + z**n1) ** (1 / n1)
    out = (across / gauge) ** (n1 - 1)
    part = np.where(across > 0, across, 1)
    slope = np.c_[out * (x / part) ** (n2 - 1), out * (y / part) ** (n2 - 1), (z / gauge) ** (n1 - 1)] / radii
    return (gauge - 1) / np.linalg.norm(slope, axis=1)


def sphere_points(count=200):
    k = np.arange(count) + 0.5
    z, turn = 1 - 2 * k / count, np.pi * (1 + 5**0.5) * k
    return np.c_[np.cos(turn) * np.sqrt(1 - z * z), np.sin(turn) * np.sqrt(1 - z * z), z]


BALL = sphere_points()


def chosen(count):
    return np.unique(np.linspace(0, count - 1, min(count, MOST)).astype(int))


# ---- GSD


def type_surface(shape):
    """Points on the surface of a GSD shape, in body axes."""
    kind = shape["type"]
    if kind == "Sphere":
        return 0.5 * shape["diameter"] * BALL
    if kind == "Ellipsoid":
        return BALL * [shape["a"], shape["b"], shape["c"]]
    if kind == "Mesh":
        return np.array(shape["vertices"])
    assert kind == "ConvexPolyhedron" and len(shape["vertices"]) == 2
    return np.concatenate([BALL[BALL[:, 2] * v[2] >= 0] * shape["rounding_radius"] + v for v in shape["vertices"]])


def own_surface(state, i, sizes):
    """Points on the surface that OVITO makes of a body's own three numbers."""
    if state["shape"][i] == ROD:
        radius, _, length = sizes
        return np.concatenate([BALL[BALL[:, 2] * s >= 0] * radius + [0, 0, s * length / 2] for s in (-1, 1)])
    return BALL * sizes


def check_gsd(path, run):
    begun = time.time()
    with gsd.hoomd.open(path, "r") as file:
        check("gsd: schema", file.file.schema == "hoomd" and file.file.schema_version == (1, 4))
        check("gsd: one frame per state", len(file) == len(run), f"{len(file)}")
        typed, own, sizes, turned, inside = 0.0, 0.0, 0.0, 0.0, True
        classed = False
        for frame, (step, when, state, _) in zip(file, run):
            n = len(state["position"])
            p = frame.particles
            same = frame.configuration.step == step and frame.log["time"][0] == when and p.N == n
            for name in ("id", "birth", "generation", "angular_velocity", "size"):
                same &= np.array_equal(frame.log["particles/" + name], state[name])
            same &= np.array_equal(frame.log["particles/parent"], state["parent"].astype(np.int64))
            same &= np.array_equal(p.velocity, state["velocity"].astype(np.float32))
            if not same:
                check(f"gsd: step {step}", False, "differs from the state")
            axis = np.linalg.norm(rotation(p.orientation) - rotation(state["orientation"]), axis=(1, 2)).max()
            turned = max(turned, axis)
            half = frame.configuration.box[:3] / 2
            # A planar box has no height.
            inside &= bool((np.abs(state["position"]) < half)[:, half > 0].all())
            named = np.array([KINDS[t.split("_")[0]] for t in p.types])
            if not np.array_equal(named[p.typeid], state["shape"]):
                check(f"gsd: step {step}", False, "types are of other shapes")
            asp = frame.log.get("particles/Aspherical Shape")
            classed = asp is not None
            turns = rotation(p.orientation)
            for i in chosen(n):
                place = lambda points: points @ turns[i].T + p.position[i]
                typed = max(typed, off_surface(state, i, place(type_surface(p.type_shapes[p.typeid[i]]))))
                if classed and state["shape"][i] not in MESHED:
                    own = max(own, off_surface(state, i, place(own_surface(state, i, asp[i]))))
        check("gsd: orientations", turned < 1e-6, f"{turned:.1e}")
        check("gsd: the box holds all centres", inside)
        scale = max(1.0, max(np.abs(s["position"]).max() for _, _, s, _ in run))
        if classed:
            print(f"     gsd: {len(p.types)} types are classes, up to {typed:.1e} off")
            check("gsd: surfaces by a body's own sizes", own < GSD_TOLERANCE * scale, f"{own:.1e}")
        else:
            check("gsd: surfaces by type", typed < GSD_TOLERANCE * scale, f"{typed:.1e} with {len(p.types)} types")
    print(f"     gsd: read in {time.time() - begun:.1f} s")


def check_ovito(path, run):
    begun = time.time()
    pipeline = ovito.io.import_file(path)
    check("ovito: frames", pipeline.source.num_frames == len(run))
    first = time.time() - begun
    worst, kinds = 0.0, set()
    for k in sorted({0, len(run) // 2, len(run) - 1, 0}) + [0]:
        _, _, state, _ = run[k]
        data = pipeline.compute(k)
        p = data.particles
        types = {t.id: t for t in p.particle_types.types}
        asp = np.asarray(p["Aspherical Shape"]) if "Aspherical Shape" in p else np.zeros((p.count, 3))
        q = np.asarray(p["Orientation"])[:, [3, 0, 1, 2]]
        turns = rotation(q)
        meshes = {}
        if p.count != len(state["position"]):
            check(f"ovito: frame {k}", False, "number of particles")
            continue
        for i in chosen(p.count):
            kind, of = int(state["shape"][i]), types[int(p["Particle Type"][i])]
            kinds.add(str(of.shape))
            if kind in MESHED:
                if of.id not in meshes:
                    meshes[of.id] = np.array(of.mesh.vertices if hasattr(of.mesh, "vertices") else of.mesh.get_vertices())
                points = meshes[of.id] * of.radius
            elif asp[i].any():
                points = own_surface(state, i, asp[i])
                if kind == ROD and str(of.shape) != "Shape.Spherocylinder":
                    check(f"ovito: frame {k}", False, f"a rod is a {of.shape}")
            else:
                points = BALL * of.radius
            worst = max(worst, off_surface(state, i, points @ turns[i].T + np.asarray(p["Position"])[i]))
    scale = max(1.0, max(np.abs(s["position"]).max() for _, _, s, _ in run))
    check("ovito: surfaces", worst < GSD_TOLERANCE * scale, f"{worst:.1e}")
    print(f"     ovito {ovito.version_string}: opened in {first:.1f} s, in all {time.time() - begun:.1f} s")


# ---- VTK


def collection(folder, name):
    tree = xml.parse(os.path.join(folder, name + ".pvd")).getroot()
    return [(float(d.get("timestep")), os.path.join(folder, d.get("file"))) for d in tree.iter("DataSet")]


def read_vtp(path):
    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


def arrays(data):
    return {data.GetArrayName(k): vtk_to_numpy(data.GetArray(k)) for k in range(data.GetNumberOfArrays())}


def points_of(poly):
    return vtk_to_numpy(poly.GetPoints().GetData()) if poly.GetNumberOfPoints() else np.zeros((0, 3))


def check_bodies(poly, state):
    """Centres and data are the state's bits; glyphs of spheres and ellipsoids lie on their surfaces."""
    data = arrays(poly.GetPointData())
    same = np.array_equal(points_of(poly), state["position"])
    for name in ("orientation", "size", "shape", "birth", "generation", "velocity", "angular_velocity"):
        same &= np.array_equal(data[name], state[name])
    same &= np.array_equal(data["id"], state["id"].astype(np.int64))
    same &= np.array_equal(data["parent"], state["parent"].astype(np.int64))
    ball = vtk.vtkSphereSource()
    ball.SetOutputPointsPrecision(vtk.vtkAlgorithm.DOUBLE_PRECISION)
    ball.SetRadius(0.5)
    ball.SetThetaResolution(24)
    ball.SetPhiResolution(24)
    worst = 0.0
    for i in chosen(len(state["position"])):
        if not data["glyph"][i].any():
            continue
        # What vtkGlyph3DMapper makes of a quaternion.
        q = vtk.vtkQuaternion["d"](*data["orientation"][i])
        axis = [0.0, 0.0, 0.0]
        angle = np.degrees(q.GetRotationAngleAndAxis(axis))
        placed = vtk.vtkTransform()
        placed.Translate(*state["position"][i])
        placed.RotateWXYZ(angle, *axis)
        placed.Scale(*data["glyph"][i])
        moved = vtk.vtkTransformFilter()
        moved.SetOutputPointsPrecision(vtk.vtkAlgorithm.DOUBLE_PRECISION)
        moved.SetInputConnection(ball.GetOutputPort())
        moved.SetTransform(placed)
        moved.Update()
        worst = max(worst, off_surface(state, i, points_of(moved.GetOutput())))
    return same, worst


def check_axes(poly, state):
    """Tubes around the axes, and spheres at the ends of rods, lie on the surfaces."""
    if not poly.GetNumberOfPoints():
        return 0, 0.0
    tube = vtk.vtkTubeFilter()
    tube.SetInputData(poly)
    tube.SetInputArrayToProcess(0, 0, 0, vtk.vtkDataObject.FIELD_ASSOCIATION_POINTS, "radius")
    tube.SetVaryRadiusToVaryRadiusByAbsoluteScalar()
    tube.SetNumberOfSides(16)
    tube.CappingOff()
    tube.Update()
    tubes = tube.GetOutput()
    surface, of = points_of(tubes), arrays(tubes.GetPointData()).get("body", np.zeros(0))
    worst = 0.0
    order = np.argsort(of, kind="stable")
    starts = np.searchsorted(of[order], np.arange(len(state["position"]) + 1))
    data = arrays(poly.GetPointData())
    ends = points_of(poly)
    for i in chosen(len(state["position"])):
        mine = order[starts[i] : starts[i + 1]]
        if len(mine):
            # The first and the last ring of a closed tube are cut across, and lie inside.
            inner = mine if state["shape"][i] == ROD else mine[16:-16]
            worst = max(worst, off_surface(state, i, surface[inner]))
    for k in chosen(len(ends)):
        if data["cap"][k]:
            i, half = int(data["body"][k]), 0.5 * data["cap"][k]
            out = ends[k] - state["position"][i]
            away = BALL[BALL @ out >= 0] if out.any() else BALL
            worst = max(worst, off_surface(state, i, ends[k] + half * away))
    covered = len(set(data["body"].tolist()))
    return covered, worst


def check_contacts(poly, state):
    """Normals are units, contact points lie half a separation inside or outside of both surfaces."""
    data = arrays(poly.GetPointData())
    points, worst = points_of(poly), 0.0
    if not len(points):
        return 0, 0.0, 0
    worst = np.abs(np.linalg.norm(data["normal"], axis=1) - 1).max()
    for k in chosen(len(points)):
        for body, side in ((data["a"][k], -0.5), (data["b"][k], 0.5)):
            on = points[k] + side * data["separation"][k] * data["normal"][k]
            worst = max(worst, off_surface(state, int(body), on[None]))
    return len(points), worst, int(np.isfinite(data["gamma"]).sum())


def check_surfaces(folder, run):
    """Each superellipsoid has its surface, whose corners are on it."""
    states, worst, covered = {when: state for _, when, state, _ in run}, 0.0, True
    for when, path in collection(folder, "surfaces"):
        poly, state = read_vtp(path), states[when]
        covered &= poly.GetPointData().GetNormals() is not None and poly.GetNumberOfPolys() > 0
        points, of = points_of(poly), arrays(poly.GetPointData())["body"]
        covered &= np.array_equal(np.unique(of), np.flatnonzero(state["shape"] == SUPERELLIPSOID))
        for i in np.unique(of):
            worst = max(worst, off_surface(state, i, points[of == i]))
    check("vtk: a surface with normals for each superellipsoid", covered)
    check("vtk: surfaces", worst < VTK_TOLERANCE, f"{worst:.1e}")


def check_vtk(folder, run):
    begun = time.time()
    listed = {name: collection(folder, name) for name in ("bodies", "axes", "contacts")}
    times = [when for _, when, _, _ in run]
    check("vtk: times", all([when for when, _ in listed[name]] == times for name in listed), f"{len(times)} states")
    same, glyphs, tubes, contacts, pairs, forces, axes = True, 0.0, 0.0, 0.0, 0, 0, True
    for k, (_, when, state, _) in enumerate(run):
        polys = {name: read_vtp(listed[name][k][1]) for name in listed}
        same &= all(vtk_to_numpy(p.GetFieldData().GetArray("TimeValue"))[0] == when for p in polys.values())
        equal, worst = check_bodies(polys["bodies"], state)
        same, glyphs = same & equal, max(glyphs, worst)
        covered, worst = check_axes(polys["axes"], state)
        axes &= covered == int(np.isin(state["shape"], (ROD, TORUS)).sum())
        tubes = max(tubes, worst)
        count, worst, known = check_contacts(polys["contacts"], state)
        pairs, forces, contacts = pairs + count, forces + known, max(contacts, worst)
    check("vtk: the states' own numbers", same)
    check("vtk: glyphs", glyphs < VTK_TOLERANCE, f"{glyphs:.1e}")
    check("vtk: an axis a rod and ring", axes)
    check("vtk: tubes and caps", tubes < VTK_TOLERANCE, f"{tubes:.1e}")
    if os.path.exists(os.path.join(folder, "surfaces.pvd")):
        check_surfaces(folder, run)
    check("vtk: contacts", contacts < VTK_TOLERANCE, f"{contacts:.1e} of {pairs}, {forces} with a force")
    print(f"     vtk {vtk.vtkVersion.GetVTKVersion()}: {time.time() - begun:.1f} s")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run")
    parser.add_argument("--gsd")
    parser.add_argument("--vtk")
    arguments = parser.parse_args()
    run = states(arguments.run)
    if arguments.gsd:
        check_gsd(arguments.gsd, run)
        if ovito:
            check_ovito(arguments.gsd, run)
        else:
            print("SKIP ovito: not installed")
    if arguments.vtk:
        check_vtk(arguments.vtk, run)
    sys.exit(1 if FAILED else 0)


main()
