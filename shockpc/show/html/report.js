// Recomputes a landing for another strike: the jump of each body is M s + a, with M (6 × 3) and a (6) from the analysis.
"use strict";
(() => {
  const byId = (id) => document.getElementById(id), data = JSON.parse(byId("data").textContent);
  const inputs = ["angle", "heading", "speed"], switches = ["bodies", "through", "marks", "axes"];
  let landing, geometry, result;

  let waiting = 0;
  const soon = () => { waiting ||= requestAnimationFrame(() => { waiting = 0; update(); }); };
  const posture = postureOf(byId("posture"), soon);

  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const norm = (a) => Math.hypot(...a);
  const sum = (a, b, k = 1) => a.map((x, i) => x + k * b[i]);
  const scaled = (a, k) => a.map((x) => k * x);
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const times = (M, v) => M.map((row) => dot(row, v));
  const columns = (points) => [0, 1, 2].map((k) => points.map((p) => p && p[k]));
  const inWorld = (body, r) => sum(result.position[body], times(result.rotation[body], r));
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
    byId("landing").value = number;
    for (const option of byId("model").options) option.disabled = !landing.models[option.value];
    for (const part of document.querySelectorAll("[data-landing]")) part.hidden = part.dataset.landing !== String(number);
    for (const table of document.querySelectorAll("main table")) table.tBodies[0].replaceChildren();
    posture.show(landing, postures[number]);
    reset();
  }

  // The vertices of all bodies in the world.
  function surfaces({ rotation, position }) {
    const world = [0, 1, 2].map(() => new Float32Array(geometry.body.length)), { body, vertices } = geometry;
    for (let n = 0; n < body.length; n++) {
      const R = rotation[body[n]], p = position[body[n]], x = vertices[3 * n], y = vertices[3 * n + 1], z = vertices[3 * n + 2];
      for (let k = 0; k < 3; k++) world[k][n] = p[k] + R[k][0] * x + R[k][1] * y + R[k][2] * z;
    }
    return world;
  }

  // The strike of the scene as its boxes show it, which stand for all of its digits.
  const shown = (x) => Number(x.toPrecision(5));
  const typed = (name, k) => {
    const x = byId(name).valueAsNumber;
    return x === shown(landing.strike[k]) ? landing.strike[k] : x;
  };

  function reset() {
    inputs.forEach((name, k) => { byId(name).value = byId(`${name}-range`).value = shown(landing.strike[k]); });
    byId("model").value = "with drives";
    posture.reset();
    update();
  }

  // Whether more is left along the rows that depend on others than rounding leaves, as the analysis decides it.
  function contradicts(model, strike) {
    if (!model.left.length) return false;
    const along = (row) => row.reduce((total, x, k) => total + x * strike[k], 0);
    const length = Math.sqrt(Math.max(0, along(model.motion.map(along)))), fastest = Math.max(...model.speeds.map(along).map(Math.abs));
    return model.left.some((row, k) => Math.abs(along(row)) > data.contradiction * fastest + model.rounding[k] * length);
  }

  // The share of a body's motion that is out of the plane, as the analysis defines it; of a body at rest nothing.
  function offPlane(body, normal, jump, v_in) {
    const gyration = landing.gyration[body], moved = velocityAt(jump, landing.com[body]);
    const tilting = gyration * norm(sum(jump.omega, normal, -dot(jump.omega, normal)));
    const size = Math.max(gyration * norm(jump.omega), norm(moved));
    return size > landing.rounded * v_in ? Math.max(tilting, Math.abs(dot(moved, normal))) / size : 0;
  }

  // All numbers of the strike, the joint model and the posture that are set; without an impact they are NaN.
  function computed() {
    const [theta, psi, speed] = inputs.map((name, k) => typed(name, k) * (k < 2 ? Math.PI / 180 : 1));
    const level = sum(scaled(landing.forward, Math.cos(psi)), landing.left, Math.sin(psi));
    const s = scaled(sum(scaled(level, Math.sin(theta)), landing.up, -Math.cos(theta)), speed);
    const model = landing.models[byId("model").value], along = (row) => dot(row, s) + row[3];
    const before = landing.contacts.map((contact) => approach(contact, s)), fastest = Math.max(...before.map(norm));
    // A contact may slide while another one strikes.
    const leaving = before.map((v, k) => dot(v, landing.contacts[k].normal)), rounding = 1e-9 * fastest;
    const noneStrikes = !leaving.some((away) => away < -rounding);
    const parting = landing.contacts.find((_, k) => !(leaving[k] <= rounding) || (noneStrikes && !(leaving[k] < -rounding)));
    const values = (rows) => rows.map((row) => (row ? along(row) : NaN));
    const now = posture.moved() ? posture.landed(s) : {
      rotation: landing.rotation, position: landing.position, condition: 0,
      jumps: model.jumps.map(values), contacts: model.contacts.map(values), loads: model.loads.map(values),
    };
    const refusal = inputs.some((name) => !Number.isFinite(byId(name).valueAsNumber)) ?
      "give an angle, a heading and a speed: without them there is no contact velocity" :
      warnings.refused(posture.sliders()) ? warnings.refused(posture.sliders()) : parting ? `${parting.name} does not approach the ground: there is no impact` :
      !(now.condition < data.singular) ? "the posture is singular, or nearly: no verdict" :
        posture.moved() || !contradicts(model, [...s, 1]) ? "" :
          "no verdict: the mechanism or other contacts prevent that a contact is stopped for this velocity";
    const known = (rows) => (refusal ? rows.map((row) => row.map(() => NaN)) : rows);
    const v_in = refusal ? NaN : Math.max(...landing.reference.map((motion) => norm(approach(motion, s))));
    const jumps = known(now.jumps).map((jump) => ({ omega: jump.slice(0, 3), v: jump.slice(3) }));
    const shock = Float32Array.from(geometry.body, (body, n) => norm(velocityAt(jumps[body], vertex(n))) / v_in);
    const extreme = (body, choice) => shock.subarray(geometry.starts[body], geometry.starts[body + 1]).reduce((a, b) =>
      (Number.isNaN(a) ? b : choice(a, b)), NaN);
    const bodies = jumps.map((jump, body) => {
      const normal = columns(now.rotation[body]).map((column) => dot(column, landing.normal));
      const turn = dot(jump.omega, normal), spin = norm(jump.omega);
      const floor = landing.rounded * Math.max(v_in, norm(jump.v)) / landing.length;
      return { spin, com: norm(velocityAt(jump, landing.com[body])) / v_in,
        least: extreme(body, Math.min), greatest: extreme(body, Math.max),
        mostly: offPlane(body, normal, jump, v_in) > data.bracketed,
        copc: Math.abs(turn) > floor ? scaled(cross(normal, jump.v), 1 / turn) : null,
        ropc: Math.abs(turn) <= floor ? Infinity : v_in / Math.abs(turn),
        screw: spin > floor ? scaled(cross(jump.omega, jump.v), 1 / spin ** 2) : null };
    });
    const points = landing.points.map(({ r }, k) => posture.point(k, r));
    const deltas = landing.points.map(({ body, axes }, k) => (body < 0 ? [0, 0, 0] : times(axes, velocityAt(jumps[body], points[k]))));
    return { ...now, refusal, v_in, jumps, shock, bodies, points, deltas, before: before.map((v) => scaled(v, 1 / fastest)),
      contacts: known(now.contacts), loads: known(now.loads) };
  }

  function rounded(x) {
    if (!Number.isFinite(x)) return Number.isNaN(x) ? "–" : "inf";
    if (Math.abs(x) < 1e-12) return "0";
    const power = Number(x.toExponential(3).split("e")[1]);
    return Math.abs(power) <= 3 ? x.toFixed(Math.min(4, 3 - power)) : x.toExponential(2);
  }

  // A table that is sorted stays so: each of its rows knows its number.
  function fill(table, rows) {
    table.parentElement.hidden = !rows.length;
    const body = table.tBodies[0];
    while (body.rows.length < rows.length) body.insertRow().dataset.k = body.rows.length - 1;
    for (const row of body.rows) {
      rows[row.dataset.k].forEach((entry, k) => {
        const cell = row.cells[k] ?? row.insertCell(), numeric = typeof entry === "number";
        cell.className = numeric ? "" : "name";
        cell.textContent = numeric ? rounded(entry) : entry;
        if (numeric) cell.dataset.v = entry;
      });
    }
  }

  const named = (names, values) => Object.fromEntries(names.map((name, k) => [name, values[k]]));
  const xyz = (points) => named(["x", "y", "z"], columns(points));
  const lines = (pairs) => xyz(pairs.flatMap(([a, b]) => [a, b, null]));

  function traces() {
    const { refusal, shock, bodies, jumps, before } = result, { size, middle, numbered, points } = landing;
    const [solid, through, marks, axes] = switches.map((name) => byId(name).checked);
    const near = (p) => norm(sum(p, middle, -1)) < 1.1 * size, above = (p) => [p[0], p[1], landing.top + 0.06 * size];
    const struck = landing.contacts.map(({ body, r }, k) => inWorld(body, posture.contact(k, r)));
    const tail = (share) => struck.map((point, k) => sum(point, before[k], -share * size)), ends = tail(0.12);
    const places = points.map(({ body, position }, k) => (body < 0 ? position : inWorld(body, result.points[k])));
    const centres = numbered.map((b, k) => [String(k + 1), bodies[b].copc && inWorld(b, bodies[b].copc)]).filter(([, p]) => p && near(p));
    const screws = numbered.filter((b) => bodies[b].screw).map((b) => {
      const axis = times(result.rotation[b], scaled(jumps[b].omega, 1 / bodies[b].spin)), q = inWorld(b, bodies[b].screw);
      return [sum(q, axis, dot(axis, sum(inWorld(b, landing.com[b]), q, -1))), axis];
    }).filter(([p]) => near(p)).map(([p, axis]) => [sum(p, axis, -0.2 * size), sum(p, axis, 0.2 * size)]);
    // One cone a trace, because the size of several depends on the distance between them.
    const heads = tail(0.06).map((p, k) => ({ ...xyz([p]), ...named(["u", "v", "w"],
      columns([scaled(before[k], 1 / norm(before[k]))])), sizeref: 0.09 * size, visible: marks }));
    const all = [
      { ...named(["x", "y", "z"], surfaces(result)), ...named(["i", "j", "k"], geometry.corners), visible: solid,
        intensity: refusal ? shock.map(() => 0) : shock, opacity: refusal || through ? 0.4 : 1,
        ...(refusal ? { colorscale: [[0, "#999"], [1, "#999"]] } : {}) },
      { ...lines(tail(0.36).map((p, k) => [p, ends[k]])), visible: marks },
      heads[0],
      { ...lines(places.map((p) => [p, above(p)])), visible: marks },
      { ...xyz(places), visible: marks },
      { ...xyz(places.map(above)), text: points.map(({ letter }) => letter), visible: marks },
      { ...xyz(centres.map(([, p]) => p)), text: centres.map(([text]) => text), visible: axes },
      { ...lines(screws), visible: axes },
      xyz(landing.ends),
    ];
    return [...all.map((places, k) => ({ ...data.styles[k], ...places })),
      ...heads.slice(1).map((head) => ({ ...data.styles[2], ...head }))];
  }

  function update() {
    if (posture.moved()) byId("model").value = "with drives";
    byId("model").disabled = posture.moved();
    result = computed();
    const { bodies, deltas, refusal, v_in, contacts, loads } = result, model = byId("model").value;
    const joints = model === "with drives" ? "joints with drives" : `joints ${model}`;
    const ofScene = model === "with drives" && !posture.changed() && inputs.every((name, k) => typed(name, k) === landing.strike[k]);
    byId("state").textContent = refusal ||
      `${ofScene ? "the contact velocity of the scene" : "another posture, contact velocity or joint model than the scene's"}; shock is relative to ` +
      `${rounded(v_in)} m/s; ${joints}`;
    byId("state").classList.toggle("refused", Boolean(refusal));
    const points = landing.contacts.map(({ r }, k) => posture.contact(k, r));
    const texts = refusal || !posture.moved() ? [] :
      [...warnings.limits(posture.sliders()), ...warnings.below(landing, geometry, result, points)];
    byId("warnings").textContent = texts.length ? `warning: ${texts.join("; ")}` : "";
    fill(byId("point-rows"), deltas.map((delta, k) => [landing.points[k].letter, landing.points[k].name, norm(delta) / v_in, ...delta,
      ...(landing.peak === null ? [] : [norm(delta) * landing.peak])]));
    fill(byId("body-rows"), bodies.map((body, k) => [String(landing.numbered.indexOf(k) + 1 || ""), landing.bodies[k], body.com,
      body.least, body.greatest, body.spin, ...(body.copc ?? [NaN, NaN, NaN]), body.ropc,
      refusal ? "–" : body.copc ? (body.mostly ? "mostly out of plane" : "") : body.screw ? "out of plane" : "translates"]));
    fill(byId("contact-rows"), landing.grounds.map(({ name, normal }, k) => {
      const up = dot(contacts[k], normal);
      return ["", name, ...contacts[k], up > 0 ? norm(sum(contacts[k], normal, -up)) / up : NaN];
    }));
    fill(byId("joint-rows"), loads.map((load, k) => ["", landing.joints[k], load[0], norm(load.slice(1, 4)), norm(load.slice(4))]));
    Plotly.react("view", traces(), structuredClone(landing.layout), data.config);
  }

  function follow({ points: [{ curveNumber, pointNumber }] }) {
    if (curveNumber !== 0 || result.refusal) return;
    const body = geometry.body[pointNumber], r = vertex(pointNumber), delta = norm(velocityAt(result.jumps[body], r));
    byId("pointer").textContent = `${landing.bodies[body]} at (${r.map((x) => x.toFixed(4)).join(", ")}) m in its frame: shock ` +
      `${rounded(delta / result.v_in)}, |Δv| ${rounded(delta)} m/s`;
  }

  data.landings.forEach(({ histories }, number) => histories.forEach((chart, k) => {
    Plotly.newPlot(`history-${number}-${k}`, chart.data, chart.layout, data.config);
  }));

  for (const name of inputs) {
    const [box, range] = [byId(name), byId(`${name}-range`)];
    range.addEventListener("input", () => { box.value = range.value; soon(); });
    box.addEventListener("input", () => { if (Number.isFinite(box.valueAsNumber)) range.value = box.value; soon(); });
  }
  for (const name of ["model", ...switches]) byId(name).addEventListener("input", soon);
  byId("reset").addEventListener("click", reset);
  addEventListener("beforeprint", reset);  // as the figures on paper
  byId("landing").addEventListener("input", (event) => choose(Number(event.target.value)));
  choose(0);
  byId("view").on("plotly_hover", follow);
})();
