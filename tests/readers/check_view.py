"""Opens pages of `relcp view` in headless Chromium, uses them by keyboard and pointer, and compares them with the run.

    check_view.py PROGRAM FOLDER [--browser chromium] [--sizes 512,16384,131072] [--picks 40]

PROGRAM is a relcp, FOLDER is made for its runs. It needs Chromium, numpy, pillow and websocket-client (for the DevTools
protocol), prints Markdown tables, and ends with status 1 where a check fails, 3 where a package is missing.

Pictures: the canvas of the page against `relcp render --bare` at the canvas's size, with the same fit to all states.
Picks: clicks on projected centres; the expected body is the first that a ray through the clicked sample meets.
Sizes: the time until a page is read and drawn, and the time of a frame while the bodies turn under the pointer.
"""
import argparse
import base64
import glob
import io
import itertools
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time

try:
    import numpy as np
    import websocket
    from PIL import Image
except ImportError as missing:
    print(f"SKIP: {missing}")
    sys.exit(3)

FLAGS = ["--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-first-run",
         "--disable-background-networking", "--window-size=1280,800", "--remote-debugging-port=0", "about:blank"]
SYNC = "page.painter.gl.readPixels(0, 0, 1, 1, 6408, 5121, new Uint8Array(4))"  # waits for the picture
OPENED = f"""new Promise((done, refuse) => {{ const look = () => {{
  const page = window.viewer, busy = document.getElementById("busy");
  if (busy?.textContent.includes("cannot")) return refuse(busy.textContent);
  if (!page) return setTimeout(look, 5);
  {SYNC}; done([page.opened.read, performance.now()]);
}}; look(); }})"""
# At rest the last picture is a fine one. A page with a coarse one, two seconds after it, is noted, and helped.
AT_REST = f"""new Promise((done) => {{ const page = window.viewer; let since = performance.now(); const look = () => {{
  if (page.drawing) since = performance.now();
  if (page.drawing || (!page.drawn_finely && performance.now() < since + 2000)) return setTimeout(look, 20);
  if (!page.drawn_finely) {{ window.stayed_coarse = (window.stayed_coarse ?? 0) + 1; page.draw(true); }}
  {SYNC}; done(performance.now());
}}; look(); }})"""
# Every coarse picture, from its start until its pixels are there.
WATCH = f"""(() => {{ const page = window.viewer; window.coarse = []; page.draw = (fine) => {{
  const begun = performance.now(); Object.getPrototypeOf(page).draw.call(page, fine); {SYNC};
  if (!fine) window.coarse.push(performance.now() - begun); }}; }})()"""
CLICKED = "viewer.canvas.addEventListener('pointerup', () => { window.samples = viewer.painter.samples; }, true)"
BOX = "((box) => [box.left, box.top, box.width, box.height])(viewer.canvas.getBoundingClientRect())"
FORCES, COUNT, DENSITY = "output.forces=true", "generate.0.isotropic.count=", "generate.0.isotropic.volume_fraction="
RUNS = {  # by name: scene, colours, what is set
    "colony": ("colony", ["orientation", "pressure"], [FORCES, "output.every=0.25"]),
    "packing": ("compaction", ["orientation", "force"], [
        FORCES, COUNT + "300", DENSITY + "0.05", "time.end=20", "output.every=1"]),
}
CHEAP = [DENSITY + "0.2", "time.dt=0.05", "time.end=0.95", "output.every=0.05", "contact.overlap_tolerance=0.01"]
FAILED = []
PAPER, FAR = 250, 32  # of 255: white paper is above, and a pixel that is off by more is far
HALF = np.array([0.5, -0.5])  # of a sample, to the right and down


def check(what, holds, said=""):
    print(f"{'ok  ' if holds else 'FAIL'} {what} {said}", flush=True)
    FAILED.extend([] if holds else [what])


class Browser:
    """A Chromium that is spoken to by the DevTools protocol."""

    def __init__(self, program, folder):
        self.folder = tempfile.mkdtemp(dir=os.path.abspath(folder))
        command = [program, f"--user-data-dir={self.folder}", *FLAGS]
        self.process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        written = os.path.join(self.folder, "DevToolsActivePort")
        while not os.path.exists(written) or "/" not in open(written).read():
            time.sleep(0.1)
        port, path = open(written).read().split()
        self.socket = websocket.create_connection(f"ws://127.0.0.1:{port}{path}", suppress_origin=True, timeout=600)
        self.session, self.last, self.events = None, 0, []
        self.version = self.call("Browser.getVersion")["product"]
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        speeds = {"latency": 0, "downloadThroughput": -1, "uploadThroughput": -1}
        self.call("Network.emulateNetworkConditions", offline=True, **speeds)

    def call(self, method, **parameters):
        self.last += 1
        session = {"sessionId": self.session} if self.session else {}
        self.socket.send(json.dumps({"id": self.last, "method": method, "params": parameters, **session}))
        while True:
            answer = json.loads(self.socket.recv())
            if answer.get("id") == self.last:
                return answer["result"]
            self.events.append(answer)

    def run(self, script):
        answer = self.call("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(answer["exceptionDetails"])
        return answer["result"].get("value")

    def keys(self, *keys):
        for key, kind in itertools.product(keys, ("keyDown", "keyUp")):
            self.call("Input.dispatchKeyEvent", type=kind, key=key)

    def mouse(self, kind, at, pressed=True, shift=False, **more):
        self.call("Input.dispatchMouseEvent", type=kind, x=at[0], y=at[1], clickCount=1, buttons=int(pressed),
                  button="none" if kind == "mouseWheel" else "left", modifiers=8 if shift else 0, **more)

    def drag(self, at, moves, shift=False):
        """Presses, moves by each pair of pixels in turn, releases; without moves it is a click."""
        self.mouse("mousePressed", at, shift=shift)
        for right, down in moves:
            at = (at[0] + right, at[1] + down)
            self.mouse("mouseMoved", at, shift=shift)
        self.mouse("mouseReleased", at, False, shift)

    def open(self, page):
        """Opens a page; gives milliseconds until it is read, has a first picture, and has a fine one."""
        self.call("Page.navigate", url="file://" + os.path.abspath(page))
        return *self.run(OPENED), self.run(AT_REST)

    def quiet(self, name):
        """Nothing was asked of the network but the page itself, and nothing stands in the console."""
        told = lambda *methods: [it["params"] for it in self.events if it.get("method") in methods]
        asked = [it["request"]["url"] for it in told("Network.requestWillBeSent")]
        other = [url[:80] for url in asked if not (url.startswith("file://") and url.endswith("/view.html"))]
        said = told("Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded")
        check(f"network {name}", asked and not other, str(other))
        check(f"console {name}", not said, json.dumps(said)[:300])
        coarse = self.run("window.stayed_coarse ?? 0")
        check(f"fine at rest {name}", coarse == 0, f"{coarse} times a coarse picture stayed for two seconds")
        self.events.clear()

    def close(self):
        self.session = None
        self.call("Browser.close")
        self.process.wait(30)
        shutil.rmtree(self.folder, ignore_errors=True)


def relcp(program, *arguments):
    done = subprocess.run([program, *arguments, "--quiet"], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(arguments)}: status {done.returncode}\n{done.stderr[-500:]}")


def make(program, folder, name, scene, sets):
    """A run and its page; a run that is there already is used again."""
    run = os.path.join(folder, name)
    if not os.path.exists(os.path.join(run, "summary.json")):
        options = [word for key_value in sets for word in ("--set", key_value)]
        relcp(program, "run", scene, "--out", run, "--backend", "cpu", *options)
    relcp(program, "view", run)
    return run


def to_body(q, v):
    """Vectors of space in the axes of bodies with quaternions w, x, y, z."""
    twice = 2 * np.cross(-q[:, 1:], v)
    return v + q[:, :1] * twice + np.cross(-q[:, 1:], twice)


def first_met(state, origin, toward):
    """The row of the body that a viewer far along `toward` sees through `origin`; -1 where there is none."""
    o = to_body(state["orientation"], origin - state["position"])
    d = to_body(state["orientation"], np.tile(toward, (len(o), 1)))
    rod, (a, b, _) = state["shape"] == 1, state["size"].T
    half, radius = np.where(rod, (b - a) / 2, 0), np.where(rod, a / 2, a)

    def last_root(o, d):
        """The larger t where |o + t d| = 1."""
        p, q, r = (d * d).sum(1), (o * d).sum(1), (o * o).sum(1) - 1
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(q * q >= p * r, (np.sqrt(q * q - p * r) - q) / p, -np.inf)

    radii = np.where((state["shape"] == 2)[:, None], state["size"], radius[:, None])
    ends = [last_root((o - np.outer(sign * half, [0, 0, 1])) / radii, d / radii) for sign in (-1, 1)]
    side = last_root(o * [1, 1, 0] / radii, d * [1, 1, 0] / radii)
    on_side = rod & np.isfinite(side) & (np.abs(o[:, 2] + np.nan_to_num(side) * d[:, 2]) <= half)
    met = np.maximum(np.maximum(*ends), np.where(on_side, side, -np.inf))
    return int(met.argmax()) if np.isfinite(met.max()) else -1


def pictures(browser, program, run, colours, count, rows):
    """The canvas beside `relcp render`, at three times and in each colour."""
    width, height = browser.run("[viewer.canvas.width, viewer.canvas.height]")
    name = os.path.basename(run)
    for colour in colours:
        out = os.path.join(run, "render-" + colour)
        relcp(program, "render", run, "--out", out, "--size", f"{width}x{height}", "--colour", colour, "--bare",
              "--no-movie", "--backend", "cpu")
        while browser.run("document.getElementById('colour').selectedOptions[0].textContent") != colour:
            browser.keys("c")
        for k in (0, count // 2, count - 1):
            browser.keys("Home", *k * ["ArrowRight"])
            data = browser.run(f"{AT_REST}.then(() => viewer.canvas.toDataURL('image/png'))").split(",")[1]
            sources = io.BytesIO(base64.b64decode(data)), os.path.join(out, "frames", f"{k:06}.png")
            page, drawn = (np.asarray(Image.open(source).convert("RGB"), float) for source in sources)
            off = np.abs(page - drawn)
            body = (np.minimum(page, drawn) < PAPER).any(2)
            mean, far = off[body].mean(), (off.max(2) > FAR)[body].mean()
            beside = np.hstack([page, drawn, np.minimum(4 * off, 255)]).astype(np.uint8)
            Image.fromarray(beside).save(os.path.join(run, f"beside-{colour}-{k}.png"))
            rows.append([name, colour, k, f"{body.mean():.1%}", f"{off.mean():.3f}", f"{mean:.2f}", f"{far:.2%}"])
            check(f"picture {name} {colour} state {k}", mean < 4 and far < 0.04, f"{mean:.2f} of 255, {far:.2%} far")


def picks(browser, run, states, wanted, rows, random):
    """Clicks on projected centres of the middle and the last state, before and after turning and enlarging."""
    left, top, width, height = browser.run(BOX)
    middle, origin = (left + width / 2, top + height / 2), np.array(browser.run("viewer.run.header.origin"))
    tried, hidden, missed = 0, 0, []
    browser.run(CLICKED)
    for turned in (False, True):
        if turned:
            browser.drag(middle, 3 * [(30, -15)], shift=browser.run("viewer.planar"))
            browser.mouse("mouseWheel", middle, False, deltaX=0, deltaY=-150)
        for k in (len(states) // 2, len(states) - 1):
            browser.keys("Home", *k * ["ArrowRight"])
            browser.run(AT_REST)
            axes, at, scale = browser.run("[viewer.camera.axes, viewer.camera.middle, viewer.camera.scale]")
            axes, shown, state = np.array(axes), origin + at, states[k]
            across = scale * (state["position"] - shown) @ axes[:2].T * [1, -1]
            pixels = np.round(across + [width / 2, height / 2]).astype(int)
            seen = ((pixels > 2) & (pixels < [width - 2, height - 2])).all(1)
            for i in random.permutation(np.flatnonzero(seen))[: wanted // 4]:
                x, y = map(int, pixels[i])
                browser.keys("Escape")
                browser.drag((left + x, top + y), [])
                # The middle of the sample that the page looked at, with one or two along a pixel.
                sample = np.array([x - width / 2, height / 2 - y]) + HALF / browser.run("window.samples")
                met = first_met(state, shown + sample @ axes[:2] / scale, axes[2])
                told = browser.run("document.querySelector('#picked h2')?.textContent ?? 'none'")
                expected = f"Body {state['id'][met]}" if met >= 0 else "none"
                tried, hidden = tried + 1, hidden + (met != i)
                missed += [f"state {k} at {x}, {y}: {told}, not {expected}"] * (told != expected)
    name = os.path.basename(run)
    rows.append([name, tried, hidden, tried - len(missed)])
    check(f"picks {name}", tried > 0 and not missed, f"{tried - len(missed)} of {tried} {'; '.join(missed[:4])}")


def sizes(browser, run, rows):
    """How large a page is, how long it takes to open, and a frame while the bodies turn."""
    page = os.path.join(run, "view.html")
    read, drawn, fine = np.median([browser.open(page) for _ in range(3)], axis=0)
    left, top, width, height = browser.run(BOX)
    browser.run(WATCH)
    browser.drag((left + width / 2, top + height / 2), [(12, 5)] * 6 + [(-12, -5)] * 6)
    frames = browser.run(f"{AT_REST}.then(() => window.coarse)")
    contacts = browser.run("viewer.run.states.map((state) => state.contacts?.count ?? -1)")
    rows.append([f"{browser.run('viewer.state.bodies'):,}", len(contacts), sum(n >= 0 for n in contacts), max(contacts),
                 f"{os.path.getsize(page) / 1e6:.2f} MB", *(f"{time / 1e3:.2f} s" for time in (read, drawn, fine)),
                 f"{np.median(frames):.0f} ms, {max(frames):.0f} ms at most of {len(frames)}"])


def table(heads, rows):
    print("\n| " + " | ".join(heads) + " |\n|" + " --- |" * len(heads))
    print("\n".join("| " + " | ".join(map(str, row)) + " |" for row in rows) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("folder")
    parser.add_argument("--browser", default="chromium")
    parser.add_argument("--sizes", default="512,16384,131072")
    parser.add_argument("--picks", type=int, default=40, help="clicks on each run")
    arguments = parser.parse_args()
    program, folder, random = arguments.program, arguments.folder, np.random.default_rng(1)
    os.makedirs(folder, exist_ok=True)
    browser = Browser(arguments.browser, folder)
    compared, picked, opened = [], [], []
    for name, (scene, colours, sets) in RUNS.items():
        run = make(program, folder, name, scene, sets)
        states = [dict(np.load(path)) for path in sorted(glob.glob(os.path.join(run, "states", "state_*.npz")))]
        browser.open(os.path.join(run, "view.html"))
        pictures(browser, program, run, colours, len(states), compared)
        picks(browser, run, states, arguments.picks, picked, random)
        browser.quiet(name)
    for count in filter(None, arguments.sizes.split(",")):
        run = make(program, folder, f"sizes-{count}", "compaction", [COUNT + count, *CHEAP])
        sizes(browser, run, opened)
        browser.quiet(os.path.basename(run))
    print("\n" + browser.version, browser.run("viewer.painter.gl.getParameter(37446)"), sep=", ")
    browser.close()
    table(["run", "colour", "state", "pixels with bodies", "mean off, all", "on bodies", f"by > {FAR}"], compared)
    table(["run", "clicks", "at a hidden centre", "right"], picked)
    table(["bodies", "states", "with contacts", "most", "file", "read", "first picture", "fine", "turning"], opened)
    sys.exit(1 if FAILED else 0)


if __name__ == "__main__":
    main()
