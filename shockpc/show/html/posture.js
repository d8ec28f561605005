// Sliders of the posture of a landing, of its contact, masses and sensors; code of the landing computes what they change.
"use strict";
// Args: panel, the element that has them; changed, what is called when one moves.
function postureOf(panel, changed) {
  let rows, landing, compute;
  const DEGREE = Math.PI / 180, IDENTITY = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
  const TITLES = { joint: "posture", tilt: "base", contact: "contact point", mass: "masses", point: "places of sensors" };
  const product = (A, B) => A.map((row) => [0, 1, 2].map((k) => row[0] * B[0][k] + row[1] * B[1][k] + row[2] * B[2][k]));
  const transposed = (A) => [0, 1, 2].map((i) => A.map((row) => row[i]));
  const times = (A, v) => A.map((row) => row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);
  const matrix = (out, k) => [0, 3, 6].map((i) => [out[k + i], out[k + i + 1], out[k + i + 2]]);
  const of = (kind) => rows.filter((row) => row.kind === kind).map((row) => row.x);

  // The rotation by an angle about an axis.
  function turn([x, y, z], angle) {
    const c = Math.cos(angle), s = Math.sin(angle), K = [[0, -z, y], [z, 0, -x], [-y, x, 0]];
    return product(IDENTITY, IDENTITY).map((row, i) => row.map((e, k) => e * c + s * K[i][k] + (1 - c) * [x, y, z][i] * [x, y, z][k]));
  }

  // A box shows a number rounded, and stands for all of its digits until it is changed.
  function add(group, slider) {
    const scale = slider.unit === "rad" ? DEGREE : 1, shown = Number((slider.value / scale).toPrecision(5));
    const row = { ...slider, x: slider.value }, label = document.createElement("label"), name = document.createElement("span");
    const [range, box] = ["range", "number"].map((type) => Object.assign(document.createElement("input"), { type, step: "any" }));
    name.textContent = `${slider.name} [${slider.unit === "rad" ? "deg" : slider.unit}]`;
    [range.min, range.max] = [slider.low / scale, slider.high / scale];
    const set = (value) => { row.x = value === shown ? slider.value : value * scale; changed(); };
    range.addEventListener("input", () => { box.value = Number(range.valueAsNumber.toPrecision(5)); set(range.valueAsNumber); });
    box.addEventListener("input", () => { if (Number.isFinite(box.valueAsNumber)) { range.value = box.value; set(box.valueAsNumber); } });
    row.reset = () => { row.x = slider.value; box.value = range.value = shown; };
    row.reset();
    label.append(name, range, box);
    group.append(label);
    rows.push(row);
  }

  function show(next, code) {
    [rows, landing, compute] = [[], next, code];
    panel.replaceChildren();
    panel.hidden = !landing.sliders;
    for (const [kind, title] of Object.entries(TITLES)) {
      const sliders = (landing.sliders ?? []).filter((slider) => slider.kind === kind);
      if (!sliders.length) continue;
      const group = Object.assign(document.createElement("details"), { open: kind === "joint" || kind === "tilt" });
      group.append(Object.assign(document.createElement("summary"), { textContent: title }));
      panel.append(group);
      sliders.forEach((slider) => add(group, slider));
    }
  }

  // What the program of the landing gives for a strike (3,), world axes, with the rotation of the base.
  function landed(strike) {
    const [pitch, roll] = of("tilt"), T = product(turn(landing.left, pitch ?? 0), turn(landing.forward, roll ?? 0)), back = transposed(T);
    const nb = landing.bodies.length, nc = landing.grounds.length, nj = landing.joints.length;
    const out = new Float64Array(18 * nb + 3 * nc + 7 * nj + 1), count = (n) => Array.from({ length: n }, (_, k) => k);
    compute([...of("joint"), ...of("contact"), ...of("mass")], times(back, strike), T.flat(), out);
    const part = (start, width, n) => count(n).map((k) => Array.from(out.subarray(start + width * k, start + width * (k + 1))));
    return {
      rotation: count(nb).map((k) => product(T, matrix(out, 9 * k))),
      position: part(9 * nb, 3, nb).map((p) => times(T, p).map((x, k) => x + landing.origin[k])),
      jumps: part(12 * nb, 6, nb),
      contacts: part(18 * nb, 3, nc).map((impulse) => times(T, impulse)),
      loads: part(18 * nb + 3 * nc, 7, nj),
      condition: out[out.length - 1],
    };
  }

  return {
    show, landed,
    sliders: () => rows,
    // Whether the landing is another one than the scene's; sensors do not change it.
    moved: () => rows.some((row) => row.kind !== "point" && row.x !== row.value),
    changed: () => rows.some((row) => row.x !== row.value),
    point: (k, r) => { const x = rows.filter((row) => row.point === k).map((row) => row.x); return x.length ? x : r; },
    contact: (k, r) => { const x = of("contact"); return k === 0 && x.length ? x : r; },
    reset: () => rows.forEach((row) => row.reset()),
  };
}
