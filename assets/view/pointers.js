"use strict";
// Mouse, pen and fingers on the picture.

/** A press that moves less than so many pixels is a click. */
const STILL = 4;

function listenToPointers(viewer, canvas) {
  const down = new Map();
  let moved = 0;
  let hand = null;
  const at = (event) => [event.clientX - canvas.getBoundingClientRect().left, event.clientY - canvas.getBoundingClientRect().top];
  const fromMiddle = ([x, y]) => [x - canvas.clientWidth / 2, y - canvas.clientHeight / 2];

  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    canvas.focus({ preventScroll: true });
    if (!down.size && event.button === 0 && !event.shiftKey && viewer.hands?.press(at(event))) hand = event.pointerId;
    if (!down.size) moved = 0;
    down.set(event.pointerId, at(event));
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = down.get(event.pointerId);
    if (!before) return;
    const now = at(event);
    const [right, below] = [now[0] - before[0], now[1] - before[1]];
    moved += Math.abs(right) + Math.abs(below);
    if (down.size === 2) pinch(before, now, event.pointerId);
    else if (hand === event.pointerId) viewer.hands.move(now);
    else if (down.size === 1 && moved >= STILL) drag(event, right, below);
    down.set(event.pointerId, now);
  });
  const release = (event) => {
    const known = down.delete(event.pointerId);
    if (hand === event.pointerId) {
      hand = null;
      viewer.hands.release();
      return;
    }
    if (known && event.type === "pointerup" && moved < STILL && event.button === 0 && !down.size) viewer.pickAt(...at(event));
  };
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", release);
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const pixels = event.deltaY * (event.deltaMode === 1 ? 16 : event.deltaMode === 2 ? 400 : 1);
    viewer.camera.zoom(Math.exp(-pixels / 500), ...fromMiddle(at(event)));
    viewer.request();
  }, { passive: false });

  function drag(event, right, below) {
    const other = event.shiftKey || (event.buttons & 6) !== 0;
    if (other === viewer.planar) return viewer.turn(right, below);
    viewer.camera.pan(right, below);
    return viewer.request();
  }

  /** Two fingers: their distance enlarges, their middle moves. */
  function pinch(before, now, id) {
    const other = [...down].find(([key]) => key !== id)[1];
    const far = (p) => Math.max(Math.hypot(p[0] - other[0], p[1] - other[1]), 1);
    const middle = fromMiddle([(now[0] + other[0]) / 2, (now[1] + other[1]) / 2]);
    viewer.camera.pan((now[0] - before[0]) / 2, (now[1] - before[1]) / 2);
    viewer.camera.zoom(far(now) / far(before), ...middle);
    viewer.request();
  }
}
