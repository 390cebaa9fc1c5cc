"""Opens the page of `relcp run --live` in headless Chromium and uses it: step, change a key, a bad value, play, scrub,
pause, end.

    check_live.py PROGRAM FOLDER [--browser chromium]

PROGRAM is a relcp; FOLDER, which must not exist, gets the run and pictures of the page. Needs what check_view.py needs.
Ends with status 1 where a check fails, 3 where a package is missing.
"""
import argparse
import base64
import json
import os
import subprocess
import time

from check_view import AT_REST, FAILED, Browser, check

SETS = ["time.dt=0.01", "growth.reorientation_degrees=20", "time.end=6", "output.forces=true"]
LIVE = """new Promise((done, refuse) => { const look = () => {
  const busy = document.getElementById("busy");
  if (busy?.textContent.includes("cannot")) return refuse(busy.textContent);
  window.live ? done(true) : setTimeout(look, 5); }; look(); })"""


def until(browser, condition, seconds=60):
    """Waits for a condition of the page."""
    begun = time.monotonic()
    while time.monotonic() < begun + seconds:
        if browser.run(condition):
            return True
        time.sleep(0.05)
    return False


def picture(browser, folder, name):
    browser.run(AT_REST)
    data = browser.call("Page.captureScreenshot", format="png")["data"]
    with open(os.path.join(folder, f"{name}.png"), "wb") as file:
        file.write(base64.b64decode(data))


def fill(browser, key, value):
    """Types a value into the field of a key and submits the form."""
    browser.run(f"""(() => {{ document.querySelector('#live details').open = true;
      const {{ input }} = live.rows.get({json.dumps(key)}); input.value = {json.dumps(value)};
      input.dispatchEvent(new Event('input')); document.querySelector('#live form button').click(); }})()""")


def start(program, folder):
    command = [program, "run", "colony", "--live", "--quiet", "--out", os.path.join(folder, "run")]
    for each in SETS:
        command += ["--set", each]
    run = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    for line in run.stderr:
        if "http://" in line:
            return run, "http://" + line.split("http://")[1].strip()
    raise RuntimeError("no address")


def use(browser, run, address, folder):
    speeds = {"latency": 0, "downloadThroughput": -1, "uploadThroughput": -1}
    browser.call("Network.emulateNetworkConditions", offline=False, **speeds)
    browser.call("Page.navigate", url=address)
    browser.run(LIVE)
    check("pauses at first", browser.run("live.status.phase") == "paused" and browser.run("viewer.state.step") == 0)
    picture(browser, folder, "1-start")
    browser.run("live.one.click()")
    check("one step", until(browser, "viewer.state.step === 1"))
    fill(browser, "growth.rate", "-3")
    check("a bad value", until(browser, "live.fault.textContent.includes('growth.rate')"), browser.run("live.fault.textContent"))
    picture(browser, folder, "2-refused")
    fill(browser, "growth.rate", "1.5")
    check("a change", until(browser, "live.status.changes === 1 && live.rows.get('growth.rate').text === '1.5'"))
    check("no fault is left", browser.run("live.fault.textContent") == "")
    browser.run("document.querySelector('#live details').open = false")
    browser.run("live.toggle.click()")
    check("plays", until(browser, "viewer.state.bodies >= 32"))
    picture(browser, folder, "3-plays")
    browser.run("document.activeElement.blur()")
    browser.keys("p")
    check("pauses", until(browser, "live.status.phase === 'paused'"))
    time.sleep(0.5)
    kept = browser.run("viewer.run.states.length")
    browser.keys("Home")
    check("scrubs", browser.run("viewer.state.step") == 0)
    browser.keys("n")
    check("goes on meanwhile", until(browser, f"viewer.run.states.length === {kept + 1}"))
    check("stays where it is", browser.run("viewer.state.step") == 0)
    browser.keys("End")
    browser.run("viewer.setColour(viewer.run.header.quantities.findIndex((q) => q.name === 'pressure'))")
    browser.run("viewer.setPicked(viewer.state.list[3])")
    picture(browser, folder, "4-pressure")
    check("contacts", browser.run("viewer.state.contacts.count > 10"))
    rows = browser.run("[...viewer.state.list].map((row) => viewer.run.table.ids[row])")
    check("each body once", len(set(rows)) == len(rows) > 30)
    browser.run("live.finish.click()")
    check("ends", until(browser, "live.status.phase === 'ended'"), browser.run("live.said.textContent"))
    check("the program ends", run.wait(30) == 0, run.stderr.read())
    picture(browser, folder, "5-ended")
    said = [it["params"] for it in browser.events if it.get("method") in
            ("Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded")]
    # Chromium notes each refused request.
    said = [it for it in said if "status of 400" not in json.dumps(it)]
    check("console", not said, json.dumps(said)[:500])
    asked = [it["params"]["request"]["url"] for it in browser.events if it.get("method") == "Network.requestWillBeSent"]
    check("network", asked and all(url.startswith(address) for url in asked))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("folder")
    parser.add_argument("--browser", default="chromium")
    given = parser.parse_args()
    os.makedirs(given.folder)
    run, address = start(given.program, given.folder)
    browser = Browser(given.browser, given.folder)
    try:
        use(browser, run, address, given.folder)
    finally:
        run.kill()
        browser.close()
    return 1 if FAILED else 0


if __name__ == "__main__":
    raise SystemExit(main())
