// Recomputes a landing for another strike: the jump of each body is M s + a, with M (6 × 3) and a (6) from the analysis.
"use strict";
(() => {
  const byId = (id) => document.getElementById(id);
  const data = JSON.parse(byId("data").textContent), radians = Math.PI / 180, view = byId("view");
  const inputs = ["angle", "heading", "speed"], switches = ["bodies", "through", "marks", "axes"];
  let landing, geometry, result;

  // Vectors
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const norm = (a) => Math.hypot(...a);
  const sum = (a, b, k = 1) => a.map((x, i) => x + k * b[i]);
  const scaled = (a, k) => a.map((x) => k * x);
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const times = (M, v) => M.map((row) => dot(row, v));
  const inWorld = (body, r) => sum(landing.position[body], times(landing.rotation[body], r));
  const vertex = (n) => Array.from(geometry.vertices.subarray(3 * n, 3 * n + 3));
  const approach = (motion, s) => (motion.follows ? sum(s, motion.extra) : motion.extra);
  const velocityAt = (jump, r) => sum(jump.v, cross(jump.omega, r));

  // The vertices of all bodies in their frames, the corners of the triangles, and the body of each vertex.
  const decoded = (text, type) => new type(Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer);
  for (const robot of data.geometries) {
    const corners = decoded(robot.triangles, robot.wide ? Uint32Array : Uint16Array);
    robot.vertices = decoded(robot.vertices, Float32Array);
    robot.corners = [0, 1, 2].map((k) => corners.filter((_, n) => n % 3 === k));
    robot.body = new Uint16Array(robot.vertices.length / 3);
    robot.starts.forEach((start, body) => robot.body.fill(body, start));
  }

  function choose(number) {
    landing = data.landings[number];
    geometry = data.geometries[landing.geometry];
    const points = Array.from(geometry.body, (body, n) => inWorld(body, vertex(n)));
    const bound = (extreme, from) => [...points, ...landing.position].reduce((a, p) => a.map((x, k) => extreme(x, p[k])), from);
    const low = bound(Math.min, [Infinity, Infinity, Infinity]), high = bound(Math.max, [-Infinity, -Infinity, -Infinity]);
    const sides = sum(high, low, -1);
    Object.assign(landing, { world: columns(points), sides, top: high[2], middle: scaled(sum(low, high), 0.5), size: Math.max(...sides) });
    byId("landing").value = number;
    for (const option of byId("model").options) option.disabled = !landing.models[option.value];
    for (const part of document.querySelectorAll("[data-landing]")) part.hidden = part.dataset.landing !== String(number);
    for (const name of ["body-rows", "point-rows", "contact-rows", "joint-rows"]) byId(name).tBodies[0].replaceChildren();
    reset();
  }

  function reset() {
    inputs.forEach((name, k) => { byId(name).value = byId(`${name}-range`).value = landing.strike[k]; });
    byId("model").value = "as modelled";
    update();
  }

  // All numbers of the strike and the joint model that are set; without an impact they are NaN.
  function computed() {
    const [theta, psi, speed] = inputs.map((name, k) => byId(name).valueAsNumber * (k < 2 ? radians : 1));
    const level = sum(scaled(landing.forward, Math.cos(psi)), landing.left, Math.sin(psi));
    const s = scaled(sum(scaled(level, Math.sin(theta)), landing.up, -Math.cos(theta)), speed);
    const model = landing.models[byId("model").value], along = (row) => dot(row, s) + row[3];
    const speeds = landing.contacts.map((contact) => norm(approach(contact, s))), fastest = Math.max(...speeds);
    const parting = landing.contacts.find((contact, k) => !(dot(approach(contact, s), contact.normal) < -1e-9 * speeds[k]));
    const refusal = parting ? `${parting.name} does not approach the ground: there is no impact` :
      model.left.every((row) => Math.abs(along(row)) <= 1e-6 * fastest) ? "" :
        "the mechanism or other contacts prevent that a contact is stopped for this strike: no verdict";
    const v_in = refusal ? NaN : Math.max(...landing.reference.map((motion) => norm(approach(motion, s))));
    const jumps = model.jumps.map((M) => M.map((row) => (refusal ? NaN : along(row)))).map((jump) =>
      ({ omega: jump.slice(0, 3), v: jump.slice(3) }));
    const shock = Float32Array.from(geometry.body, (body, n) => norm(velocityAt(jumps[body], vertex(n))) / v_in);
    const extreme = (body, choice) => shock.subarray(geometry.starts[body], geometry.starts[body + 1]).reduce((a, b) =>
      (Number.isNaN(a) ? b : choice(a, b)), NaN);
    const bodies = jumps.map((jump, body) => {
      const turn = dot(jump.omega, landing.normals[body]), spin = norm(jump.omega);
      const floor = landing.rounded * Math.max(v_in, norm(jump.v)) / landing.length;
      return { spin, com: norm(velocityAt(jump, landing.com[body])) / v_in,
        least: extreme(body, Math.min), greatest: extreme(body, Math.max),
        copc: Math.abs(turn) > floor ? scaled(cross(landing.normals[body], jump.v), 1 / turn) : null,
        ropc: Math.abs(turn) <= floor ? Infinity : v_in / Math.abs(turn),
        screw: spin > floor ? scaled(cross(jump.omega, jump.v), 1 / spin ** 2) : null };
    });
    const points = landing.points.map((point) => {
      const delta = point.body < 0 ? [0, 0, 0] : times(point.axes, velocityAt(jumps[point.body], point.r));
      return { delta, shock: norm(delta) / v_in, peak: norm(delta) * landing.peak };
    });
    const impulses = (parts) => parts.map((rows) => rows.map((row) => (refusal || !row ? NaN : along(row))));
    return { s, refusal, v_in, fastest, jumps, shock, bodies, points, contacts: impulses(model.contacts), loads: impulses(model.loads) };
  }

  // Tables
  function rounded(x) {
    if (Number.isNaN(x)) return "–";
    if (!Number.isFinite(x)) return "inf";
    if (Math.abs(x) < 1e-12) return "0";
    const power = Number(x.toExponential(3).split("e")[1]);
    return Math.abs(power) <= 3 ? x.toFixed(Math.min(4, 3 - power)) : x.toExponential(2);
  }

  function fill(table, rows) {
    const body = table.tBodies[0];
    rows.slice(body.rows.length).forEach((cells) => {
      const row = body.insertRow();
      row.dataset.k = body.rows.length - 1;
      cells.forEach((value) => { row.insertCell().className = typeof value === "number" ? "" : "name"; });
    });
    for (const row of body.rows) {
      rows[row.dataset.k].forEach((value, k) => {
        row.cells[k].textContent = typeof value === "number" ? rounded(value) : value;
        if (typeof value === "number") row.cells[k].dataset.v = value;
      });
    }
  }

  // The picture
  const columns = (points) => [0, 1, 2].map((k) => points.map((p) => p && p[k]));
  const named = (names, values) => Object.fromEntries(names.map((name, k) => [name, values[k]]));
  const xyz = (points) => named(["x", "y", "z"], columns(points));
  const scatter = (points, visible, more) => ({ type: "scatter3d", hoverinfo: "none", visible, ...xyz(points), ...more });
  const lines = (pairs, visible, color, width) => scatter(pairs.flatMap(([a, b]) => [a, b, null]), visible, { mode: "lines", line:
    { color, width } });

  function traces() {
    const { s, refusal, shock, bodies, jumps } = result, { ink, gold } = data, { size, middle, numbered, points } = landing;
    const [solid, through, marks, axes] = switches.map((name) => byId(name).checked);
    const near = (p) => norm(sum(p, middle, -1)) < 1.1 * size, above = (p) => [p[0], p[1], landing.top + 0.06 * size];
    const before = landing.contacts.map((contact) => scaled(approach(contact, s), 1 / result.fastest));
    const tail = (share) => landing.contacts.map((contact, k) => sum(contact.point, before[k], -share * size));
    const places = points.map((point) => point.position), letters = points.map((point) => point.letter), starts = tail(0.36), ends = tail(0.12);
    const centres = numbered.map((b, k) => [String(k + 1), bodies[b].copc && inWorld(b, bodies[b].copc)]).filter(([, p]) => p && near(p));
    const screws = numbered.filter((b) => bodies[b].screw).map((b) => {
      const axis = times(landing.rotation[b], scaled(jumps[b].omega, 1 / bodies[b].spin)), q = inWorld(b, bodies[b].screw);
      return [sum(q, axis, dot(axis, sum(inWorld(b, landing.com[b]), q, -1))), axis];
    }).filter(([p]) => near(p)).map(([p, axis]) => [sum(p, axis, -0.2 * size), sum(p, axis, 0.2 * size)]);
    return [
      { type: "mesh3d", ...named(["x", "y", "z"], landing.world), ...named(["i", "j", "k"], geometry.corners), visible: solid,
        intensity: refusal ? shock.map(() => 0) : shock, cmin: 0, cmax: data.limit, colorscale: data.scale, showscale: false,
        hoverinfo: "none", flatshading: true, opacity: refusal ? 0.1 : through ? 0.4 : 1,
        // In the axes of the camera; what faces the viewer has the colours of the bands.
        lighting: { ambient: 0.62, diffuse: 0.45, specular: 0.02, roughness: 0.9, facenormalsepsilon: 0 },
        lightposition: { x: 2e4, y: 1e5, z: -1e4 } },
      lines(starts.map((p, k) => [p, ends[k]]), marks, ink, 6),
      { type: "cone", ...xyz(tail(0.06)), ...named(["u", "v", "w"], columns(before.map((v) => scaled(v, 1 / norm(v))))), anchor: "tip",
        sizemode: "absolute", sizeref: 0.09 * size, showscale: false, colorscale: [[0, ink], [1, ink]], hoverinfo: "none", visible: marks },
      lines(places.map((p) => [p, above(p)]), marks, gold, 4),
      scatter(places, marks, { mode: "markers", marker: { symbol: "diamond", size: 5, color: gold, line: { color: ink, width: 1 } } }),
      scatter(places.map(above), marks, { mode: "text", text: letters, textfont: { size: 15, color: ink } }),
      scatter(centres.map(([, p]) => p), axes, { mode: "markers+text", text: centres.map(([text]) => text), textposition: "top center",
        textfont: { color: ink }, marker: { symbol: "cross", size: 5, color: ink } }),
      lines(screws, axes, data.screw, 4),
    ];
  }

  // From the side of the first contact, at a distance that shows the whole robot.
  function eye() {
    const { normal, e1, e2, size, sides } = landing;
    const side = dot(sum(landing.contacts[0].point, landing.middle, -1), normal) < 0 ? -1 : 1;
    const way = sum(sum(scaled(normal, side), e1, 0.6), e2, 0.35);
    return scaled(way, 0.74 * size / norm(way) / Math.cbrt(sides.reduce((a, b) => a * Math.max(b, 0.1 * size), 1)));
  }

  function update() {
    result = computed();
    const { bodies, points, refusal, v_in } = result, model = byId("model").value;
    const joints = model === "as modelled" ? "joints as modelled" : `joints ${model}`;
    byId("state").textContent = refusal || `shock is relative to ${rounded(v_in)} m/s; ${joints}`;
    byId("state").classList.toggle("refused", Boolean(refusal));
    fill(byId("point-rows"), points.map((point, k) => [landing.points[k].letter, landing.points[k].name, point.shock, ...point.delta,
      ...(landing.peak === null ? [] : [point.peak])]));
    fill(byId("body-rows"), bodies.map((body, k) => [String(landing.numbered.indexOf(k) + 1 || ""), landing.bodies[k], body.com,
      body.least, body.greatest, body.spin, ...(body.copc ?? [NaN, NaN, NaN]), body.ropc]));
    fill(byId("contact-rows"), landing.grounds.map(({ name, normal }, k) => {
      const impulse = result.contacts[k], up = dot(impulse, normal);
      return ["", name, ...impulse, up > 0 ? norm(sum(impulse, normal, -up)) / up : NaN];
    }));
    fill(byId("joint-rows"), result.loads.map((load, k) => ["", landing.joints[k], load[0], norm(load.slice(1, 4)), norm(load.slice(4))]));
    const axis = (name) => ({ title: { text: `${name} [m]` }, backgroundcolor: "#fff", gridcolor: "#ddd", zerolinecolor: "#ccc",
      showspikes: false });
    const vector = (v) => named(["x", "y", "z"], v), camera = { eye: vector(eye()), up: vector(landing.e2), center: vector([0, 0, 0]),
      projection: { type: "orthographic" } };
    Plotly.react(view, traces(), { scene: { aspectmode: "data", xaxis: axis("x"), yaxis: axis("y"), zaxis: axis("z"), camera },
      showlegend: false, margin: { l: 0, r: 0, t: 0, b: 0 }, uirevision: landing.name, hovermode: "closest" },
    { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["resetCameraLastSave3d"] });
  }

  function follow({ points: [{ curveNumber, pointNumber }] }) {
    if (curveNumber !== 0 || result.refusal) return;
    const body = geometry.body[pointNumber], r = vertex(pointNumber), delta = norm(velocityAt(result.jumps[body], r));
    byId("pointer").textContent = `${landing.bodies[body]} at (${r.map((x) => x.toFixed(4)).join(", ")}) m in its frame: shock ` +
      `${rounded(delta / result.v_in)}, |Δv| ${rounded(delta)} m/s`;
  }

  // A chart of histories for each landing on contacts of finite stiffness; names become texts that Plotly does not interpret.
  const plain = (text) => text.replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll("$", "&#36;");
  const title = (text) => ({ title: { text } });
  data.landings.forEach(({ histories }, number) => histories.forEach(({ title: quantity, time, lines: curves }, k) => {
    const drawn = curves.map(({ name, values }) => ({ x: time, y: values, name: plain(name), mode: "lines" }));
    Plotly.newPlot(byId(`history-${number}-${k}`), drawn, { xaxis: title("time from the first contact [ms]"), yaxis: title(quantity),
      showlegend: true, margin: { t: 16, r: 16 }, height: 300 }, { responsive: true, displaylogo: false });
  }));

  let waiting = false;
  const soon = () => {
    if (!waiting) requestAnimationFrame(() => { waiting = false; update(); });
    waiting = true;
  };
  for (const name of inputs) {
    const [box, range] = [byId(name), byId(`${name}-range`)];
    range.addEventListener("input", () => { box.value = range.value; soon(); });
    box.addEventListener("input", () => { if (Number.isFinite(box.valueAsNumber)) { range.value = box.value; soon(); } });
  }
  for (const name of ["model", ...switches]) byId(name).addEventListener("input", soon);
  byId("reset").addEventListener("click", reset);
  byId("landing").addEventListener("input", (event) => choose(Number(event.target.value)));
  choose(0);
  view.on("plotly_hover", follow);
})();
