// Recomputes a landing for another strike: the jump of each body is M s + a, with M (6 × 3) and a (6) from the analysis.
"use strict";
(() => {
  const byId = (id) => document.getElementById(id);
  const data = JSON.parse(byId("data").textContent);
  const radians = Math.PI / 180, view = byId("view"), inputs = ["angle", "heading", "speed"];
  const shown = { bodies: byId("bodies"), marks: byId("marks"), axes: byId("axes"), through: byId("through") };
  let landing, geometry, model, result;

  // Vectors
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const norm = (a) => Math.hypot(...a);
  const sum = (a, b, k = 1) => a.map((x, i) => x + k * b[i]);
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const times = (M, v) => M.map((row) => dot(row, v));
  const transposed = (M) => [0, 1, 2].map((k) => M.map((row) => row[k]));
  const inWorld = (body, r) => sum(landing.position[body], times(landing.rotation[body], r));
  const vertex = (n) => [0, 1, 2].map((k) => geometry.vertices[3 * n + k]);
  const velocityOf = (one, s) => (one.follows ? sum(s, one.extra) : one.extra);
  const velocityAt = (jump, r) => sum(jump.v, cross(jump.omega, r));

  function decoded(text, type) {
    const letters = atob(text), bytes = new Uint8Array(letters.length);
    for (let k = 0; k < letters.length; k++) bytes[k] = letters.charCodeAt(k);
    return new type(bytes.buffer);
  }

  // The vertices of all bodies in their frames, the triangles, and the body of each vertex.
  for (const one of data.geometries) {
    const corners = decoded(one.triangles, one.wide ? Uint32Array : Uint16Array);
    one.vertices = decoded(one.vertices, Float32Array);
    one.corners = [0, 1, 2].map((k) => Uint32Array.from({ length: corners.length / 3 }, (_, n) => corners[3 * n + k]));
    one.body = new Uint16Array(one.vertices.length / 3);
    one.starts.forEach((start, body) => one.body.fill(body, start));
  }

  function choose(number) {
    landing = data.landings[number];
    geometry = data.geometries[landing.geometry];
    const world = [0, 1, 2].map(() => new Float32Array(geometry.body.length));
    geometry.body.forEach((body, n) => {
      const p = inWorld(body, vertex(n));
      world.forEach((axis, k) => { axis[n] = p[k]; });
    });
    const all = world.map((axis, k) => [...axis, ...landing.position.map((p) => p[k])]);
    const low = all.map((axis) => axis.reduce((a, b) => Math.min(a, b))), high = all.map((axis) => axis.reduce((a, b) => Math.max(a, b)));
    const sides = sum(high, low, -1);
    Object.assign(landing, { world, high, sides, middle: sum(low, high).map((x) => x / 2), size: Math.max(...sides) });
    byId("landing").value = number;
    for (const option of byId("model").options) option.disabled = !landing.models[option.value];
    for (const part of document.querySelectorAll("[data-landing]")) part.hidden = part.dataset.landing !== String(number);
    for (const table of [byId("body-rows"), byId("point-rows")]) table.tBodies[0].replaceChildren();
    reset();
  }

  function reset() {
    const v = landing.velocity, [f, l, u] = ["forward", "left", "up"].map((name) => dot(v, landing[name]));
    const backward = f < -1e-9 * norm(v), heading = Math.hypot(f, l) > 1e-9 * norm(v) ? Math.atan2(l, f) / radians : 0;
    const angle = Math.atan2(Math.hypot(f, l), -u) / radians;
    const turned = backward ? heading - 180 * Math.sign(heading || 1) : heading;
    setInputs({ angle: backward ? -angle : angle, heading: turned, speed: norm(v), model: "as modelled" });
  }

  function setInputs(values) {
    for (const name of inputs) {
      if (name in values) byId(name).value = byId(`${name}-range`).value = Number(Number(values[name]).toFixed(9));
    }
    if ("model" in values && landing.models[values.model]) byId("model").value = values.model;
    update();
  }

  function strike() {
    const [angle, heading, speed] = inputs.map((name) => byId(name).valueAsNumber);
    const level = sum(landing.forward.map((x) => x * Math.cos(heading * radians)), landing.left, Math.sin(heading * radians));
    return sum(level.map((x) => x * Math.sin(angle * radians)), landing.up, -Math.cos(angle * radians)).map((x) => x * speed);
  }

  // All numbers of the strike and the joint model that are set; without an impact they are NaN.
  function computed() {
    const s = strike(), { jumps: maps, left } = landing.models[byId("model").value];
    const along = (row) => dot(row, s) + row[3], fastest = Math.max(...landing.contacts.map((one) => norm(velocityOf(one, s))));
    const parting = landing.contacts.find((one) => !(dot(velocityOf(one, s), one.normal) < -1e-9 * norm(velocityOf(one, s))));
    const leaving = parting ? `${parting.name} does not approach the ground: there is no impact` :
      left.some((row) => !(Math.abs(along(row)) <= 1e-6 * fastest)) ? "the mechanism or other contacts prevent that a contact is " +
        "stopped for this strike: no verdict" : "";
    const v_in = leaving ? NaN : Math.max(...landing.reference.map((one) => norm(velocityOf(one, s))));
    const jumps = maps.map((M) => {
      const jump = M.map(along);
      return { omega: jump.slice(0, 3), v: jump.slice(3) };
    });
    const shock = Float32Array.from(geometry.body, (body, n) => norm(velocityAt(jumps[body], vertex(n))) / v_in);
    const least = jumps.map(() => Infinity), greatest = jumps.map(() => NaN);
    shock.forEach((value, n) => {
      const body = geometry.body[n];
      least[body] = Math.min(least[body], value);
      if (!(greatest[body] >= value)) greatest[body] = value;
    });
    const bodies = jumps.map((jump, body) => {
      const normal = times(transposed(landing.rotation[body]), landing.normal), turn = dot(jump.omega, normal);
      const floor = landing.rounded * Math.max(v_in, norm(jump.v)) / landing.length;
      const copc = Math.abs(turn) > floor ? cross(normal, jump.v).map((x) => x / turn) : null;
      const spin = norm(jump.omega), screw = spin > floor ? cross(jump.omega, jump.v).map((x) => x / spin ** 2) : null;
      const ropc = copc ? v_in / Math.abs(turn) : Infinity;
      return { spin, copc, screw, ropc, com: norm(velocityAt(jump, landing.com[body])) / v_in,
        least: greatest[body] >= 0 ? least[body] : NaN, greatest: greatest[body] };
    });
    const points = landing.points.map((point) => {
      const delta = point.body < 0 ? [0, 0, 0] : times(transposed(point.axes), velocityAt(jumps[point.body], point.r));
      const moved = leaving ? delta.map(() => NaN) : delta;
      return { delta: moved, shock: norm(moved) / v_in, peak: norm(moved) * landing.peak };
    });
    return { s, leaving, v_in, jumps, shock, bodies, points };
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
    while (body.rows.length < rows.length) {
      const row = body.insertRow();
      row.dataset.k = body.rows.length - 1;
      rows[row.dataset.k].forEach(() => row.insertCell());
    }
    for (const row of body.rows) {
      rows[row.dataset.k].forEach((value, k) => {
        const cell = row.cells[k], number = typeof value === "number";
        cell.textContent = number ? rounded(value) : value;
        if (number) cell.dataset.v = value;
        else cell.className = "name";
      });
    }
  }

  // The picture
  const vector = (v) => ({ x: v[0], y: v[1], z: v[2] });
  const positions = (points) => Object.fromEntries(["x", "y", "z"].map((axis, k) => [axis, points.map((p) => p && p[k])]));
  const marks = (points, more) => ({ type: "scatter3d", mode: "markers", hoverinfo: "none", ...positions(points), ...more });

  function traces() {
    const size = landing.size, { s, bodies } = result, tall = landing.high[2] + 0.06 * size;
    const near = (p) => p && norm(sum(p, landing.middle, -1)) < 1.1 * size;
    const through = shown.through.checked, [x, y, z] = landing.world, [i, j, k] = geometry.corners;
    const body = { type: "mesh3d", x, y, z, i, j, k, intensity: result.leaving ? new Float32Array(x.length) : result.shock,
      cmin: 0, cmax: data.limit, colorscale: data.scale, showscale: false, hoverinfo: "none", flatshading: true,
      opacity: result.leaving ? 0.1 : through ? 0.4 : 1, visible: shown.bodies.checked,
      // In the axes of the camera; what faces the viewer has the colours of the bands.
      lighting: { ambient: 0.62, diffuse: 0.45, specular: 0.02, roughness: 0.9, facenormalsepsilon: 0 },
      lightposition: { x: 2e4, y: 1e5, z: -1e4 } };
    const arrows = landing.contacts.flatMap((one) => {
      const v = velocityOf(one, s), long = size / (result.v_in || norm(v));
      return [sum(one.point, v, -0.36 * long), sum(one.point, v, -0.12 * long), null];
    });
    const tips = landing.contacts.map((one) => velocityOf(one, s)), ends = landing.contacts.map((one, n) =>
      sum(one.point, tips[n], -0.06 * size / (result.v_in || norm(tips[n]))));
    const pins = landing.points.flatMap((one) => [one.position, [one.position[0], one.position[1], tall], null]);
    const centres = landing.numbered.filter((b) => bodies[b].copc).map((b) => [b, inWorld(b, bodies[b].copc)]).filter(([, p]) => near(p));
    const screws = landing.numbered.filter((b) => bodies[b].screw).flatMap((b) => {
      const axis = times(landing.rotation[b], result.jumps[b].omega).map((a) => a / bodies[b].spin), q = inWorld(b, bodies[b].screw);
      const p = sum(q, axis, dot(axis, sum(inWorld(b, landing.com[b]), q, -1)));
      return near(p) ? [sum(p, axis, -0.2 * size), sum(p, axis, 0.2 * size), null] : [];
    });
    const ink = data.ink, visible = shown.marks.checked;
    return [
      body,
      marks(arrows, { mode: "lines", line: { color: ink, width: 6 }, visible }),
      { type: "cone", ...positions(ends), ...Object.fromEntries(["u", "v", "w"].map((axis, n) =>
        [axis, tips.map((v) => v[n] / norm(v))])), anchor: "tip", sizemode: "absolute", sizeref: 0.09 * size, showscale: false,
        colorscale: [[0, ink], [1, ink]], hoverinfo: "none", visible },
      marks(pins, { mode: "lines", line: { color: data.gold, width: 4 }, visible }),
      marks(landing.points.map((one) => one.position), { marker: { symbol: "diamond", size: 5, color: data.gold,
        line: { color: ink, width: 1 } }, visible }),
      marks(landing.points.map((one) => [one.position[0], one.position[1], tall]), { mode: "text", text: landing.points.map((one) =>
        one.letter), textfont: { size: 15, color: ink }, visible }),
      marks(centres.map(([, p]) => p), { mode: "markers+text", text: centres.map(([b]) => String(landing.numbered.indexOf(b) + 1)),
        textposition: "top center", textfont: { color: ink }, marker: { symbol: "cross", size: 5, color: ink }, visible:
        shown.axes.checked }),
      marks(screws, { mode: "lines", line: { color: data.screw, width: 4 }, visible: shown.axes.checked }),
    ];
  }

  // From the side of the first contact, at a distance that shows the whole robot.
  function eye() {
    const struck = sum(landing.contacts[0].point, landing.middle, -1), side = dot(struck, landing.normal) < 0 ? -1 : 1;
    const way = [0, 1, 2].map((k) => side * landing.normal[k] + 0.6 * landing.e1[k] + 0.35 * landing.e2[k]);
    const distance = 0.74 * landing.size / Math.cbrt(landing.sides.reduce((a, b) => a * Math.max(b, 0.1 * landing.size), 1));
    return way.map((x) => distance * x / norm(way));
  }

  function draw() {
    const axis = (name) => ({ title: { text: `${name} [m]` }, backgroundcolor: "#fff", gridcolor: "#ddd", zerolinecolor: "#ccc",
      showspikes: false });
    const scene = { aspectmode: "data", xaxis: axis("x"), yaxis: axis("y"), zaxis: axis("z"),
      camera: { eye: vector(eye()), up: vector(landing.e2), center: vector([0, 0, 0]), projection: { type: "orthographic" } } };
    const layout = { scene, showlegend: false, margin: { l: 0, r: 0, t: 0, b: 0 }, uirevision: String(landing.name), hovermode: "closest" };
    return Plotly.react(view, traces(), layout, { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["resetCameraLastSave3d"] });
  }

  function update() {
    result = computed();
    const { bodies, points, leaving, v_in } = result;
    byId("state").textContent = leaving ||
      `shock is relative to ${rounded(v_in)} m/s; ${byId("model").value === "as modelled" ? "joints as modelled" :
        `joints ${byId("model").value}`}`;
    byId("state").classList.toggle("refused", Boolean(leaving));
    fill(byId("point-rows"), points.map((one, k) => [landing.points[k].letter, landing.points[k].name, one.shock, ...one.delta,
      ...(landing.peak === null ? [] : [one.peak])]));
    fill(byId("body-rows"), bodies.map((one, k) => {
      const number = landing.numbered.indexOf(k), copc = leaving || !one.copc ? [NaN, NaN, NaN] : one.copc;
      return [number < 0 ? "" : String(number + 1), landing.bodies[k], one.com, one.least, one.greatest, leaving ? NaN : one.spin,
        ...copc, leaving ? NaN : one.ropc];
    }));
    return draw();
  }

  function follow(event) {
    const { curveNumber, pointNumber } = event.points[0];
    if (curveNumber !== 0) return;
    const body = geometry.body[pointNumber], r = vertex(pointNumber);
    const place = r.map((x) => x.toFixed(4)).join(", "), delta = norm(velocityAt(result.jumps[body], r));
    byId("pointer").textContent = result.leaving ? "" :
      `${landing.bodies[body]} at (${place}) m in its frame: shock ${rounded(delta / result.v_in)}, |Δv| ${rounded(delta)} m/s`;
  }

  // A chart of histories for each landing on contacts of finite stiffness; names become texts that Plotly does not interpret.
  const plain = (text) => text.replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll("$", "&#36;");
  data.landings.forEach((one, number) => {
    for (const [k, chart] of (one.histories || []).entries()) {
      const lines = chart.lines.map((line) => ({ x: chart.time, y: line.values, name: plain(line.name), mode: "lines" }));
      const title = (text) => ({ title: { text } });
      Plotly.newPlot(byId(`history-${number}-${k}`), lines, { xaxis: title("time from the first contact [ms]"), yaxis:
        title(chart.title), showlegend: true, margin: { t: 16, r: 16 }, height: 300 }, { responsive: true, displaylogo: false });
    }
  });

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
  byId("model").addEventListener("input", soon);
  byId("reset").addEventListener("click", reset);
  byId("landing").addEventListener("input", (event) => choose(Number(event.target.value)));
  for (const box of Object.values(shown)) box.addEventListener("input", soon);
  choose(0);
  view.on("plotly_hover", follow);
})();
