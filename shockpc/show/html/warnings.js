// Warnings of a landing that the page sets: joints beyond their limits, and links below the contacts.
"use strict";
const warnings = (() => {
  const TURN = 2 * Math.PI, DEGREE = Math.PI / 180;
  const inUnit = (slider, x) => `${Number((slider.unit === "rad" ? x / DEGREE : x).toPrecision(4))}`;
  const unit = (slider) => (slider.unit === "rad" ? "deg" : slider.unit);
  const beyond = ({ limits, x }) => Math.max(limits[0] - x, x - limits[1], 0);
  const bounded = (sliders) => sliders.filter((slider) => slider.limits);

  // Joints beyond the limits of the file. Args: sliders with name, unit, value x, and limits, which most have none.
  const limits = (sliders) => bounded(sliders).filter((slider) => beyond(slider) > 1e-9).map((slider) =>
    `${slider.name} is ${inUnit(slider, beyond(slider))} ${unit(slider)} outside its limits`);

  // Why an angle is refused, as by the commands: it is outside the limits, and more than a whole turn.
  const refused = (sliders) => bounded(sliders).filter((slider) => slider.unit === "rad" && beyond(slider) > 0 && Math.abs(slider.x) > TURN)
    .map((slider) => `${slider.name}: ${inUnit(slider, slider.x)} deg is outside its limits and more than a whole turn`)[0] ?? "";

  // What flat ground meets before the contacts, or which of them it does not touch.
  // Args: landing, with its ground; geometry, vertices of all bodies and the body of each; state, where the bodies are;
  // points, of the contacts in their bodies.
  function below(landing, geometry, { rotation, position }, points) {
    const { ground } = landing, found = [];
    if (!ground) return found;
    const along = (v) => v[0] * ground.up[0] + v[1] * ground.up[1] + v[2] * ground.up[2];
    const rising = rotation.map((R) => [0, 1, 2].map((k) => along([R[0][k], R[1][k], R[2][k]]))), height = position.map(along);
    const at = (body, x, y, z) => height[body] + rising[body][0] * x + rising[body][1] * y + rising[body][2] * z;
    const contacts = ground.contacts.map(({ body, r, depth, number }) => at(body, ...(points[number] ?? r)) - depth);
    const low = Math.min(...contacts), { body, vertices } = geometry, struck = new Set(ground.contacts.map((contact) => contact.body));
    let least = Infinity, first = -1;
    for (let n = 0; n < body.length; n++) {
      if (struck.has(body[n])) continue;
      const here = at(body[n], vertices[3 * n], vertices[3 * n + 1], vertices[3 * n + 2]);
      if (here < least) [least, first] = [here, body[n]];
    }
    if (low - least > ground.tolerance) {
      found.push(`${landing.bodies[first]} lies ${(low - least).toPrecision(2)} m below the contact, so flat ground meets it first`);
    }
    const spread = Math.max(...contacts) - low;
    if (spread > ground.tolerance) found.push(`the contacts differ by ${spread.toPrecision(2)} m in height, so flat ground cannot touch all`);
    return found;
  }

  return { limits, refused, below };
})();
if (typeof module !== "undefined") module.exports = warnings;
