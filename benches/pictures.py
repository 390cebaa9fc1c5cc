"""Makes the small pictures of the viewer in docs/view.md, one for each thing that it can show, with Chromium.

    pictures.py PROGRAM FOLDER [OUT] [--only NAME,NAME] [--browser chromium]

PROGRAM is a relcp, FOLDER is made for its runs and kept for another time, OUT is docs/pictures. Needs Pillow, which packs the pictures.
"""
import argparse
import base64
import io
import os
import subprocess
import sys

from PIL import Image

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "tests", "readers"))
from check_browser import AT_REST, OPENED, Browser  # noqa: E402

# Colours of a picture: bodies have few, and letters few more.
COLOURS = 96
RUNS = {
    "strains": ["two-strains", "time.end=4", "output.every=0.25"],
    "pile": ["pile", "output.every=0.2"],
    "filament": ["filament"],
    "mail": ["chainmail", "time.end=1"],
    "chain": ["colony", "time.dt=0.01", "time.end=5", "output.every=0.1", "growth.bond_daughters={\"stiffness\": 100, \"bending\": 0.05}",
              "output.measures=[\"nematic\",\"radius\",\"packing\",\"length\",\"contacts\"]"],
    "ball": ["compaction", "output.forces=true"],
}
# Each picture: its run, where it looks (an address after #), what is done then, and the part that is kept: the stage,
# the panel, or an element.
PICTURES = {
    "bonds": ("chain", "colour=length&show=bonds", "", "#stage"),
    "axes": ("filament", "t=6&show=axes", "viewer.look('top'); viewer.camera.zoom(1.5)", "#stage"),
    "velocities": ("strains", "t=4&show=ways,walls", "viewer.camera.zoom(2.5)", "#stage"),
    "trails": ("filament", "t=12&show=trails", "viewer.look('top')", "#stage"),
    "hidden": ("strains", "t=4&hidden=0&show=walls", "", "#stage"),
    "swatches": ("strains", "t=4", "", "#side"),
    "cut": ("ball", "", "viewer.show(1e9); viewer.look(); viewer.camera.zoom(9); viewer.setCut(0.5); viewer.setColour(viewer.run.header.quantities.findIndex(({ name }) => name === 'force'))", "#stage"),
    "perspective": ("pile", "show=perspective,walls", "", "#stage"),
    "haze": ("mail", "show=haze", "", "#stage"),
    "plots": ("chain", "t=3", "byId('curves').open = true; byId('measures').scrollIntoView()", "#side"),
    "scene": ("pile", "t=1", "byId('scene').open = true; byId('scene').scrollIntoView()", "#side"),
    "contacts": ("ball", "pick=40", "viewer.play(false); viewer.show(1e9); viewer.focus(); viewer.camera.zoom(20)", "#stage"),
}
# Those whose legend is part of what they show.
WITH_LEGEND = ["bonds", "cut"]
# Of a phone, light and dark.
PHONE = {"width": 360, "height": 640, "deviceScaleFactor": 1, "mobile": True}


def run_of(program, folder, name):
    out = os.path.join(folder, name)
    scene, *sets = RUNS[name]
    # A long run may be stopped before its end: what it has recorded by then is shown.
    if not os.path.exists(os.path.join(out, "summary.json")):
        command = [program, "run", scene, "--out", out, "--quiet", "--backend", "cpu", "--set", "output.picture=false"]
        subprocess.run(command + [word for each in sets for word in ("--set", each)], check=True)
    subprocess.run([program, "view", out, "--quiet"], check=True)
    return "file://" + os.path.abspath(os.path.join(out, "view.html"))


def keep(browser, path, part):
    clip = browser.run(f"(({{ left, top, width, height }}) => ({{ x: left, y: top, width, height, scale: 1 }}))(document.querySelector('{part}').getBoundingClientRect())")
    data = browser.call("Page.captureScreenshot", format="png", clip=clip)["data"]
    picture = Image.open(io.BytesIO(base64.b64decode(data))).convert("RGB")
    picture.quantize(COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE).save(path, optimize=True)
    print(f"{path}: {picture.width}x{picture.height}, {os.path.getsize(path) / 1000:.0f} kB", flush=True)


def size(browser, width, height, mobile=False):
    browser.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=mobile)


def theme(browser, name):
    browser.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": name}])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("folder")
    parser.add_argument("out", nargs="?", default=os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "docs", "pictures"))
    parser.add_argument("--only", default="")
    parser.add_argument("--browser", default="chromium")
    given = parser.parse_args()
    os.makedirs(given.folder, exist_ok=True)
    only = set(filter(None, given.only.split(",")))
    browser = Browser(given.browser)
    for name, (run, look, then, part) in PICTURES.items():
        if only and name not in only:
            continue
        page = run_of(given.program, given.folder, run)
        # The panel is 320 wide.
        size(browser, *((740, 330) if part == "#stage" else (740, 420)))
        browser.call("Page.navigate", url="about:blank")
        browser.open(f"{page}#{look}", OPENED)
        hide = "" if name in WITH_LEGEND else "byId('legend').style.visibility = 'hidden';"
        browser.run(f"viewer.play(false); {hide} {then}; viewer.request()")
        browser.run(AT_REST)
        keep(browser, os.path.join(given.out, f"view-{name}.png"), part)
    for colours in ("light", "dark"):
        name = f"phone-{colours}"
        if only and name not in only:
            continue
        theme(browser, colours)
        size(browser, PHONE["width"], PHONE["height"], True)
        browser.call("Page.navigate", url="about:blank")
        browser.open(run_of(given.program, given.folder, "strains") + "#t=4", OPENED)
        browser.run(AT_REST)
        keep(browser, os.path.join(given.out, f"view-{name}.png"), "body")
    browser.quiet("of all pages")
    browser.close()


if __name__ == "__main__":
    main()
