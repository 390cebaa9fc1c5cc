"""Shows a relcp export in ParaView, every shape with its exact size.

    paraview --script=show.py              in the window; or Macros > Import new macro, or Tools > Python Shell > Run Script
    pvpython show.py --picture last.png    the last state as a picture
    pvpython show.py --movie frames/f.png  every state

`--colour NAME` colours by an array that bodies.pvd and axes.pvd have: generation, shape, id or birth; without it the first of
these that varies.
Rods are tubes around axes.pvd with a sphere at each end, rings are tubes, spheres and ellipsoids are 3D glyphs at bodies.pvd,
superellipsoids are the meshes of surfaces.pvd.
Bonds are the lines of bonds.pvd, if the run has bonds.
"""
import argparse
import os

from paraview import simple as pv

FOLDER = None  # where the export was written, for a ParaView that does not say where this file is
FACES = 32  # around a tube or a sphere


def here():
    """The folder of bodies.pvd."""
    for folder in [os.path.dirname(os.path.abspath(globals().get("__file__", ""))), os.getcwd(), FOLDER]:
        if folder and os.path.exists(os.path.join(folder, "bodies.pvd")):
            return folder
    raise SystemExit("bodies.pvd is neither beside this script nor in the folder that it was written to")


def open_collection(folder, name):
    reader = pv.PVDReader(registrationName=name, FileName=os.path.join(folder, name + ".pvd"))
    reader.UpdatePipeline(reader.TimestepValues[-1] if len(reader.TimestepValues) else 0.0)
    return reader


def spread(source, name):
    """The range of a point array, (0, 0) where there is none."""
    array = source.PointData.GetArray(name)
    return array.GetRange(-1 if name == "glyph" else 0) if array else (0.0, 0.0)


def glyphs(source, view, scale, by_components, orientation):
    """Spheres of unit diameter at the points, scaled by an array."""
    shown = pv.Show(source, view, "GeometryRepresentation")
    shown.SetRepresentationType("3D Glyphs")
    shown.GlyphType = "Sphere"
    shown.GlyphType.Radius = 0.5
    shown.GlyphType.ThetaResolution = FACES
    shown.GlyphType.PhiResolution = FACES
    shown.Scaling = 1
    shown.ScaleMode = "Vector Components" if by_components else "Magnitude"
    shown.SelectScaleArray = scale
    shown.ScaleFactor = 1.0
    if orientation:
        shown.Orient = 1
        shown.OrientationMode = "Quaternion"
        shown.SelectOrientationVectors = orientation
    return shown


def colour_by(shown, name, limits):
    pv.ColorBy(shown, ("POINTS", name))
    table = pv.GetColorTransferFunction(name)
    table.ApplyPreset("Viridis (matplotlib)", True)
    table.RescaleTransferFunction(*limits)


def show(folder, view, colour=None):
    """Shows the export in a view."""
    bodies, axes = open_collection(folder, "bodies"), open_collection(folder, "axes")
    if not colour:
        varied = [name for name in ("generation", "shape") if spread(bodies, name)[0] < spread(bodies, name)[1]]
        colour = (varied + ["id"])[0]
    low, high = spread(bodies, colour)
    if colour == "shape":
        low, high = 0, max(high, 3)
    limits = (low, high) if high > low else (min(low, 0), max(high, 1))
    parts = []
    if spread(bodies, "glyph")[1] > 0:
        parts.append(glyphs(bodies, view, "glyph", True, "orientation"))
    if spread(axes, "radius")[1] > 0:
        tube = pv.Tube(registrationName="tubes", Input=axes)
        tube.Scalars = ["POINTS", "radius"]
        tube.VaryRadius = "By Absolute Scalar"
        tube.NumberofSides = FACES
        tube.Capping = 0
        parts.append(pv.Show(tube, view, "GeometryRepresentation"))
    if spread(axes, "cap")[1] > 0:
        parts.append(glyphs(axes, view, "cap", False, None))
    if os.path.exists(os.path.join(folder, "surfaces.pvd")):
        parts.append(pv.Show(open_collection(folder, "surfaces"), view, "GeometryRepresentation"))
    if os.path.exists(os.path.join(folder, "bonds.pvd")):
        lines = pv.Show(open_collection(folder, "bonds"), view, "GeometryRepresentation")
        lines.LineWidth = 3
        pv.ColorBy(lines, None)
    coloured = [part for part in parts if part.Input.PointData.GetArray(colour)]
    for part in coloured:
        colour_by(part, colour, limits)
    if coloured:
        coloured[-1].SetScalarBarVisibility(view, True)
    scene = pv.GetAnimationScene()
    scene.UpdateAnimationUsingDataTimeSteps()
    scene.GoToLast()
    bounds = bodies.GetDataInformation().GetBounds()
    flat = bounds[5] - bounds[4] <= 0
    view.InteractionMode = "2D" if flat else "3D"
    view.ResetCamera(False)
    pv.Render(view)
    return bodies


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--picture", help="write the last state as this picture")
    parser.add_argument("--movie", help="write every state, as pictures numbered after this name or as a film")
    parser.add_argument("--colour", help="an array of bodies.pvd")
    parser.add_argument("--size", default="1280x720")
    # In the window the arguments are ParaView's own.
    arguments = parser.parse_known_args()[0]
    view = pv.GetActiveViewOrCreate("RenderView")
    width, height = (int(side) for side in arguments.size.split("x"))
    if arguments.picture or arguments.movie:
        view.ViewSize = [width, height]
    show(here(), view, arguments.colour)
    if arguments.picture:
        pv.SaveScreenshot(arguments.picture, view, ImageResolution=[width, height])
    if arguments.movie:
        os.makedirs(os.path.dirname(os.path.abspath(arguments.movie)), exist_ok=True)
        pv.SaveAnimation(arguments.movie, view, ImageResolution=[width, height])


main()
