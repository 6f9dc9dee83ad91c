// Moves the drawings of a mode: every motion is the real part of its phasor times exp(lambda t).
"use strict";
(() => {
  const METRE = 60, DEGREES = 180 / Math.PI;  // length of 1 m in the drawing
  const still = window.matchMedia("(prefers-reduced-motion: reduce)").matches;

  const around = (point, at, angle) => {
    const [x, y] = [point[0] - at[0], point[1] - at[1]], c = Math.cos(angle), s = Math.sin(angle);
    return [at[0] + c * x - s * y, at[1] + s * x + c * y];
  };

  function show(box, data, time) {
    const [re, im] = data.value, drawn = time * data.speed;
    // A run begins small where the mode grows and large where it decays; beyond data.growth it is drawn slower.
    const total = re * data.run * data.speed, kept = Math.min(1, data.growth / Math.max(Math.abs(total), 1e-9));
    const size = data.gain * Math.exp(kept * re * drawn - Math.max(kept * total, 0));
    const at = (name) => { const [a, b] = data.phasors[name]; return size * (a * Math.cos(im * drawn) - b * Math.sin(im * drawn)); };
    for (const group of box.querySelectorAll(".lateral")) group.setAttribute("transform", `translate(${METRE * at("lateral")} 0)`);
    for (const name of ["yaw", "roll", "steer", "torso"]) for (const group of box.querySelectorAll(`g.${name}`))
      group.setAttribute("transform", `rotate(${DEGREES * at(name)} ${group.dataset.at || "0 0"})`);
    const arms = [-1, 1].map((side) => [around([30 * side, 20], [0, 20], at("torso")), around([38 * side, -30], [0, -35], at("steer"))]);
    box.querySelector(".arms").setAttribute("d", arms.map(([a, b]) => `M${a} L${b}`).join(" "));
  }

  for (const box of document.querySelectorAll(".animation")) {
    const data = JSON.parse(box.querySelector("script").textContent), button = box.querySelector(".play");
    let begin = null, running = false;
    const frame = (now) => {
      if (!running) return;
      begin = begin ?? now;
      show(box, data, ((now - begin) / 1000) % data.run);
      requestAnimationFrame(frame);
    };
    const play = (on) => {
      running = on;
      button.textContent = on ? "pause" : "play";
      if (on) { begin = null; requestAnimationFrame(frame); }
    };
    button.addEventListener("click", () => play(!running));
    show(box, data, 0.1 * data.run);
    if (!still) new IntersectionObserver(([seen]) => play(seen.isIntersecting)).observe(box);
  }
})();
