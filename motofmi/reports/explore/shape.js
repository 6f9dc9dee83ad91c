/* A motorcycle or bicycle with its rider as lines, from the lengths of the value file, in three views.

   Axes as in the components: x forward, y right, z down, the ground is z = 0. The steer axis is tilted back by the caster
   angle eps and meets the ground at x0; the front contact lies behind it. Lengths that no value file has (saddle, bar,
   rider) follow from wheel radius and wheelbase and serve the drawing only; of a vehicle given by matrices all lengths. */

const GENERIC = { eps: 0.45, rear: -0.7, front: 0.7, x0: 0.82, rearRadius: 0.31, frontRadius: 0.31, generic: true };

function geometry(values) {
  if ("steering_head_x" in values) return geometryOfPoints(values);
  if (!("rear_wheel_radius" in values)) return GENERIC;
  const eps = values.caster_angle, cos = Math.cos(eps), bicycle = "wheelbase" in values;
  const rear = bicycle ? 0 : -values.rear_contact_distance;
  const front = bicycle ? values.wheelbase : values.front_contact_distance ?? (values.steer_axis_distance - values.trail) / cos;
  const x0 = front + (bicycle ? values.ground_trail : values.trail / cos);
  return { eps, rear, front, x0, rearRadius: values.rear_wheel_radius, frontRadius: values.front_wheel_radius };
}

/* From points that are given one from the next (vehicle_fmu/components/touring_motorcycle.py): the reference point is at
   x = 0, the steer axis runs through the steering head, the wheels stand on the ground. */
function geometryOfPoints(values) {
  const at = (name) => [values[`${name}_x`], values[`${name}_z`]];
  const chain = (...names) => names.reduce(([x, z], name) => (name[0] === "-" ? [x - at(name.slice(1))[0], z - at(name.slice(1))[1]] : [x + at(name)[0], z + at(name)[1]]), [0, values.reference_height]);
  const rear = chain("swingarm_axis", "-swingarm_joint", "rear_wheel_centre"), head = chain("steering_head");
  const front = chain("steering_head", "upper_fork", "fork_joint", "-lower_fork_joint", "front_wheel_centre");
  return { eps: values.caster_angle, rear: rear[0], front: front[0], x0: head[0] + head[1] * Math.tan(values.caster_angle), rearRadius: rear[1], frontRadius: front[1] };
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

/* The lines with the motion {roll, steer, torso, lean, yaw, shift} in rad and m applied. */
function posed(g, shape, { roll, steer, torso, lean, yaw, shift }) {
  const axis = [Math.sin(g.eps), 0, Math.cos(g.eps)], foot = [g.x0, 0, 0];
  const place = (p) => {
    const leant = turn(p, [0, 0, 0], [1, 0, 0], roll), [x, y, z] = turn(leant, [0, 0, 0], [0, 0, 1], yaw);
    return [x, y + shift, z];
  };
  const own = { rear: (p) => p, front: (p) => turn(p, foot, axis, steer), torso: (p) => turn(turn(p, shape.hip, axis, torso), shape.hip, [1, 0, 0], lean) };
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

/* The lines as paths of a drawing, which are made once and then moved. */
function drawView(drawn, lines, { project }, ground) {
  const path = (points) => "M" + points.map((p) => project(p).map((v) => v.toFixed(3)).join(" ")).join("L");
  let paths = drawn.querySelectorAll("path");
  if (paths.length !== lines.length) {
    drawn.innerHTML = (ground ? `<line x1="-3" x2="3" y1="0" y2="0" class="ground"/>` : "") + lines.map(([body]) => `<path class="${body}"/>`).join("");
    paths = drawn.querySelectorAll("path");
  }
  lines.forEach(([, points], i) => paths[i].setAttribute("d", path(points)));
}
