/* A motorcycle or bicycle with its rider as lines, from the lengths of the value file, in three views.

   Axes as in the components: x forward, y right, z down, the ground is z = 0. The steer axis is tilted back by the caster
   angle eps and meets the ground at x0; the front contact lies behind it. Lengths that no value file has (saddle, bar,
   rider) follow from wheel radius and wheelbase and serve the drawing only. */

function geometry(values) {
  const eps = values.caster_angle, cos = Math.cos(eps), bicycle = "wheelbase" in values;
  const rear = bicycle ? 0 : -values.rear_contact_distance;
  const front = bicycle ? values.wheelbase : (values.steer_axis_distance - values.trail) / cos;
  const x0 = bicycle ? values.wheelbase + values.ground_trail : values.steer_axis_distance / cos;
  return { eps, rear, front, x0, rearRadius: values.rear_wheel_radius, frontRadius: values.front_wheel_radius };
}

/* Lines of points [x, y, z], each with the body that it belongs to: rear, front or torso. */
function bodies(g) {
  const base = g.front - g.rear, onAxis = (h) => [g.x0 - h * Math.tan(g.eps), 0, -h], head = onAxis(2.1 * g.frontRadius), bar = onAxis(3.1 * g.frontRadius);
  const hip = [g.rear + 0.42 * base, 0, -Math.max(0.78, 2.5 * g.rearRadius)], wheel = (x, r) => Array.from({ length: 33 }, (_, k) => [x + r * Math.cos((k * Math.PI) / 16), 0, -r + r * Math.sin((k * Math.PI) / 16)]);
  const shoulder = [hip[0] + 0.26, 0, hip[2] - 0.5], grip = (side) => [bar[0] - 0.08, 0.34 * side, bar[2] - 0.02];
  const at = (p, dx, y, dz) => [p[0] + dx, y, p[2] + dz], neck = at(shoulder, 0.03, 0, -0.06);
  const skull = Array.from({ length: 17 }, (_, k) => [neck[0] + 0.07 + 0.11 * Math.cos((k * Math.PI) / 8), 0, neck[2] - 0.13 + 0.13 * Math.sin((k * Math.PI) / 8)]);
  const width = Array.from({ length: 17 }, (_, k) => [neck[0] + 0.07, 0.11 * Math.cos((k * Math.PI) / 8), neck[2] - 0.13 + 0.13 * Math.sin((k * Math.PI) / 8)]);
  const crank = [g.rear + 0.42 * base, 0, -g.rearRadius * 0.95];
  return {
    hip,
    lines: [
      ["rear", wheel(g.rear, g.rearRadius)], ["front", wheel(g.front, g.frontRadius)],
      ["rear", [[g.rear, 0, -g.rearRadius], crank, head, at(hip, 0, 0, 0.05), crank]],
      ["rear", [at(hip, -0.35, 0, 0), at(hip, -0.35, 0.12, 0.02), at(hip, 0.15, 0.12, 0.05), at(hip, 0.15, -0.12, 0.05), at(hip, -0.35, -0.12, 0.02), at(hip, -0.35, 0, 0)]],
      ["front", [[g.front, 0, -g.frontRadius], head, bar]], ["front", [grip(-1), bar, grip(1)]],
      ["torso", [hip, shoulder]], ["torso", [at(shoulder, 0, -0.21, 0), at(shoulder, 0, 0.21, 0)]], ["torso", skull], ["torso", width],
    ],
    arms: [-1, 1].map((side) => [at(shoulder, 0, 0.21 * side, 0), at(shoulder, 0.16, 0.33 * side, 0.26), grip(side)]),
    legs: [-1, 1].map((side) => [at(hip, 0, 0.1 * side, 0), at(hip, 0.33, 0.2 * side, 0.12), [crank[0] + 0.05, 0.16 * side, -0.32]]),
  };
}

/* A turn by an angle about an axis (unit vector) through a point. */
function turn(p, through, axis, angle) {
  const c = Math.cos(angle), s = Math.sin(angle), [x, y, z] = p.map((v, i) => v - through[i]), [u, v, w] = axis, dot = (u * x + v * y + w * z) * (1 - c);
  return [through[0] + x * c + (v * z - w * y) * s + u * dot, through[1] + y * c + (w * x - u * z) * s + v * dot, through[2] + z * c + (u * y - v * x) * s + w * dot];
}

/* The lines with the motion {roll, steer, torso, yaw, shift} in rad and m applied. */
function posed(g, shape, { roll, steer, torso, yaw, shift }) {
  const axis = [Math.sin(g.eps), 0, Math.cos(g.eps)], foot = [g.x0, 0, 0];
  const place = (p) => {
    const leant = turn(p, [0, 0, 0], [1, 0, 0], roll), [x, y, z] = turn(leant, [0, 0, 0], [0, 0, 1], yaw);
    return [x, y + shift, z];
  };
  const own = { rear: (p) => p, front: (p) => turn(p, foot, axis, steer), torso: (p) => turn(p, shape.hip, axis, torso) };
  return [
    ...shape.lines.map(([body, points]) => [body, points.map(own[body]).map(place)]),
    ...shape.arms.map(([a, b, c]) => ["torso", [own.torso(a), own.torso(b), own.front(c)].map(place)]),
    ...shape.legs.map((points) => ["torso", points.map(place)]),
  ];
}

const VIEWS = {
  side: { label: "side", project: ([x, , z]) => [x, z], box: [-1.15, -2.0, 2.6, 2.1] },
  rear: { label: "from behind", project: ([, y, z]) => [y, z], box: [-1.05, -2.0, 2.1, 2.1] },
  top: { label: "from above", project: ([x, y]) => [x, y], box: [-1.15, -0.95, 2.6, 1.9] },
};

function viewText(lines, { project }, ground) {
  const path = (points) => "M" + points.map((p) => project(p).map((v) => v.toFixed(3)).join(" ")).join("L");
  return (ground ? `<line x1="-3" x2="3" y1="0" y2="0" class="ground"/>` : "") + lines.map(([body, points]) => `<path class="${body}" d="${path(points)}"/>`).join("");
}
