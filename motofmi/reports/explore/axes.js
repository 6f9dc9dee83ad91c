/* Axes in SVG: scales, ticks, frame. */

const INK = { weave: "var(--weave)", wobble: "var(--wobble)", capsize: "var(--capsize)", rear_wobble: "var(--rear-wobble)", rider_wobble: "var(--rider-wobble)" };

const DEGREES = 180 / Math.PI;

function shown(mode) { return mode.replace("_", "-"); }

function ticks(low, high, count = 6) {
  const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((m) => m * power >= rough), first = Math.ceil(low / step - 1e-9);
  return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, i) => Number(((first + i) * step).toPrecision(12)));
}

const CLOSE = 0.7; // units of the drawing: points of a path that are nearer to the last one are left out

class Axes {
  /* frame: {left, top, width, height} in units of the drawing; x and y: [low, high]. */
  constructor(frame, x, y) { Object.assign(this, { frame, xs: x, ys: y }); }

  x(value) { return this.frame.left + ((value - this.xs[0]) / (this.xs[1] - this.xs[0])) * this.frame.width; }

  y(value) { return this.frame.top + this.frame.height - ((value - this.ys[0]) / (this.ys[1] - this.ys[0])) * this.frame.height; }

  /* The frame with ticks and labels, and an empty group for what moves in it. */
  draw(xLabel, yLabel, id) {
    const { left, top, width, height } = this.frame, bottom = top + height;
    const across = ticks(...this.xs).map((t) => `<line x1="${this.x(t)}" x2="${this.x(t)}" y1="${top}" y2="${bottom}" class="grid"/>` +
      (xLabel ? `<text x="${this.x(t)}" y="${bottom + 16}" class="tick" text-anchor="middle">${t}</text>` : ""));
    const up = ticks(...this.ys).map((t) => `<line x1="${left}" x2="${left + width}" y1="${this.y(t)}" y2="${this.y(t)}" class="grid"/>` +
      `<text x="${left - 6}" y="${this.y(t) + 4}" class="tick" text-anchor="end">${t}</text>`);
    return `<clipPath id="${id}"><rect x="${left}" y="${top}" width="${width}" height="${height}"/></clipPath>${across.join("")}${up.join("")}` +
      `<g clip-path="url(#${id})" id="${id}-content"></g><rect x="${left}" y="${top}" width="${width}" height="${height}" class="frame"/>` +
      `<text x="${left + width / 2}" y="${bottom + 34}" class="label" text-anchor="middle">${xLabel}</text>` +
      `<text transform="translate(${left - 40} ${top + height / 2}) rotate(-90)" class="label" text-anchor="middle">${yLabel}</text>`;
  }

  /* A path through points; it is interrupted where a point is missing, and behind the places in `gaps`. */
  path(xs, ys, gaps) {
    const text = [];
    let pen = "M", px = 0, py = 0;
    for (let i = 0; i < xs.length; i++) {
      if (gaps.has(i - 1)) pen = "M";
      if (!Number.isFinite(xs[i]) || !Number.isFinite(ys[i])) {
        pen = "M";
        continue;
      }
      const x = Math.round(10 * this.x(xs[i])) / 10, y = Math.round(10 * this.y(ys[i])) / 10;
      const close = pen === "L" && Math.abs(x - px) + Math.abs(y - py) < CLOSE && !gaps.has(i) && i < xs.length - 1;
      if (close) continue;
      text.push(pen, x, " ", y);
      [pen, px, py] = ["L", x, y];
    }
    return text.join("");
  }
}
