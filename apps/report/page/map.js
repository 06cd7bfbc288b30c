// The map: truth, estimate, features with their uncertainty, returns, and the vehicle at one instant.

const chiSquare95 = {1: 3.841, 2: 5.991};  // by degrees of freedom

const decisions = ["matched", "new", "discarded", "root", "waiting"];

// From the lowest to the highest; each is one path.
const mapLayers = ["submap", "submap-now", "truth-wall", "wall-band", "matched", "root", "new", "discarded", "waiting",
                   "truth-path", "estimate", "wall", "wall-tentative", "feature", "tentative", "truth-point",
                   "chain-ellipse", "chain", "submap-frame", "beam", "pose", "truth-vehicle", "vehicle"];

const maps = [];  // {hit, render}; zoomed and moved together
let view = d3.zoomIdentity;

/** The box around points, and a little more: [[x, x], [y, y]] in metres. */
function boundsOf(points) {
  return ["x", "y"].map(axis => {
    const [low, high] = d3.extent(points, point => point[axis]);
    const pad = 0.04 * (high - low) + 0.5;
    return [low - pad, high + pad];
  });
}

/** The box around everything certain enough to be looked at. */
const mapBounds = runs => boundsOf(runs.flatMap(run => [
  ...run.states, ...run.truth, ...run.truth_map.filter(f => f.kind === "point"),
  ...run.map.filter(f => f.kind !== "wall" && f.kind !== "undecided" && f.status === "confirmed"),
  ...run.returns.filter(r => r.decision === "matched"), ...cornersOf(run.submaps)]));

/** A plot of this width in which a metre is as long in x as in y: {box, x, y}, the scales in pixels. */
function planeOf(width, [xBounds, yBounds], highest) {
  const aspect = (yBounds[1] - yBounds[0]) / (xBounds[1] - xBounds[0]);
  const box = plotBox(width, Math.min(highest, Math.max(220, 56 + aspect * (width - 62))));
  const scale = Math.min((box.right - box.left) / (xBounds[1] - xBounds[0]),
                         (box.bottom - box.top) / (yBounds[1] - yBounds[0]));
  const span = ([low, high], pixels) =>
      [(low + high - pixels / scale) / 2, (low + high + pixels / scale) / 2];
  return {
    box,
    x: d3.scaleLinear(span(xBounds, box.right - box.left), [box.left, box.right]),
    y: d3.scaleLinear(span(yBounds, box.bottom - box.top), [box.bottom, box.top]),
  };
}

/** Polygon of the 95 % ellipse of a covariance in metres. */
function ellipse(x, y, xx, xy, yy) {
  const middle = (xx + yy) / 2, half = Math.hypot((xx - yy) / 2, xy);
  const a = Math.sqrt(chiSquare95[2] * Math.max(0, middle + half));
  const b = Math.sqrt(chiSquare95[2] * Math.max(0, middle - half));
  const turn = Math.atan2(2 * xy, xx - yy) / 2;
  return d3.range(40).map(i => {
    const u = a * Math.cos(i * Math.PI / 20), v = b * Math.sin(i * Math.PI / 20);
    return [x + u * Math.cos(turn) - v * Math.sin(turn), y + u * Math.sin(turn) + v * Math.cos(turn)];
  });
}

/**
 * A wall n.p = rho with n = (cos alpha, sin alpha), as long as its returns reach, and the band in
 * which it lies with 95 %. Seen from the point at s along the wall, the wall is displaced by
 * d rho - s d alpha; hence the band is curved.
 */
function wallShape(wall, hits) {
  const c = Math.cos(wall.alpha), s = Math.sin(wall.alpha);
  const [from, to] = d3.extent(hits, hit => hit.y * c - hit.x * s);
  if (!(to > from)) return null;
  const at = (along, off) => [(wall.rho + off) * c - along * s, (wall.rho + off) * s + along * c];
  const reach = along => Math.sqrt(chiSquare95[1] *
      Math.max(0, wall.p_xx - 2 * along * wall.p_xy + along * along * wall.p_yy));
  const steps = d3.range(25).map(i => from + (to - from) * i / 24);
  const near = steps.map(along => at(along, -reach(along)));
  const far = steps.map(along => at(along, reach(along)));
  return {ends: [at(from, 0), at(to, 0)], band: [...far, ...near.reverse()]};
}

/** The features at time t: of every submap as it was last seen, and of a feature the latest. */
function featuresAt(run, t) {
  if (t >= run.end || !run.snapshots.length) return run.map;
  const latest = new Map();  // by submap, the latest last
  for (const {submap, features} of until(run.snapshots, t)) {
    latest.delete(submap);
    latest.set(submap, features);
  }
  return [...new Map([...latest.values()].flat().map(f => [f.id, f])).values()];
}

/** The state at time t; before the first the first. */
const stateAt = (run, t) => run.states[Math.max(0, d3.bisector(row => row.t).right(run.states, t) - 1)];

const wallHits = (run, wall, t) => until(run.hits.get(wall.id) || [], t);

const place = row => [row.x, row.y];
const circle = r => `m${-r},0a${r},${r} 0 1,0 ${2 * r},0a${r},${r} 0 1,0 ${-2 * r},0Z`;

/** Of a feature that is no wall: a cylinder is as large as it is. */
function markOf(f, pen) {
  switch (f.kind) {
    case "cylinder": return circle(Math.max(2, pen.pixels(f.radius)));
    case "corner": return "m-5,0h5v-5";
    case "edge": return "m-5,5l5,-5l5,5";
    default: return circle(2);
  }
}

/** What writes path data; x and y turn metres into pixels. */
function penOf(x, y) {
  const px = ([east, north]) => `${x(east).toFixed(1)},${y(north).toFixed(1)}`;
  const open = points => points.length ? `M${points.map(px).join("L")}` : "";
  return {
    open,
    closed: points => `${open(points)}Z`,
    stamp: (rows, shape) => rows.map(row => `M${px(place(row))}${shape}`).join(""),
    pixels: length => +(x(length) - x(0)).toFixed(1),
  };
}

/** Everything on the map at time t as path data by layer; x and y turn metres into pixels. */
function mapShapes(run, t, x, y, bounds) {
  const pen = penOf(x, y), {open, closed, stamp} = pen;
  const shapes = {...Object.fromEntries(mapLayers.map(name => [name, ""])), ...submapShapes(run, t, pen)};
  const returns = d3.nest().key(r => r.decision).object(until(run.returns, t));
  shapes.matched = stamp(returns.matched || [], "h0");
  shapes.root = stamp(returns.root || [], "h0");
  shapes.new = stamp(returns.new || [], circle(4));
  shapes.discarded = stamp(returns.discarded || [], "m-3,-3l6,6m0,-6l-6,6");
  shapes.waiting = stamp(returns.waiting || [], circle(2));

  for (const f of run.truth_map) {
    if (f.kind === "point") shapes["truth-point"] += stamp([f], "m0,-5v10m-5,-5h10");
    else shapes["truth-wall"] += open(lineThrough(f, bounds));
  }
  for (const f of featuresAt(run, t)) {
    const certain = f.status === "confirmed" && f.kind !== "undecided";
    if (f.kind !== "wall") {
      shapes[certain ? "feature" : "tentative"] +=
          closed(ellipse(f.x, f.y, f.p_xx, f.p_xy, f.p_yy)) + stamp([f], markOf(f, pen));
      continue;
    }
    const wall = wallShape(f, wallHits(run, f, t));
    if (wall) {
      shapes[certain ? "wall" : "wall-tentative"] += open(wall.ends);
      shapes["wall-band"] += closed(wall.band);
    }
  }

  const vehicle = (row, shape) => shape.map(([ahead, port]) => {
    const c = Math.cos(row.heading), s = Math.sin(row.heading);
    return `${(x(row.x) + ahead * c - port * s).toFixed(1)},${(y(row.y) - ahead * s - port * c).toFixed(1)}`;
  }).join("L");
  const hull = [[13, 0], [7, 5], [-9, 5], [-9, -5], [7, -5]];
  const state = stateAt(run, t);
  shapes.estimate = open(until(run.states, t).map(place));
  shapes.pose = closed(ellipse(state.x, state.y, state.p_xx, state.p_xy, state.p_yy));
  shapes.vehicle = `M${vehicle(state, hull)}Z`;
  if (run.truth.length) {
    const truth = run.truth[nearest(run.truth, t)];
    shapes["truth-path"] = open(run.truth.map(place));
    shapes["truth-vehicle"] = known(truth.heading) ? `M${vehicle(truth, hull)}Z` : stamp([truth], circle(4));
  }
  shapes.beam = latestReturns(run, t).map(r => open([[r.from_x, r.from_y], [r.x, r.y]])).join("");
  return shapes;
}

/** The returns of the latest instant, while it is at most two seconds old. */
function latestReturns(run, t) {
  const past = until(run.returns, t);
  const last = past.length ? past[past.length - 1].t : -Infinity;
  return t - last > 2 ? [] : past.slice(d3.bisector(row => row.t).left(past, last));
}

/** Two points of an endless wall, beyond everything on the map. */
function lineThrough({rho, alpha}, [[left, right], [low, high]]) {
  const c = Math.cos(alpha), s = Math.sin(alpha);
  const middle = ((low + high) * c - (left + right) * s) / 2, reach = 20 * (right - left + high - low);
  return [middle - reach, middle + reach].map(along => [rho * c - along * s, rho * s + along * c]);
}

/** What lies under the pointer, in words; null for nothing. */
function mapTip(run, t, x, y, [mouseX, mouseY]) {
  let best = {distance: 14, text: null};
  const offer = (east, north, handicap, text) => {
    const distance = Math.hypot(x(east) - mouseX, y(north) - mouseY) + handicap;
    if (distance < best.distance) best = {distance, text};
  };
  for (const f of featuresAt(run, t)) {
    if (f.kind !== "wall") {
      offer(f.x, f.y, 0, () => featureText(run, f));
      continue;
    }
    const wall = wallShape(f, wallHits(run, f, t));
    if (wall) offer(...nearestOf(wall.ends, x.invert(mouseX), y.invert(mouseY)), 1, () => featureText(run, f));
  }
  for (const f of run.truth_map.filter(each => each.kind === "point")) {
    offer(f.x, f.y, 1, () => `true object ${f.id}\nx ${show(f.x)} m, y ${show(f.y)} m`);
  }
  offerSubmaps(run, t, [x.invert(mouseX), y.invert(mouseY)], offer);
  for (const r of until(run.returns, t)) offer(r.x, r.y, 3, () => returnText(r));
  for (const s of until(run.states, t)) offer(s.x, s.y, 5, () => stateText(s));
  for (const s of run.truth) {
    offer(s.x, s.y, 6, () => `truth at ${show(s.t)} s\nx ${show(s.x)} m, y ${show(s.y)} m`);
  }
  return best.text ? best.text() : null;
}

/** The point of the segment [a, b] nearest to (x, y). */
function nearestOf([[ax, ay], [bx, by]], x, y) {
  const dx = bx - ax, dy = by - ay;
  const part = Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy)));
  return [ax + part * dx, ay + part * dy];
}

const spread = (variance, unit = 1) => show(Math.sqrt(Math.max(0, variance)) * unit);

function featureText(run, f) {
  const head = `${f.status} ${f.kind === "undecided" ? "target, point or wall undecided" : f.kind} ${f.id}` +
      (known(f.hits) ? `, ${f.hits} returns` : "") + (run.submaps.length > 1 ? `, submap ${f.submap}` : "");
  return f.kind === "wall"
      ? `${head}\ndistance from origin ${show(f.rho)} m, sd ${spread(f.p_xx)} m\n` +
        `normal at ${show(degrees(f.alpha))} deg, sd ${spread(f.p_yy, 180 / Math.PI)} deg`
      : `${head}\nx ${show(f.x)} m, sd ${spread(f.p_xx)} m\ny ${show(f.y)} m, sd ${spread(f.p_yy)} m` +
        (known(f.radius) ? `\nradius ${show(f.radius)} m, sd ${show(f.sigma_radius)} m` : "") +
        (known(f.scale) ? `\nranges ${show(100 * f.scale)} % too long, sd ${show(100 * f.sigma_scale)} %` : "");
}

const returnText = r =>
    `${r.decision} return${r.feature ? `, feature ${r.feature}` : ""}\n${show(r.t)} s, ${r.channel}\n` +
    `range ${show(r.range)} m, bearing ${show(degrees(r.bearing))} deg` +
    (known(r.gamma) ? `\nNIS ${show(r.gamma)}` : "");

const stateText = s =>
    `estimate at ${show(s.t)} s\nx ${show(s.x)} m, sd ${spread(s.p_xx)} m\n` +
    `y ${show(s.y)} m, sd ${spread(s.p_yy)} m\n` +
    `heading ${show(degrees(s.heading))} deg, sd ${spread(s.p_hh, 180 / Math.PI)} deg` +
    (known(s.speed) ? `\nspeed ${show(s.speed)} m/s` : "");

/** Legend entries of what this run's map holds. */
function mapLegend(run) {
  const has = (rows, test) => rows.some(test);
  const wall = f => f.kind === "wall", point = f => !wall(f) && f.kind !== "undecided";
  const called = kind => f => f.kind === kind;
  const words = {matched: "matched return", new: "new", discarded: "discarded", root: "root", waiting: "waiting"};
  const shapes = {matched: "dot", new: "ring", discarded: "cross", root: "dot", waiting: "ring"};
  return [
    {label: "estimate", shape: "line", className: "estimate"},
    has(run.truth, () => true) && {label: "truth", shape: "line", className: "truth-path"},
    has(run.map, point) && {label: "feature, 95 %", shape: "ring", className: "feature"},
    has(run.map, wall) && {label: "wall", shape: "line", className: "wall"},
    has(run.map, wall) && {label: "its 95 % band", shape: "band", className: "wall-band"},
    has(run.map, f => f.status === "tentative" || f.kind === "undecided") &&
        {label: "tentative or undecided", shape: "ring", className: "tentative"},
    has(run.map, called("cylinder")) && {label: "cylinder, its size", shape: "ring", className: "feature"},
    has(run.map, called("corner")) && {label: "corner", shape: "corner", className: "feature"},
    has(run.map, called("edge")) && {label: "edge", shape: "edge", className: "feature"},
    has(run.truth_map, point) && {label: "true object", shape: "plus", className: "truth-point"},
    has(run.truth_map, wall) && {label: "true wall", shape: "line", className: "truth-wall"},
    ...decisions.filter(name => has(run.returns, r => r.decision === name))
        .map(name => ({label: words[name], shape: shapes[name], className: name})),
    ...submapLegend(run),
  ].filter(Boolean);
}

function mapChart(parent, run, bounds) {
  const map = {hit: null, render: null};
  maps.push(map);
  const about = {name: "map", title: run.title, color: run.color, kind: "map", legend: mapLegend(run)};
  const figure = addChart(parent, about, (svg, width) => {
    const highest = document.body.classList.contains("printing") ? 420 : 640;
    const {box, x: x0, y: y0} = planeOf(width, bounds, highest);
    let x = x0, y = y0;

    const axes = svg.append("g");
    addAxisNames(svg, box, "x (m)", "y (m)");
    const plot = addPlot(svg, box);
    const paths = new Map(mapLayers.map(name => [name, plot.append("path").attr("class", `${name} mark`)]));
    paths.get("pose").attr("class", "feature mark");
    const label = plot.append("text").attr("class", "label halo").attr("text-anchor", "middle");

    let time = clock.now;
    map.render = () => {
      x = view.rescaleX(x0);
      y = view.rescaleY(y0);
      axes.selectAll("*").remove();
      addAxes(axes, box, x, y);
      const shapes = mapShapes(run, time, x, y, bounds);
      paths.forEach((path, name) => path.attr("d", shapes[name] || null));
      labelSubmap(label, run, time, x, y);
    };

    view = d3.zoomIdentity;
    map.hit = svg.append("rect").attr("class", "hit").attr("x", box.left).attr("y", box.top)
        .attr("width", box.right - box.left).attr("height", box.bottom - box.top);
    map.hit.call(mapZoom).style("touch-action", null);
    map.hit.node().addEventListener("mousemove", event =>
        showTip(event, mapTip(run, time, x, y, d3.clientPoint(map.hit.node(), event))));
    map.hit.node().addEventListener("mouseleave", event => showTip(event, null));
    return t => { time = t; map.render(); };
  });
  const buttons = figure.select("figcaption").insert("span", ":first-child").attr("class", "zoom");
  const button = (sign, name, action) => buttons.append("button").attr("type", "button")
      .attr("title", name).attr("aria-label", name).text(sign).on("click", action);
  button("+", "Zoom in", () => map.hit.call(mapZoom.scaleBy, 1.5));
  button("−", "Zoom out", () => map.hit.call(mapZoom.scaleBy, 1 / 1.5));
  button("⤢", "Show all", () => map.hit.call(mapZoom.transform, d3.zoomIdentity));
}

// The wheel and one finger scroll the page; with Ctrl and with two fingers they zoom.
const mapZoom = d3.zoom().scaleExtent([0.3, 60])
    .filter(() => d3.event.type === "wheel" ? d3.event.ctrlKey || d3.event.metaKey
        : d3.event.touches ? d3.event.touches.length > 1 : !d3.event.button)
    .on("zoom", () => {
      view = d3.event.transform;
      for (const map of maps) {
        map.hit.property("__zoom", view);
        map.render();
      }
    });
