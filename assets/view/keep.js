"use strict";
// What is kept of the page: a picture, a movie, and a link with camera, time, colour and pick.

/** Bits of a movie's second; a colony of 1,024 cells at 1080 lines stays sharp. */
const MOVIE_BITS = 12e6;
/** Milliseconds for which a movie holds its last state. */
const MOVIE_HOLDS = 1500;
const DIGITS = 7;

/** The picture with its words: time, scale bar and legend, as large as they are on the page. */
function composed(viewer, canvas = document.createElement("canvas")) {
  const from = viewer.canvas;
  const ratio = from.width / from.clientWidth;
  if (canvas.width !== from.width || canvas.height !== from.height) [canvas.width, canvas.height] = [from.width, from.height];
  const context = canvas.getContext("2d");
  context.drawImage(from, 0, 0);
  const style = getComputedStyle(document.documentElement);
  const [ink, paper] = ["--ink", "--paper"].map((name) => style.getPropertyValue(name));
  context.save();
  context.scale(ratio, ratio);
  context.font = "14px system-ui, sans-serif";
  context.textBaseline = "top";
  const plate = (x, y, width, height) => {
    context.globalAlpha = 0.75;
    context.fillStyle = paper;
    context.fillRect(x, y, width, height);
    context.globalAlpha = 1;
    context.fillStyle = ink;
  };
  const words = byId("caption").textContent;
  plate(12, 8, context.measureText(words).width + 12, 22);
  context.fillText(words, 18, 12);
  const [width, height] = [from.clientWidth, from.clientHeight];
  const bar = parseFloat(byId("bar").style.width) || 0;
  context.fillRect(16, height - 18, bar, 2);
  context.fillText(byId("bar").textContent.trim(), 16, height - 38);
  const by_group = viewer.run.header.quantities[viewer.colour].name === "group" && viewer.run.header.groups.length > 0;
  if (!byId("legend").hidden) (by_group ? drawnGroups : drawnLegend)(context, { width, height, plate, ink });
  context.restore();
  return canvas;
}

/** The groups with their colours, in the lower right corner. */
function drawnGroups(context, { width, height, plate, ink }) {
  const all = [...byId("groups").children].map((button) => [button.firstElementChild.style.background, button.textContent]);
  const wide = Math.max(...all.map(([, name]) => context.measureText(name).width)) + 36;
  plate(width - 16 - wide, height - 24 - 20 * all.length, wide, 20 * all.length + 8);
  all.forEach(([colour, name], k) => {
    const y = height - 20 - 20 * (all.length - k);
    context.fillStyle = colour;
    context.fillRect(width - 8 - wide, y, 12, 12);
    context.fillStyle = ink;
    context.fillText(name, width + 10 - wide, y - 1);
  });
}

function drawnLegend(context, { width, height, plate, ink }) {
  const [x, wide] = [width - 16 - 240, 240];
  const [name, low, high] = ["legend-name", "legend-low", "legend-high"].map((id) => byId(id).textContent);
  plate(x, height - 74, wide, 58);
  context.textAlign = "center";
  context.fillText(name, x + wide / 2, height - 70);
  context.textAlign = "left";
  const scale = byId("legend-scale");
  if (scale.hidden) return;
  context.fillText(low, x + 8, height - 52);
  context.textAlign = "right";
  context.fillText(high, x + wide - 8, height - 52);
  context.textAlign = "left";
  context.drawImage(scale, x + 8, height - 34, wide - 16, 10);
  context.strokeStyle = ink;
  context.strokeRect(x + 8, height - 34, wide - 16, 10);
}

function saveAs(blob, name) {
  const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

function savePicture(viewer) {
  viewer.draw(true);
  const name = `${viewer.run.header.name}-${viewer.state.step}.png`;
  return new Promise((done) => composed(viewer).toBlob((blob) => { saveAs(blob, name); done(blob); }, "image/png"));
}

/** Plays the run once from the start at the chosen speed, and saves what is seen. */
async function saveMovie(viewer) {
  const kind = ["video/mp4", "video/webm"].find((type) => window.MediaRecorder?.isTypeSupported(type));
  if (!kind || !viewer.canvas.captureStream) throw new Error("this browser records no movies; `relcp render --movie` makes one");
  const canvas = composed(viewer);
  const stream = canvas.captureStream(30);
  const recorder = new MediaRecorder(stream, { mimeType: kind, videoBitsPerSecond: MOVIE_BITS });
  const parts = [];
  recorder.addEventListener("dataavailable", (event) => parts.push(event.data));
  const stopped = new Promise((done) => recorder.addEventListener("stop", done, { once: true }));
  recorder.start();
  viewer.play(false);
  const each = 1000 / Number(byId("speed").value);
  for (let k = 0; k < viewer.run.states.length; k++) {
    const begun = performance.now();
    viewer.show(k);
    viewer.draw(true);
    composed(viewer, canvas);
    const holds = k === viewer.run.states.length - 1 ? MOVIE_HOLDS : each;
    await new Promise((go) => setTimeout(go, Math.max(holds - (performance.now() - begun), 0)));
  }
  recorder.stop();
  await stopped;
  stream.getTracks().forEach((track) => track.stop());
  const blob = new Blob(parts, { type: kind });
  saveAs(blob, `${viewer.run.header.name}.${kind.slice(6)}`);
  return blob;
}

/** The part of the address after `#` that shows the same picture again. */
function linkOf(viewer) {
  const { camera, run, state, canvas } = viewer;
  const numbers = (list) => list.map((x) => Number(x.toPrecision(DIGITS))).join(",");
  const said = {
    t: numbers([state.time]), colour: run.header.quantities[viewer.colour].name,
    camera: numbers([...camera.axes.flat(), ...plus(camera.middle, run.header.origin), canvas.clientHeight / camera.scale]),
    show: Object.keys(OVERLAYS).concat(["walls", "perspective", "haze"]).filter((name) => viewer.shows[name]).join(","),
  };
  if (viewer.picked >= 0) said.pick = String(run.table.ids[viewer.picked]);
  if (viewer.cut_part < 1) said.cut = String(viewer.cut_part);
  if (viewer.hidden.size) said.hidden = [...viewer.hidden].join(",");
  return `#${new URLSearchParams(said).toString().replaceAll("%2C", ",")}`;
}

/** Shows what a link says; whether it said anything. */
function follow(viewer, link) {
  const said = new URLSearchParams(link.replace(/^#/, ""));
  const number = (name) => (said.has(name) && said.get(name) !== "" && Number.isFinite(Number(said.get(name))) ? Number(said.get(name)) : null);
  const { run } = viewer;
  const colour = run.header.quantities.findIndex(({ name, missing }) => name === said.get("colour") && missing === null);
  if (colour >= 0) viewer.setColour(colour);
  if (said.has("show")) {
    const shown = new Set(said.get("show").split(","));
    for (const name of Object.keys(viewer.shows)) if (name !== "shadows") viewer.setShown(name, shown.has(name));
  }
  if (said.has("hidden")) said.get("hidden").split(",").forEach((group) => viewer.hide(Number(group), true));
  if (number("cut") !== null && !viewer.planar) viewer.setCut(number("cut"));
  const parts = (said.get("camera") ?? "").split(",").map(Number);
  const is_turn = [0, 3, 6].every((k) => Math.abs(Math.hypot(...parts.slice(k, k + 3)) - 1) < 1e-3);
  if (parts.length === 13 && parts.every(Number.isFinite) && is_turn && parts[12] > 0) {
    viewer.camera.axes = [0, 3, 6].map((k) => parts.slice(k, k + 3));
    viewer.camera.middle = plus(parts.slice(9, 12), run.header.origin, -1);
    viewer.camera.scale = viewer.canvas.clientHeight / parts[12];
    byId("view").value = "";
  }
  if (number("t") !== null) viewer.showNearest(number("t"));
  const row = run.table.rows.get(number("pick"));
  if (row !== undefined) viewer.setPicked(row);
  viewer.request();
  return number("t") !== null;
}
