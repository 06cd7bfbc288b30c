// Submaps: their circles and the chain of their frames on the map, their graph, and the one in use over time.

let submapsShown = true;

const hasCircles = run => run.submaps.some(s => known(s.radius));
const centreOf = s => ({x: s.center_x, y: s.center_y});

/** Corners of the boxes around the circles. */
const cornersOf = submaps => submaps.filter(s => known(s.radius)).flatMap(s => [-s.radius, s.radius]
    .map(r => ({x: s.center_x + r, y: s.center_y + r})));

/** The submap in use at time t; undefined where there is none to draw. */
const submapAt = (run, t) => run.submaps[stateAt(run, t).submap];

const square = half => `m${-half},${-half}h${2 * half}v${2 * half}h${-2 * half}Z`;

const usedUntil = (run, t) => run.submaps.filter(s => known(s.first) && s.first <= t);

/** Square root of the mean square error of a point one metre from the frame's origin. */
const frameSpread = s => Math.sqrt(Math.max(0, s.p_xx + s.p_yy + s.p_hh));

/** The frames that are compounded from submap 0 to this one; submaps that share a frame count once. */
function chainTo(run, submap) {
  const chain = [];
  for (let s = submap; s && chain.length < run.submaps.length; s = run.submaps[s.previous]) chain.push(s);
  return chain.reverse().filter((s, i, all) => i === 0 || s.x !== all[i - 1].x || s.y !== all[i - 1].y);
}

/** At most so many of the rows, evenly, and the last one. */
function someOf(rows, most) {
  const stride = Math.ceil(rows.length / most);
  return rows.filter((_, i) => (rows.length - 1 - i) % stride === 0);
}

/** The submaps' layers of the map at time t as path data. */
function submapShapes(run, t, {open, closed, stamp, pixels}) {
  if (!submapsShown || !hasCircles(run)) return {};
  const used = usedUntil(run, t), now = submapAt(run, t), chain = chainTo(run, now);
  const round = s => stamp([centreOf(s)], circle(pixels(s.radius)));
  const half = s => Math.min(3, pixels(s.radius / 3));  // of a square; one too small to see is left out
  return {
    submap: used.map(round).join(""),
    "submap-now": now ? round(now) : "",
    "submap-frame": used.filter(s => half(s) > 1.5).map(s => stamp([s], square(half(s)))).join(""),
    chain: open(chain.map(place)),
    "chain-ellipse": someOf(chain, 50).map(s => closed(ellipse(s.x, s.y, s.p_xx, s.p_xy, s.p_yy))).join(""),
  };
}

/** Writes the number of the submap in use above its circle. */
function labelSubmap(label, run, t, x, y) {
  const now = submapsShown && hasCircles(run) && submapAt(run, t);
  label.text(now ? `submap ${now.id}` : "");
  if (now) label.attr("x", x(now.center_x)).attr("y", y(now.center_y + now.radius) - 4);
}

/** Offers the origins of the frames and the rims of the circles to what the map says under the pointer. */
function offerSubmaps(run, t, [east, north], offer) {
  if (!submapsShown || !hasCircles(run)) return;
  for (const s of usedUntil(run, t)) {
    offer(s.x, s.y, 2, () => frameText(s));
    const away = Math.hypot(east - s.center_x, north - s.center_y) || 1;
    const reach = s.radius / away;
    offer(s.center_x + reach * (east - s.center_x), s.center_y + reach * (north - s.center_y), 4,
        () => submapText(s));
  }
}

const frameText = s =>
    `frame of submap ${s.id}, at ${known(s.root) ? `feature ${s.root}` : "the vehicle's place then"}\n` +
    `x ${show(s.x)} m, sd ${spread(s.p_xx)} m\ny ${show(s.y)} m, sd ${spread(s.p_yy)} m`;

const submapText = s =>
    `submap ${s.id}${known(s.previous) ? `, reached by ${s.previous}` : ""}\n` +
    `first at ${show(s.first)} s, entered ${s.visits} times\n${s.features} features` +
    (known(s.parent) && known(s.shared) ? `, ${s.shared} of them shared with submap ${s.parent}\n` : "\n") +
    `its frame: sd ${show(frameSpread(s))} m`;

const submapLegend = run => !hasCircles(run) ? [] : [
  {label: "submap", shape: "ring", className: "submap"},
  {label: "in use", shape: "ring", className: "submap-now"},
  {label: "its frame", shape: "square", className: "submap-frame"},
  {label: "frames on the way to it, 95 %", shape: "line", className: "chain"},
];

/** A check box that takes the submaps off the maps. */
function addSubmapSwitch(parent) {
  const label = parent.append("label");
  label.append("input").attr("type", "checkbox").attr("id", "submaps").property("checked", true)
      .on("change", function() {
        submapsShown = this.checked;
        for (const map of maps) map.render();
      });
  label.append("span").text("Submaps");
}

/** A few round steps of lengths in metres: {of: index of a length's step, labels}. */
function stepsOf(name, lengths) {
  const limits = d3.ticks(...d3.extent(lengths), 4).filter(limit => limit > 0).slice(0, 4);
  const limit = i => `${d3.format(".3~r")(limits[i])} m`;
  const label = i => i === 0 ? `${name} below ${limit(0)}`
      : i === limits.length ? `from ${limit(i - 1)}` : `to ${limit(i)}`;
  return {
    of: length => d3.bisectRight(limits, length),
    labels: limits.length ? d3.range(limits.length + 1).map(label) : [name],
  };
}

/** The graph in true geometry: submaps by the uncertainty of their frames, links by their own. */
function submapGraph(parent, run, bounds) {
  const frames = stepsOf("frame", run.submaps.map(frameSpread));
  const links = stepsOf("link", run.submap_links.map(link => link.sigma));
  const color = step => d3.interpolateViridis(0.9 * step / Math.max(1, frames.labels.length - 1));
  const onPath = ({a, b}) => run.submaps[a].previous === b || run.submaps[b].previous === a;
  const vertices = d3.nest().key(s => frames.of(frameSpread(s))).entries(run.submaps);
  const edges = d3.nest().key(link => `link-${links.of(link.sigma)}${onPath(link) ? "" : " aside"}`)
      .entries(run.submap_links);
  const tree = d3.nest().key(s => Math.min(4, Math.ceil(Math.log2(1 + s.shared))))
      .entries(run.submaps.filter(s => known(s.parent) && s.shared > 0));
  const legend = [
    ...frames.labels.map((label, i) => ({label, shape: "dot", className: "vertices", color: color(i)})),
    ...links.labels.map((label, i) => ({label, shape: "line", className: `link link-${i}`})),
    ...tree.length ? [{label: "the tree: the more two share the wider", shape: "line", className: "branch"}] : [],
  ];
  const about = {name: "submap_graph", title: chartTitle(run, "Graph"), color: run.color, legend};
  addChart(parent, about, (svg, width) => {
    const {box, x, y} = planeOf(width, bounds, 480);
    addAxes(svg.append("g"), box, x, y);
    addAxisNames(svg, box, "x (m)", "y (m)");
    const plot = addPlot(svg, box), pen = penOf(x, y);
    const apart = Math.sqrt((box.right - box.left) * (box.bottom - box.top) / run.submaps.length);
    plot.style("--size", Math.min(1, apart / 16));  // many submaps: finer
    for (const {key, values} of edges) {
      plot.append("path").attr("class", `link ${key} mark`).attr("d", values.map(({a, b}) =>
          pen.open([a, b].map(id => place(centreOf(run.submaps[id]))))).join(""));
    }
    for (const {key, values} of tree) {
      plot.append("path").attr("class", "branch mark").style("--width", `${key}px`)
          .attr("d", values.map(s => pen.open([s, run.submaps[s.parent]].map(end => place(centreOf(end))))).join(""));
    }
    for (const {key, values} of vertices) {
      plot.append("path").attr("class", "vertices mark").style("stroke", color(+key))
          .attr("d", dotsPath(values, s => x(s.center_x), s => y(s.center_y)));
    }
    const ring = plot.append("path").attr("class", "vertex-now");
    addVertexHit(svg, box, run, x, y);
    return t => {
      const now = submapAt(run, t);
      ring.attr("d", now ? pen.stamp([centreOf(now)], circle(8)) : null);
    };
  });
}

/** Tells about the submap nearest to the pointer; a click seeks its first use. */
function addVertexHit(svg, box, run, x, y) {
  const hit = svg.append("rect").attr("class", "hit").attr("x", box.left).attr("y", box.top)
      .attr("width", box.right - box.left).attr("height", box.bottom - box.top).node();
  const under = event => {
    const [mouseX, mouseY] = d3.clientPoint(hit, event);
    const distance = s => Math.hypot(x(s.center_x) - mouseX, y(s.center_y) - mouseY);
    const best = run.submaps[d3.scan(run.submaps, (a, b) => distance(a) - distance(b))];
    return distance(best) < 14 ? best : null;
  };
  hit.addEventListener("mousemove", event => {
    const submap = under(event);
    showTip(event, submap && submapText(submap));
  });
  hit.addEventListener("mouseleave", event => showTip(event, null));
  hit.addEventListener("click", event => {
    const submap = under(event);
    if (!submap || !known(submap.first)) return;
    document.dispatchEvent(new CustomEvent("seek", {detail: submap.first}));
  });
}

function submapsOverTime(parent, run) {
  const last = run.submaps.length - 1;
  timeChart(parent, {
    name: "submap_in_use", title: chartTitle(run, "Submap in use"), color: run.color, height: 260,
    yName: "submap", yDomain: [-0.5, last + 0.5], yTicks: d3.ticks(0, last, 6).filter(Number.isInteger),
    dots: [{rows: run.states, value: row => row.submap, color: run.color, label: "submap"}],
  });
}

function addSubmaps(runs) {
  section("Submaps",
      "At the places of their centres: dots by the uncertainty of the submaps' frames along the least " +
      "uncertain path from submap 0, lines by that of the links, pale where no such path goes. Coloured " +
      "lines are the tree along which what is learnt goes from submap to submap. Uncertain " +
      "by how much: root mean square error of a point one metre from the origin of the frame.");
  const bounds = boundsOf(runs.flatMap(run => run.submaps.map(centreOf)));
  const cells = runGrid(runs);
  for (const run of runs) submapGraph(cells, run, bounds);
  for (const run of runs) submapsOverTime(cells, run);
}
