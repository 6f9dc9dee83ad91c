/* Mode shapes of a vehicle at a speed, and what takes part in a mode: the method of vehicle_fmu/mode_shapes.py.

   Further states are those of a device or an effect besides a torso, and those of freedoms of a vehicle besides lateral
   motion, yaw, roll and steer: twist of a frame, lean. */

const PLANE = ["lateral", "yaw", "roll", "steer", "front", "rear"]; // what states of a vehicle's plane motion and tyres begin with

/* What each state is besides the plane motion: "vehicle", "device", or "" for those of the plane motion. */
function furtherStates(states) {
  const places = states.map((s) => [s.slice(0, s.lastIndexOf(".")), s.slice(s.lastIndexOf(".") + 1)]);
  const owner = places.find(([, name]) => name.startsWith("steer"))?.[0];
  return places.map(([place, name]) => {
    const plane = place === owner && PLANE.some((start) => name.startsWith(start));
    return owner === undefined || name.startsWith("torso") || plane ? "" : place === owner ? "vehicle" : "device";
  });
}

/* The mode shapes at a speed: eigenvalues and vectors with the branch of each, participation factors. */
function shapesAt(system, branches, speed) {
  const { n } = system, shapes = eigen(system.matrix(speed), n), here = branches.spectra[indexOf(branches.points, speed)];
  const part = participation(shapes, n), total = new Float64Array(n), further = furtherStates(system.states);
  for (let i = 0; i < n; i++) for (let j = 0; j < n; j++) total[j] += part[i * n + j];
  const column = Array.from({ length: n }, (_, i) => {
    let best = 0;
    for (let j = 1; j < n; j++) if (distance(shapes, i, here, j) < distance(shapes, i, here, best)) best = j;
    return best;
  });
  const names = system.states.map((s) => s.slice(s.lastIndexOf(".") + 1));
  const share = (chosen) => Array.from({ length: n }, (_, j) => names.reduce((sum, name, i) => sum + (chosen(name, i) ? part[i * n + j] : 0), 0) / total[j]);
  const signal = (name) => names.lastIndexOf(name);
  const size = (row, j) => (row < 0 ? 0 : Math.hypot(shapes.vectorRe[row * n + j], shapes.vectorIm[row * n + j]));
  const torso = signal("torso_angle"), steer = signal("steer_angle"), rear = signal("rear_side_force"), front = signal("front_side_force");
  return {
    ...shapes, column, n, part,
    motion: (start) => share((name) => name.startsWith(start)),
    foreign: share((_, i) => further[i] !== ""),
    upper: column.map((_, i) => i).filter((i) => shapes.im[i] > 0),
    pair: (i) => [column[i], column[i + 1]],
    tyres: column.map((_, j) => (size(front, j) > 0 ? size(rear, j) / size(front, j) : 0)),
    together: column.map((_, j) => {
      const sum = size(torso, j) ** 2 + size(steer, j) ** 2;
      if (torso < 0 || steer < 0 || !(sum > 0)) return 0;
      const at = (row) => [shapes.vectorRe[row * n + j], shapes.vectorIm[row * n + j]], [a, b] = at(torso), [c, d] = at(steer);
      return (a * c + b * d) / sum;
    }),
  };
}

function indexOf(points, speed) {
  let low = 0, high = points.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (points[middle] < speed - 1e-9) low = middle + 1;
    else high = middle;
  }
  return low;
}

