"""Uses the page of `relcp run --live` in headless Chromium as a user does, and compares its pictures with `relcp render`.

    check_browser.py PROGRAM FOLDER [--browser chromium] [--cells 1024]

PROGRAM is a relcp; FOLDER, which must not exist, gets the run and pictures of the page. Needs Python's own library and
Chromium, no package. A colony is watched until it has so many cells, paused, its growth rate is changed, it goes on, a
cell is dragged through the crowd with the mouse, one is placed and one removed, and the run is ended. Then the folder's
scene is run again, which must give the same bits, and the page of `relcp view` is compared with `relcp render` at three
times. Ends with status 1 where a check fails, 3 where there is no browser.
"""
import argparse
import base64
import json
import os
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
import time

FLAGS = ["--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-first-run",
         "--disable-background-networking", "--disable-dev-shm-usage", "--window-size=1000,700", "--hide-scrollbars",
         "--remote-debugging-port=0", "about:blank"]
SETS = ["time.dt=0.01", "growth.rate=2", "growth.reorientation_degrees=20", "growth.stop=null", "time.end=8",
        "output.every=0.5", "output.picture=false"]
SLOWER = "0.5"
LIVE = """new Promise((done, refuse) => { const look = () => {
  const busy = document.getElementById("busy");
  if (busy?.textContent.includes("cannot")) return refuse(busy.textContent);
  window.live ? done(true) : setTimeout(look, 5); }; look(); })"""
OPENED = LIVE.replace("window.live ?", "window.viewer ?")
AT_REST = """new Promise((done) => { const look = () => { const page = window.viewer;
  if (page.playing || page.drawing || !page.drawn_finely) { page.play(false); if (!page.drawing && !page.resting) page.request(); return setTimeout(look, 300); }
  done(true); }; look(); })"""
# The mean difference of the colours where either picture has a body, of 255, and how much of their bodies' pixels both
# have. White paper is above PAPER.
PAPER, MOST_OFF, LEAST_COMMON = 250, 6.0, 0.98
COMPARE = """(async () => {
  const read = async (data) => {
    const map = await createImageBitmap(await (await fetch(data)).blob());
    const canvas = new OffscreenCanvas(map.width, map.height), context = canvas.getContext("2d");
    context.drawImage(map, 0, 0);
    return context.getImageData(0, 0, map.width, map.height);
  };
  const [a, b] = [await read(%s), await read(%s)];
  if (a.width !== b.width || a.height !== b.height) return null;
  let sum = 0, either = 0, both = 0;
  for (let k = 0; k < a.data.length; k += 4) {
    const body = [a.data, b.data].map((of) => Math.min(of[k], of[k + 1], of[k + 2]) < %d);
    if (!body[0] && !body[1]) continue;
    either++;
    both += body[0] && body[1];
    for (let c = 0; c < 3; c++) sum += Math.abs(a.data[k + c] - b.data[k + c]) / 3;
  }
  return { off: sum / either, common: both / either, part: either / (a.width * a.height) };
})()"""
FAILED = []


def check(what, holds, said=""):
    print(f"{'ok  ' if holds else 'FAIL'} {what} {said}", flush=True)
    FAILED.extend([] if holds else [what])


class Socket:
    """A WebSocket of this computer (RFC 6455), as far as the DevTools protocol needs one."""

    def __init__(self, port, path):
        self.stream = socket.create_connection(("127.0.0.1", port), timeout=300)
        key = base64.b64encode(os.urandom(16)).decode()
        self.stream.sendall((f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                             f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n").encode())
        self.rest = b""
        while b"\r\n\r\n" not in self.rest:
            self.rest += self.stream.recv(4096)
        head, self.rest = self.rest.split(b"\r\n\r\n", 1)
        if b" 101 " not in head.split(b"\r\n")[0]:
            raise RuntimeError(head)

    def take(self, count):
        while len(self.rest) < count:
            part = self.stream.recv(1 << 20)
            if not part:
                raise RuntimeError("the browser has gone")
            self.rest += part
        taken, self.rest = self.rest[:count], self.rest[count:]
        return taken

    def send(self, text):
        data, mask = text.encode(), os.urandom(4)
        length = bytes([0x80 | len(data)]) if len(data) < 126 else b"\xfe" + struct.pack(">H", len(data)) \
            if len(data) < 1 << 16 else b"\xff" + struct.pack(">Q", len(data))
        whole = int.from_bytes(data, "big") ^ int.from_bytes((mask * (len(data) // 4 + 1))[:len(data)], "big")
        self.stream.sendall(b"\x81" + length + mask + whole.to_bytes(len(data), "big"))

    def receive(self):
        message = b""
        while True:
            first, second = self.take(2)
            length = second & 127
            if length > 125:
                length = int.from_bytes(self.take(2 if length == 126 else 8), "big")
            data = self.take(length)
            if first & 15 in (0, 1, 2):
                message += data
                if first & 128:
                    return message.decode()


class Browser:
    """A Chromium that is spoken to by the DevTools protocol."""

    def __init__(self, program):
        self.folder = tempfile.mkdtemp()
        command = [program, f"--user-data-dir={self.folder}", *FLAGS]
        self.process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        written = os.path.join(self.folder, "DevToolsActivePort")
        while not os.path.exists(written) or "/" not in open(written).read():
            if self.process.poll() is not None:
                raise RuntimeError("the browser does not start")
            time.sleep(0.1)
        port, path = open(written).read().split()
        self.socket, self.session, self.last, self.events = Socket(int(port), path), None, 0, []
        self.version = self.call("Browser.getVersion")["product"]
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def call(self, method, **parameters):
        self.last += 1
        session = {"sessionId": self.session} if self.session else {}
        self.socket.send(json.dumps({"id": self.last, "method": method, "params": parameters, **session}))
        while True:
            answer = json.loads(self.socket.receive())
            if answer.get("id") == self.last:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]
            self.events.append(answer)

    def run(self, script):
        answer = self.call("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(json.dumps(answer["exceptionDetails"])[:800])
        return answer["result"].get("value")

    def open(self, address, ready):
        self.call("Page.navigate", url=address)
        for _ in range(600):
            if self.run("document.readyState") == "complete" and self.run("location.href") == address.split("#")[0]:
                break
            time.sleep(0.05)
        return self.run(ready)

    def key(self, key):
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key)

    def mouse(self, kind, at, pressed):
        self.call("Input.dispatchMouseEvent", type=kind, x=at[0], y=at[1], clickCount=1, buttons=int(pressed), button="left")

    def until(self, condition, seconds=300):
        begun = time.monotonic()
        while time.monotonic() < begun + seconds:
            if self.run(condition):
                return True
            time.sleep(0.1)
        return False

    def quiet(self, name):
        said = [it["params"] for it in self.events if it.get("method") in
                ("Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded")]
        check(f"console {name}", not said, json.dumps(said)[:500])
        self.events.clear()

    def shot(self, path):
        data = self.call("Page.captureScreenshot", format="png")["data"]
        with open(path, "wb") as file:
            file.write(base64.b64decode(data))

    def close(self):
        try:
            self.session = None
            self.call("Browser.close")
            self.process.wait(30)
        except (OSError, RuntimeError, subprocess.TimeoutExpired):
            self.process.kill()
            self.process.wait()
        shutil.rmtree(self.folder, ignore_errors=True)


def place_of(browser, body):
    """Where a body's centre is on the page."""
    return browser.run(f"""(() => {{ const {{ canvas, camera, state }} = viewer, box = canvas.getBoundingClientRect();
      const from = plus(centreOf(state, {body}), camera.middle, -1);
      return [box.left + box.width / 2 + camera.scale * dot(from, camera.axes[0]),
        box.top + box.height / 2 - camera.scale * dot(from, camera.axes[1])]; }})()""")


def start(program, folder, sets):
    command = [program, "run", "colony", "--live", "--quiet", "--backend", "cpu", "--out", os.path.join(folder, "run")]
    run = subprocess.Popen(command + [word for each in sets for word in ("--set", each)], stderr=subprocess.PIPE, text=True)
    for line in run.stderr:
        if "http://" in line:
            return run, "http://" + line.split("http://")[1].strip()
    raise RuntimeError("no address")


def steer(browser, run, address, folder, cells):
    browser.open(address, LIVE)
    check("pauses at first", browser.run("live.status.phase") == "paused" and browser.run("viewer.state.step") == 0)
    browser.key("n")
    check("one step", browser.until("viewer.state.step === 1"))
    browser.key("p")
    check(f"grows to {cells} cells", browser.until(f"viewer.state.bodies >= {cells}"), str(browser.run("viewer.state.bodies")))
    browser.key("p")
    check("pauses", browser.until("live.status.phase === 'paused'"))
    time.sleep(0.5)
    kept = browser.run("viewer.run.states.length")
    browser.key("Home")
    check("scrubs", browser.run("viewer.state.step") == 0)
    browser.key("n")
    check("goes on meanwhile", browser.until(f"viewer.run.states.length > {kept}"))
    check("stays where it is", browser.run("viewer.state.step") == 0)
    browser.key("End")
    browser.run(f"""(() => {{ document.querySelector('#live details').open = true;
      const {{ input }} = live.rows.get('growth.rate'); input.value = '{SLOWER}';
      input.dispatchEvent(new Event('input')); document.querySelector('#live form button[type=submit]').click(); }})()""")
    check("a change", browser.until(f"live.status.changes === 1 && live.rows.get('growth.rate').text === '{SLOWER}'"),
          browser.run("live.fault.textContent"))
    browser.run("document.querySelector('#live details').open = false; document.activeElement.blur()")
    browser.run(AT_REST)
    browser.shot(os.path.join(folder, "1-changed.png"))
    hands(browser, folder)
    browser.run("live.finish.click()")
    check("ends", browser.until("live.status.phase === 'ended'"), browser.run("live.said.textContent"))
    check("the program ends", run.wait(120) == 0, run.stderr.read())
    asked = [it["params"]["request"]["url"] for it in browser.events if it.get("method") == "Network.requestWillBeSent"]
    check("network", asked and all(url.startswith(address) for url in asked))
    browser.quiet("of the live page")


def hands(browser, folder):
    """Drags the outermost cell through the middle while the run plays, then places one and removes one."""
    body = browser.run("""(() => { const far = (i) => Math.hypot(...plus(centreOf(viewer.state, i), viewer.camera.middle, -1));
      let most = 0; for (let i = 0; i < viewer.state.bodies; i++) if (far(i) > far(most)) most = i; return most; })()""")
    row, at = browser.run(f"viewer.state.list[{body}]"), place_of(browser, body)
    place = lambda: browser.run(f"(() => {{ const i = viewer.state.list.indexOf({row}); return i < 0 ? null : centreOf(viewer.state, i); }})()")
    before, changes = place(), browser.run("live.status.changes")
    box = browser.run("((box) => [box.left + box.width / 2, box.top + box.height / 2])(viewer.canvas.getBoundingClientRect())")
    beyond = [2 * middle - x for middle, x in zip(box, at)]
    # The crowd should not have doubled before the hand is through.
    browser.run("live.control({ do: 'speed', steps_a_second: 5 })")
    browser.key("b")
    browser.mouse("mousePressed", at, True)
    check("takes hold", browser.until(f"live.status.changes > {changes}"), browser.run("live.fault.textContent"))
    browser.run("live.control({ do: 'play' })")
    for part in range(1, 21):
        browser.mouse("mouseMoved", [x + (y - x) * part / 20 for x, y in zip(at, beyond)], True)
        time.sleep(0.15)
    # A busy machine takes fewer steps meanwhile: the hand stays until the cell has come some way, or has divided.
    browser.until(f"""(() => {{ const i = viewer.state.list.indexOf({row});
      return i < 0 || Math.hypot(...plus(centreOf(viewer.state, i), {before}, -1)) > 2.2 * viewer.painter.thickness; }})()""")
    browser.shot(os.path.join(folder, "2-dragged.png"))
    browser.run("live.control({ do: 'pause' })")
    browser.mouse("mouseReleased", beyond, False)
    check("lets go", browser.until("live.hands.held === null && live.status.phase === 'paused'"))
    browser.run("live.control({ do: 'speed', steps_a_second: null })")
    check("the pull is gone", browser.until("![...live.rows.keys()].some((key) => key.includes('.pull.'))"))
    after = place()
    moved = 0 if after is None else sum((x - y) ** 2 for x, y in zip(before, after)) ** 0.5
    width = browser.run("viewer.painter.thickness")
    check("the cell was dragged", after is None or moved > 2 * width, "it has divided" if after is None else f"by {moved / width:.1f} of its widths")
    bodies = browser.run("viewer.state.bodies")
    browser.run("live.hands.shape.value = 'rod'")
    browser.key("i")
    corner = browser.run("((box) => [box.left + 40, box.top + 60])(viewer.canvas.getBoundingClientRect())")
    browser.mouse("mousePressed", corner, True)
    browser.mouse("mouseReleased", corner, False)
    check("places a body", browser.until(f"viewer.state.bodies === {bodies + 1}"), browser.run("live.fault.textContent"))
    browser.key("v")
    browser.run("viewer.setPicked(viewer.state.list[3])")
    gone = browser.run("viewer.run.table.ids[viewer.picked]")
    browser.key("Delete")
    check("removes a body", browser.until(f"viewer.state.bodies === {bodies}"), browser.run("live.fault.textContent"))
    browser.key("n")
    check("it stays away", browser.until(f"[...viewer.state.list].every((row) => viewer.run.table.ids[row] !== {gone})"))
    browser.run(AT_REST)
    browser.shot(os.path.join(folder, "3-placed.png"))


def relcp(program, *arguments):
    done = subprocess.run([program, *arguments, "--quiet"], capture_output=True, text=True)
    check("relcp " + arguments[0], done.returncode == 0, done.stderr[-500:])


def again(program, folder):
    """The folder's scene, run from its start."""
    run, other = os.path.join(folder, "run"), os.path.join(folder, "again")
    relcp(program, "run", os.path.join(run, "scene.json"), "--backend", "cpu", "--out", other)
    hashes = [json.load(open(os.path.join(path, "summary.json")))["state_hash"] for path in (run, other)]
    check("the same bits again", hashes[0] == hashes[1], hashes[0])
    changes = json.load(open(os.path.join(run, "scene.json")))["changes"]
    kinds = [sorted(set(change) - {"at"}) for change in changes]
    check("changes of all kinds", ["set"] in kinds and ["remove"] in kinds and ["add"] in kinds, f"{len(changes)} changes")


def pictures(browser, program, folder):
    """The canvas of `relcp view` beside `relcp render` at three times."""
    run = os.path.join(folder, "run")
    relcp(program, "view", run, "--colour", "orientation")
    browser.open("file://" + os.path.abspath(os.path.join(run, "view.html")), OPENED)
    browser.run("viewer.setTheme('light')")
    width, height, count = browser.run("(viewer.draw(true), [viewer.canvas.width, viewer.canvas.height, viewer.run.states.length])")
    relcp(program, "render", run, "--out", os.path.join(run, "render"), "--size", f"{width}x{height}", "--colour", "orientation",
          "--bare", "--no-movie", "--backend", "cpu")
    pairs = []
    for k in (1, count // 2, count - 1):
        browser.key("Home")
        browser.run(f"viewer.show({k})")
        browser.run(AT_REST)
        drawn = open(os.path.join(run, "render", "frames", f"{k:06}.png"), "rb").read()
        pairs.append((k, browser.run("viewer.canvas.toDataURL('image/png')"), "data:image/png;base64," + base64.b64encode(drawn).decode()))
    browser.quiet("of the viewer")
    browser.open("about:blank", "true")
    for k, page, drawn in pairs:
        found = browser.run(COMPARE % (json.dumps(page), json.dumps(drawn), PAPER))
        holds = found is not None and found["off"] < MOST_OFF and found["common"] > LEAST_COMMON and found["part"] > 0
        said = found and f"{found['off']:.2f} of 255 off on bodies, {found['common']:.2%} of their pixels in both, {found['part']:.1%} of the picture"
        check(f"picture of state {k}", holds, said or "of another size")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("folder")
    parser.add_argument("--browser", default="chromium")
    parser.add_argument("--cells", type=int, default=1024)
    given = parser.parse_args()
    program = shutil.which(given.browser)
    if not program:
        print(f"SKIP: there is no {given.browser}")
        return 3
    os.makedirs(given.folder)
    run, address = start(given.program, given.folder, SETS)
    browser = Browser(program)
    try:
        steer(browser, run, address, given.folder, given.cells)
        again(given.program, given.folder)
        pictures(browser, given.program, given.folder)
    finally:
        run.kill()
        browser.close()
    print(browser.version)
    return 1 if FAILED else 0


if __name__ == "__main__":
    sys.exit(main())
