// Draws charts given as data (motofmi/reports/charts.py) with Apache ECharts as SVG.
//
//   const chart = motofmiCharts.draw(element, data)     // draws into the element; data as of Chart.to_dict()
//   chart.update(data)                                  // other data, same panels: no new elements
//   chart.remove()
//
// The legend, the buttons and the texts are HTML, so that they wrap, scale with the font and take the keyboard.
"use strict";
const motofmiCharts = (() => {
  const FONT = { fontFamily: "system-ui, sans-serif", fontSize: 12 };
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  let printing = false;
  const all = new Set();

  const shade = () => (dark.matches && !printing ? 1 : 0);
  const theme = () => (shade()
    ? { text: "#d8d8d8", grid: "#3a3a3a", axis: "#8a8a8a", paper: "#161616" }
    : { text: "#333333", grid: "#e3e3e3", axis: "#777777", paper: "#ffffff" });

  const made = (name, settings = {}, ...children) => {
    const node = document.createElement(name);
    for (const [key, value] of Object.entries(settings)) key in node ? (node[key] = value) : node.setAttribute(key, value);
    node.append(...children);
    return node;
  };

  const number = (value) => (value === null || value === undefined ? "–" : String(Number(value.toPrecision(4))));

  function tick(value) {
    if (value === 0) return "0";
    const size = Math.abs(value);
    return size >= 1e5 || size < 1e-3 ? value.toExponential().replace("e+", "e") : String(Number(value.toPrecision(6)));
  }

  function axis(spec, across, colours, room) {
    const names = spec.names.length > 0;
    const odd = (end) => (end !== null && Number(end.toPrecision(2)) !== end ? false : undefined);  // limits that are no round numbers have no label
    return {
      type: names ? "category" : spec.log ? "log" : "value", inverse: names, data: names ? spec.names : undefined,
      name: across && !names ? spec.title : "", nameLocation: "middle", nameGap: 28, nameTextStyle: { ...FONT, color: colours.text },
      min: spec.low === null ? undefined : spec.low, max: spec.high === null ? undefined : spec.high,
      scale: true, splitNumber: across ? 6 : 4,
      axisLine: { show: true, onZero: false, lineStyle: { color: colours.axis } },
      axisTick: { show: !names },
      splitLine: { show: !names, lineStyle: { color: colours.grid } },
      axisLabel: { ...FONT, color: colours.text, hideOverlap: !names, interval: names ? 0 : undefined,
        showMinLabel: spec.free ? false : odd(spec.low), showMaxLabel: spec.free ? false : odd(spec.high),
        formatter: names ? undefined : tick, width: names ? Math.min(0.4 * room, 190) : undefined,
        overflow: names ? "break" : undefined, lineHeight: names ? 14 : undefined },
    };
  }

  const DASH = { dashed: [6, 4], dotted: [2, 3] };

  function band(curve, colour) {
    const [low, high] = curve.band;
    return {
      type: "custom", name: curve.name, silent: true, z: 1, clip: true, data: [0], tooltip: { show: false },
      renderItem: (_, api) => {
        const points = [];
        curve.x.forEach((x, i) => { if (high[i] !== null && x !== null) points.push(api.coord([x, high[i]])); });
        for (let i = curve.x.length - 1; i >= 0; i--) if (low[i] !== null) points.push(api.coord([curve.x[i], low[i]]));
        return { type: "polygon", shape: { points }, style: { fill: colour, opacity: 0.2 } };
      },
    };
  }

  function errorBars(curve, colour) {
    const [low, high] = curve.band;
    return {
      type: "custom", name: curve.name, silent: true, z: 3, clip: true, tooltip: { show: false },
      data: curve.x.map((x, i) => [x, low[i], high[i]]), encode: { x: 0, y: [1, 2] },
      renderItem: (_, api) => {
        const [x, a] = api.coord([api.value(0), api.value(1)]), b = api.coord([api.value(0), api.value(2)])[1];
        return { type: "line", shape: { x1: x, y1: a, x2: x, y2: b }, style: { stroke: colour, lineWidth: 1.5 } };
      },
    };
  }

  function bars(curve, colour, spec) {
    return {
      type: "custom", name: curve.name, encode: { x: 0, y: 1 }, z: 2, clip: true,
      data: curve.x.map((x, i) => [x, curve.y[i]]),
      renderItem: (at, api) => {
        const end = api.coord([api.value(0), api.value(1)]);
        const base = spec.x.log ? [at.coordSys.x] : api.coord([spec.x.low ?? 0, api.value(1)]);
        const height = 0.62 * api.size([0, 1])[1];
        const shape = { x: Math.min(base[0], end[0]), y: end[1] - height / 2, width: Math.abs(end[0] - base[0]), height };
        return { type: "rect", shape, style: { fill: colour } };
      },
    };
  }

  function needles(curve, colour) {
    return {
      type: "custom", name: curve.name, z: 3, data: curve.x.map((x, i) => [x, curve.y[i]]),
      renderItem: (_, api) => {
        const [x0, y0] = api.coord([0, 0]), [x, y] = api.coord([api.value(0), api.value(1)]);
        const turn = Math.atan2(y - y0, x - x0), tip = (da) => [x - 9 * Math.cos(turn + da), y - 9 * Math.sin(turn + da)];
        return { type: "group", children: [
          { type: "line", shape: { x1: x0, y1: y0, x2: x, y2: y }, style: { stroke: colour, lineWidth: 2 } },
          { type: "polygon", shape: { points: [[x, y], tip(0.4), tip(-0.4)] }, style: { fill: colour } }] };
      },
    };
  }

  function viridis(share) {  // from dark blue over green to yellow, in five steps
    const steps = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
    const at = 4 * Math.min(Math.max(share, 0), 1), k = Math.min(Math.floor(at), 3);
    return `rgb(${steps[k].map((a, i) => Math.round(a + (at - k) * (steps[k + 1][i] - a))).join()})`;
  }

  function cells(spec) {
    const share = (value) => Math.log(Math.max(value, spec.low) / spec.low) / Math.log(spec.high / spec.low);
    return {
      type: "custom", name: spec.label, clip: true, z: 1, encode: { x: [0, 1], y: [2, 3] },
      data: spec.x.map((x, i) => [x, spec.x_end[i], spec.y[i], spec.y_end[i], spec.value[i], spec.framed[i] ? 1 : 0]),
      renderItem: (_, api) => {
        const a = api.coord([api.value(0), api.value(2)]), b = api.coord([api.value(1), api.value(3)]);
        const shape = { x: Math.min(a[0], b[0]), y: Math.min(a[1], b[1]), width: Math.abs(b[0] - a[0]), height: Math.abs(b[1] - a[1]) };
        const style = { fill: viridis(share(api.value(4))) };
        if (api.value(5)) Object.assign(style, { stroke: "#e00000", lineWidth: 2 });
        return { type: "rect", shape, style };
      },
    };
  }

  function curve(spec, panel, colour) {
    if (spec.style === "bars") return bars(spec, colour, panel);
    if (spec.style === "needles") return needles(spec, colour);
    const drawn = ["points", "circles", "errors"].includes(spec.style);
    const size = spec.size || null;
    const data = spec.x.map((x, i) => ({ value: [x, spec.y[i]], symbolSize: size ? size[i] : undefined, note: spec.text ? spec.text[i] : "" }));
    const hollow = spec.style === "circles";
    return {
      type: drawn ? "scatter" : "line", name: spec.name, data, z: drawn ? 4 : 3, symbol: "circle",
      symbolSize: { errors: 7, both: 4 }[spec.style] || 5, showSymbol: spec.style === "both" || panel.hover === "point",
      itemStyle: { color: hollow ? "transparent" : colour, borderColor: colour, borderWidth: hollow ? 1.2 : 0, opacity: drawn || spec.style === "both" ? 1 : 0 },
      lineStyle: { color: colour, width: spec.width, type: DASH[spec.style] || "solid" },
      connectNulls: false, emphasis: { scale: 1.6, itemStyle: { opacity: 1 } }, animation: false,
    };
  }

  function marks(panel, colours) {
    return {
      type: "scatter", name: "", data: [], silent: true,
      markArea: { silent: true, data: panel.shades.map((s) => {
        const ends = [s.low, s.high].map((at) => (s.across === "x" ? { xAxis: at } : { yAxis: at }));
        ends[0].itemStyle = { color: panel.colours[s.colour][shade()], opacity: s.opacity };
        return ends;
      }) },
      markLine: { silent: true, symbol: "none", data: panel.lines.map((line) => ({
        [line.across === "x" ? "xAxis" : "yAxis"]: line.at, label: { show: false },
        lineStyle: { color: colours.text, type: "dashed", width: 1 } })) },
    };
  }

  function notes(panel, colours) {
    return {
      type: "scatter", name: "", silent: true, z: 6, symbolSize: 0,
      data: panel.notes.map((n) => ({ value: [n.x, n.y], label: { show: true, formatter: n.text, ...FONT,
        color: panel.colours[n.colour][shade()], textBorderColor: colours.paper, textBorderWidth: 3, position: "inside" } })),
    };
  }

  function tooltip(panel, colours) {
    const escape = (text) => String(text).replace(/[&<>]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;" })[c]);
    const point = (at) => {
      const value = Array.isArray(at.value) ? at.value : at.data.value;
      if (at.seriesName === (panel.cells || {}).label)
        return `${escape(panel.cells.label)}: ${number(value[4])}<br>${escape(panel.x.label)} ${number(value[0])} to ${number(value[1])} ${escape(panel.x.unit)}`;
      const name = panel.y.names.length ? panel.y.names[value[1]] : `${panel.y.title} ${number(value[1])}`;
      return [`<b>${escape(at.seriesName)}</b>`, at.data.note ? escape(at.data.note) : "",
        escape(`${panel.x.title} ${number(value[0])}`), escape(name)].filter(Boolean).join("<br>");
    };
    const column = (points) => [escape(`${panel.x.title} ${number(points[0].axisValue)}`),
      ...points.filter((p) => p.seriesName && p.value[1] !== null).map((p) => `${p.marker}${escape(p.seriesName)}: ${number(p.value[1])}${p.data.note ? ` (${escape(p.data.note)})` : ""}`)].join("<br>");
    return { trigger: panel.hover === "x" ? "axis" : "item", confine: true, transitionDuration: 0,
      backgroundColor: colours.paper, borderColor: colours.axis, textStyle: { ...FONT, color: colours.text },
      axisPointer: { lineStyle: { color: colours.axis } },
      formatter: (at) => (Array.isArray(at) ? (at.length ? column(at) : "") : point(at)) };
  }

  function equalScales(panel, box) {  // limits of both axes with one scale in a box [px], around what is drawn
    const values = (key) => panel.curves.flatMap((c) => c[key]).filter((v) => v !== null);
    const [xs, ys] = [values("x"), values("y")];
    if (panel.x.low !== null || !xs.length) return;
    const ends = (v) => [Math.min(...v), Math.max(...v)];
    const [x, y] = [ends(xs), ends(ys)];
    const scale = 1.12 * Math.max((x[1] - x[0]) / box.width, (y[1] - y[0]) / box.height);
    const limits = ([a, b], size) => [0.5 * (a + b - scale * size), 0.5 * (a + b + scale * size)].map((v) => Number(v.toPrecision(3)));
    panel.x.free = panel.y.free = true;  // limits that are no round numbers, without labels
    [panel.x.low, panel.x.high] = limits(x, box.width);
    [panel.y.low, panel.y.high] = limits(y, box.height);
  }

  function option(panel, hidden, element) {
    const colours = theme();
    const shownPanel = { ...panel, x: { ...panel.x }, y: { ...panel.y } };
    if (panel.square) equalScales(shownPanel, { width: element.clientWidth - 80, height: element.clientHeight - 70 });
    const visible = panel.curves.filter((c) => !hidden.has(c.name));
    const colour = (c) => panel.colours[c.colour][shade()];
    const series = [marks(panel, colours)];
    if (panel.cells) series.push(cells(panel.cells));
    for (const c of visible) if (c.band) series.push((c.style === "errors" ? errorBars : band)(c, colour(c)));
    for (const c of visible) series.push(curve(c, shownPanel, colour(c)));
    if (panel.notes.length) series.push(notes(panel, colours));
    return {
      animation: false, backgroundColor: "transparent",
      grid: { left: 8, right: 14, top: 10, bottom: 42, outerBoundsMode: "same", outerBoundsContain: "axisLabel" },
      xAxis: axis(shownPanel.x, true, colours, element.clientWidth), yAxis: axis(shownPanel.y, false, colours, element.clientWidth),
      tooltip: tooltip(panel, colours), series,
      dataZoom: [0, 1].map((k) => ({ type: "inside", id: `zoom${k}`, [k ? "yAxisIndex" : "xAxisIndex"]: 0, filterMode: "none",
        disabled: true, zoomOnMouseWheel: true, moveOnMouseMove: true })),
    };
  }

  function zoomed(instances, factor) {
    for (const instance of instances) {
      const ends = instance.getOption().dataZoom.map(({ start, end }) => {
        const half = Math.min(0.5 * (end - start) * factor, 50), middle = Math.min(Math.max(0.5 * (start + end), half), 100 - half);
        return { start: middle - half, end: middle + half };
      });
      ends.forEach((each, k) => instance.dispatchAction({ type: "dataZoom", dataZoomIndex: k, ...(factor ? each : { start: 0, end: 100 }) }));
    }
  }

  function buttons(state) {
    const free = made("button", { type: "button", className: "tool", textContent: "move", title: "Drag moves the picture, the wheel zooms", ariaPressed: "false" });
    free.onclick = () => {
      const on = free.ariaPressed !== "true";
      free.ariaPressed = String(on);
      state.instances.forEach((i) => i.setOption({ dataZoom: [0, 1].map((k) => ({ id: `zoom${k}`, disabled: !on })) }));
    };
    const act = (text, title, factor) => made("button", { type: "button", className: "tool", textContent: text, title, onclick: () => zoomed(state.instances, factor) });
    return made("span", { className: "tools" }, act("+", "Zoom in", 0.6), act("−", "Zoom out", 1 / 0.6), act("reset", "Show everything", 0), free);
  }

  const DASHES = { dashed: "5 3", dotted: "2 3" };
  function svg(inside) {
    const node = document.createElement("template");
    node.innerHTML = `<svg width="24" height="12" aria-hidden="true">${inside}</svg>`;
    return node.content.firstChild;
  }

  function swatch(spec) {
    const point = ["points", "circles", "errors"].includes(spec.style), bar = spec.style === "bars", stroke = `var(--c-${spec.colour})`;
    return svg(point ? `<circle cx="12" cy="6" r="3.4" fill="${spec.style === "circles" ? "none" : stroke}" stroke="${stroke}"/>`
      : bar ? `<rect x="2" y="2" width="20" height="8" fill="${stroke}"/>`
        : `<line x1="1" x2="23" y1="6" y2="6" stroke="${stroke}" stroke-width="2.4" stroke-dasharray="${DASHES[spec.style] || ""}"/>`);
  }

  function ambient(panels) {  // the meanings of shaded ranges and of thin lines
    const found = new Map();
    for (const { shades, lines, cells: grid } of panels) {
      if (grid) found.set(`${grid.label}: ${number(grid.low)} to ${number(grid.high)}, logarithmic`, [0, 1, 2, 3, 4, 5].map((k) => `<rect x="${4 * k}" y="1" width="4" height="10" fill="${viridis(k / 5)}"/>`).join(""));
      for (const s of shades) if (s.label) found.set(s.label, `<rect x="1" y="1" width="22" height="10" fill="var(--c-${s.colour})" opacity="${Math.max(s.opacity, 0.3)}"/>`);
      for (const line of lines) if (line.label) found.set(line.label, '<line x1="1" x2="23" y1="6" y2="6" stroke="currentColor" stroke-dasharray="4 3"/>');
    }
    return [...found].map(([text, inside]) => made("span", { className: "entry" }, svg(inside), text));
  }

  function legend(state) {
    const box = made("span", { className: "legend" }), found = new Map();
    for (const panel of state.data.panels) for (const c of panel.curves) if (c.name && !found.has(c.name)) found.set(c.name, c);
    state.entries = new Map();
    const meanings = ambient(state.data.panels);
    if (found.size < 2 && !meanings.length && !state.data.choices.length) return box;
    for (const [name, spec] of found) {
      const entry = made("button", { type: "button", className: "entry", ariaPressed: String(!state.hidden.has(name)) }, swatch(spec), name);
      entry.onclick = () => { state.hidden.has(name) ? state.hidden.delete(name) : state.hidden.add(name); refresh(state); };
      state.entries.set(name, entry);
      box.append(entry);
    }
    box.append(...meanings);
    return box;
  }

  function choices(state) {
    if (!state.data.choices.length) return [];
    const box = made("span", { className: "choices", role: "group", ariaLabel: "what is shown" });
    state.choices = state.data.choices.map((choice) => {
      const button = made("button", { type: "button", className: "choice", textContent: choice.label });
      button.onclick = () => {
        for (const name of state.entries.keys()) choice.curves.includes(name) ? state.hidden.delete(name) : state.hidden.add(name);
        refresh(state);
      };
      box.append(button);
      return { choice, button };
    });
    return [box];
  }

  function refresh(state) {
    for (const [name, entry] of state.entries) entry.ariaPressed = String(!state.hidden.has(name));
    const visible = [...state.entries.keys()].filter((n) => !state.hidden.has(n));
    for (const { choice, button } of state.choices) button.ariaPressed = String(visible.length === choice.curves.length && visible.every((n) => choice.curves.includes(n)));
    state.instances.forEach((instance, k) => instance.setOption(option({ ...state.data.panels[k], colours: state.data.colours }, state.hidden, state.boxes[k]), { notMerge: false, replaceMerge: ["series"] }));
  }

  function link(instances) {  // pointer and zoom along x in all panels together
    let busy = false;
    for (const one of instances) for (const event of ["dataZoom", "updateAxisPointer"]) one.on(event, (at) => {
      if (busy) return;
      busy = true;
      for (const other of instances) if (other !== one) {
        if (event === "dataZoom") {
          const { start, end } = one.getOption().dataZoom[0];
          other.dispatchAction({ type: "dataZoom", dataZoomIndex: 0, start, end });
        } else if (at.axesInfo && at.axesInfo.length) {
          other.dispatchAction({ type: "showTip", x: other.convertToPixel({ xAxisIndex: 0 }, at.axesInfo[0].value), y: 60 });
        }
      }
      busy = false;
    });
  }

  function draw(element, data) {
    const hidden = new Set(data.panels.flatMap((p) => p.curves).filter((c) => !c.shown).map((c) => c.name));
    const state = { data, hidden, choices: [], entries: new Map(), instances: [], boxes: [], element };
    const bar = made("div", { className: "bar" });
    const entries = legend(state);
    bar.append(...choices(state), entries, buttons(state));
    const panels = made("div", { className: `panels columns${data.columns}` });
    element.replaceChildren(bar, panels);
    for (const panel of data.panels) {
      const box = made("div", { className: panel.square ? "panel square" : "panel" });
      box.style.height = `${panel.height}px`;
      panels.append(made("div", { className: "cell" }, 
        ...[["panel-title", panel.title], ["axis-title", panel.y.names.length ? "" : panel.y.title]].filter(([, text]) => text)
          .map(([className, textContent]) => made("p", { className, textContent })), box));
      state.boxes.push(box);
      state.instances.push(echarts.init(box, null, { renderer: "svg" }));
    }
    if (data.linked) link(state.instances);
    refresh(state);
    state.resize = () => { state.instances.forEach((i) => i.resize()); if (data.panels.some((p) => p.square || p.y.names.length)) refresh(state); };
    state.watch = new ResizeObserver(state.resize);
    state.watch.observe(panels);
    all.add(state);
    return { update: (other) => { state.data = other; refresh(state); },
      remove: () => { state.watch.disconnect(); state.instances.forEach((i) => i.dispose()); all.delete(state); element.replaceChildren(); } };
  }

  const redraw = () => all.forEach((state) => { state.resize(); refresh(state); });
  // A printed page has another width: pictures scale to it.
  const scale = () => document.querySelectorAll(".panel svg").forEach((each) => each.setAttribute("viewBox", `0 0 ${each.getAttribute("width")} ${each.getAttribute("height")}`));
  dark.addEventListener("change", redraw);
  window.addEventListener("beforeprint", () => { printing = true; redraw(); scale(); });
  window.addEventListener("afterprint", () => { printing = false; redraw(); });
  return { draw };
})();
