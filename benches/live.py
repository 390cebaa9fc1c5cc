"""What a live run costs and withstands, and how fast its page and the viewer are. Prints Markdown tables.

    live.py PROGRAM FOLDER [--parts cost,large,hostile,open] [--turns 8] [--bodies 131072] [--browser chromium]

PROGRAM is a relcp, FOLDER is made for its runs. Needs Python's own library, and Chromium for `hostile` and `open`.
"""
import argparse
import json
import os
import resource
import socket
import statistics
import subprocess
import sys
import threading
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "tests", "readers"))
from check_browser import LIVE, OPENED, Browser  # noqa: E402

PLAY = b'{"do": "play"}'
SCENES = {
    "colony to 512 cells": ["colony", "--set", "time.dt=0.01", "--set", "growth.reorientation_degrees=20", "--set", "growth.rate=2",
                            "--set", "growth.stop={\"population\": 512}", "--set", "time.end=6", "--set", "output.picture=false"],
    "1,000 ellipsoids, 150 steps": ["compaction", "--set", "generate.0.isotropic.count=1000", "--set", "time.end=1.5",
                                    "--set", "time.dt=0.01", "--set", "output.picture=false"],
}


def large(bodies, steps, every):
    return ["compaction", "--set", f"generate.0.isotropic.count={bodies}", "--set", "generate.0.isotropic.volume_fraction=0.2",
            "--set", "time.dt=0.05", "--set", f"time.end={0.05 * steps}", "--set", f"output.every={every}", "--set",
            "contact.overlap_tolerance=0.01", "--set", "output.picture=false"]


class Live:
    """A live run, and requests to it."""

    def __init__(self, program, folder, scene):
        command = [program, "run", *scene, "--live", "--quiet", "--backend", "cpu", "--out", folder]
        self.process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        for line in self.process.stderr:
            if "http://" in line:
                self.address = "http://" + line.split("http://")[1].strip()
                break
        else:
            raise RuntimeError("no address")
        threading.Thread(target=self.process.stderr.read, daemon=True).start()
        host, self.token = self.address[7:].strip("/").split("/")
        self.port = int(host.split(":")[1])

    def connect(self):
        return socket.create_connection(("127.0.0.1", self.port), timeout=120)

    def raw(self, head, body=b""):
        """The status and the body of the answer to these bytes; none where the connection ends without one."""
        stream = self.connect()
        try:
            stream.sendall(head.encode())
            for start in range(0, len(body), 1 << 20):
                stream.sendall(body[start:start + (1 << 20)])
        except OSError:
            pass  # it has answered before the body was there
        parts = []
        try:
            while part := stream.recv(1 << 20):
                parts.append(part)
        except OSError:
            pass
        stream.close()
        whole = b"".join(parts)
        if not whole.startswith(b"HTTP/1.1 "):
            return None, b""
        return int(whole[9:12]), whole.split(b"\r\n\r\n", 1)[1]

    def get(self, place, host=None, more="", method="GET", token=None):
        host = host or f"127.0.0.1:{self.port}"
        return self.raw(f"{method} /{token or self.token}/{place} HTTP/1.1\r\nHost: {host}\r\n{more}\r\n")

    def post(self, place, body, kind="application/json"):
        return self.raw(f"POST /{self.token}/{place} HTTP/1.1\r\nHost: 127.0.0.1:{self.port}\r\nContent-Type: {kind}\r\n"
                        f"Content-Length: {len(body)}\r\n\r\n", body)

    def status(self):
        return json.loads(self.get("status")[1])

    def watch(self, until=lambda: False):
        """Takes every state as a page does: how many there were, and their bytes."""
        step, version, states, size = None, 0, 0, 0
        while not until():
            has = "" if step is None else f"&step={step}"
            try:
                code, body = self.get(f"next?version={version}{has}")
            except OSError:
                break
            if code != 200:
                break
            length = int.from_bytes(body[:4], "little")
            told = json.loads(body[4:4 + length])
            version = told["status"]["version"]
            if told["state"]:
                rest = body[4 + length:]
                header = json.loads(rest[4:4 + int.from_bytes(rest[:4], "little")])
                step, states, size = header["states"][0]["step"], states + 1, size + len(rest)
            if told["status"]["phase"] == "ended":
                break
        return states, size

    def end(self):
        self.process.wait()


def table(heads, rows):
    print("\n| " + " | ".join(heads) + " |\n|" + " --- |" * len(heads))
    print("\n".join("| " + " | ".join(map(str, row)) + " |" for row in rows) + "\n", flush=True)


def used(process):
    """The processor time of a process that ends now."""
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return usage.ru_utime + usage.ru_stime


def cost(program, folder, turns):
    rows = []
    for name, scene in SCENES.items():
        times, states = {"plain": [], "live": [], "watched": []}, []
        for turn in range(turns):
            for kind in times:
                out = os.path.join(folder, f"{name[:6].strip()}-{kind}-{turn}")
                if kind == "plain":
                    command = [program, "run", *scene, "--quiet", "--backend", "cpu", "--out", out]
                    times[kind].append(used(subprocess.Popen(command, stderr=subprocess.DEVNULL)))
                    continue
                live = Live(program, out, scene)
                live.post("control", PLAY)
                if kind == "watched":
                    states.append(live.watch()[0])
                times[kind].append(used(live.process))
        plain = statistics.median(times["plain"])
        of = lambda kind: statistics.median(times[kind])
        # Of turns beside each other.
        off = lambda kind: statistics.median(b / a - 1 for a, b in zip(times["plain"], times[kind]))
        spread = statistics.stdev(times["plain"]) / plain if turns > 1 else 0
        rows.append([name, f"{plain:.2f} s", f"{of('live'):.2f} s, {off('live'):+.1%}", f"{of('watched'):.2f} s, {off('watched'):+.1%}",
                     f"{statistics.median(states):.0f}", f"{spread:.1%}"])
    table(["run", "plain", "live, no page", "live, every state taken", "states taken", "scatter of plain"], rows)


def many(program, folder, bodies):
    live = Live(program, os.path.join(folder, "large"), large(bodies, 12, 1))
    live.post("control", PLAY)
    begun = time.monotonic()
    states, size = live.watch()
    wall = time.monotonic() - begun
    live.end()
    table(["bodies", "states taken", "time", "states a second", "bytes a state"],
          [[f"{bodies:,}", states, f"{wall:.0f} s", f"{states / wall:.2f}", f"{size / max(states, 1) / 1e6:.2f} MB"]])


def hostile(program, folder, browser_name):
    rows = []
    scene = ["colony", "--set", "time.dt=0.01", "--set", "time.end=8", "--set", "growth.stop={\"population\": 128}", "--set", "output.picture=false"]
    live = Live(program, os.path.join(folder, "hostile"), scene)
    told = lambda what, answer: rows.append([what, answer])
    code = lambda answer: "closed" if answer[0] is None else str(answer[0])
    told("foreign Host", code(live.get("status", host="example.org")))
    told("foreign Origin", code(live.get("status", more="Origin: http://example.org\r\n")))
    told("wrong token", code(live.get("status", token="0" * 32)))
    told("path ../../etc/passwd", code(live.get("../../etc/passwd")))
    told("method DELETE", code(live.get("status", method="DELETE")))
    told("a form of another page", code(live.post("control", PLAY, "text/plain")))
    head = f"POST /{live.token}/control HTTP/1.1\r\nHost: 127.0.0.1:{live.port}\r\nContent-Type: application/json\r\n"
    before = memory(live)
    told("a body of 1 GB", code(live.raw(head + f"Content-Length: {1 << 30}\r\n\r\n", bytes(1 << 30))))
    told("memory of the run after it", f"{before / 1e6:.0f} MB, then {memory(live) / 1e6:.0f} MB")
    begun = time.monotonic()
    answer = live.raw(head + "Content-Length: 100\r\n\r\n{")
    told("half a request", f"{code(answer)} after {time.monotonic() - begun:.1f} s")
    resource.setrlimit(resource.RLIMIT_NOFILE, (4096, resource.getrlimit(resource.RLIMIT_NOFILE)[1]))
    held = [live.connect() for _ in range(1000)]
    begun = time.monotonic()
    answers = [live.get("status")[0] for _ in range(20)]
    told("1,000 idle connections, then 20 requests", f"{answers.count(200)} answered, {(time.monotonic() - begun) / 20 * 1e3:.1f} ms each")
    for stream in held:
        stream.close()
    browser = Browser(browser_name)
    browser.open(live.address, LIVE)
    live.post("control", b'{"do": "speed", "steps_a_second": 20}')
    live.post("control", PLAY)
    browser.until("viewer.state.step > 20")
    browser.process.kill()
    time.sleep(1)
    first = live.status()
    time.sleep(1)
    later = live.status()["phase"]
    live.post("control", b'{"do": "speed", "steps_a_second": null}')
    told("kill -9 of the browser", f"the run is {first['phase']}, then {later}; it ends with status {live.process.wait()}")
    told("kill -9 of the run, after it was steered", killed(program, folder, scene))
    table(["what", "answer"], rows)


def memory(live):
    with open(f"/proc/{live.process.pid}/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize()


def killed(program, folder, scene):
    out = os.path.join(folder, "killed")
    live = Live(program, out, scene)
    live.post("control", b'{"do": "step", "steps": 200}')
    while live.status()["phase"] != "paused":
        time.sleep(0.05)
    live.post("hand", b'{"body": 0, "target": [5, 5, 0]}')
    live.post("change", b'{"growth.rate": 1.5}')
    live.post("control", b'{"do": "step", "steps": 50}')
    time.sleep(0.2)
    live.process.kill()
    live.process.wait()
    quiet = ["--quiet", "--backend", "cpu"]
    subprocess.run([program, "run", "--resume", "--out", out, *quiet], check=True)
    subprocess.run([program, "run", os.path.join(out, "scene.json"), "--out", out + "-again", *quiet], check=True)
    hashes = [json.load(open(os.path.join(path, "summary.json")))["state_hash"] for path in (out, out + "-again")]
    return "resumed to the bits of the scene run again" if hashes[0] == hashes[1] else f"other bits: {hashes}"


def spent(root):
    """The processor time of a process and all below it so far, on Linux."""
    parents, times = {}, {}
    for name in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{name}/stat") as file:
                fields = file.read().rsplit(")", 1)[1].split()
        except OSError:
            continue  # it has ended
        parents[int(name)], times[int(name)] = int(fields[1]), int(fields[11]) + int(fields[12])

    def is_below(process):
        while process in parents and process != root:
            process = parents[process]
        return process == root
    return sum(time for process, time in times.items() if is_below(process)) / os.sysconf("SC_CLK_TCK")


def opened(program, folder, bodies, browser_name):
    rows = []
    for count in (512, 16384, bodies):
        out = os.path.join(folder, f"open-{count}")
        if not os.path.exists(os.path.join(out, "summary.json")):
            subprocess.run([program, "run", *large(count, 19, 0.05), "--quiet", "--backend", "cpu", "--out", out], check=True)
        subprocess.run([program, "view", out, "--quiet"], check=True)
        page = os.path.join(out, "view.html")
        browser = Browser(browser_name)
        found = []
        for _ in range(3):
            begun = spent(browser.process.pid)
            browser.open("file://" + os.path.abspath(page), OPENED)
            found.append([*browser.run("[viewer.opened.read, viewer.opened.drawn]"), spent(browser.process.pid) - begun])
            states = browser.run("viewer.run.states.length")
            browser.open("about:blank", "true")
        read, drawn, processor = (statistics.median(of) for of in zip(*found))
        size = os.path.getsize(page) / 1e6
        rows.append([f"{count:,}", states, f"{size:.2f} MB", f"{read / 1e3:.2f} s", f"{drawn / 1e3:.2f} s", f"{processor:.2f} s"])
        version = browser.version
        browser.close()
    table(["bodies", "states", "file", "read", "first picture", "processor time"], rows)
    print(version)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("folder")
    parser.add_argument("--parts", default="cost,large,hostile,open")
    parser.add_argument("--turns", type=int, default=8)
    parser.add_argument("--bodies", type=int, default=131072)
    parser.add_argument("--browser", default="chromium")
    given = parser.parse_args()
    os.makedirs(given.folder, exist_ok=True)
    for part in given.parts.split(","):
        print(f"## {part}", flush=True)
        if part == "cost":
            cost(given.program, given.folder, given.turns)
        elif part == "large":
            many(given.program, given.folder, given.bodies)
        elif part == "hostile":
            hostile(given.program, given.folder, given.browser)
        elif part == "open":
            opened(given.program, given.folder, given.bodies, given.browser)


if __name__ == "__main__":
    main()
