// The part of the page about runs: figures, map, errors and consistency, each run beside the others.

const kindColors = {wall: "#7b4fa3", point: "#00796b"};
const degreesOfFreedom = {wall: 1, point: 2};
const neesBand = {low: 0.216, high: 9.348};  // 95 % of one run, 3 degrees of freedom

/** The runs of the folders, with everything the charts ask for. */
function readRuns(folders) {
  const filters = folders.map(folder => folder.summary.filter);
  const byFilter = new Set(filters).size === folders.length && filters.every(Boolean);
  const keys = folders.map((folder, i) => byFilter ? filters[i] : `${i}`);
  const styles = stylesOf(keys);
  return folders.map((folder, i) => {
    const run = {...folder, ...styles.get(keys[i])};
    for (const table of ["states", "truth", "map", "history", "truth_map", "returns", "changes",
                         "consistency", "submaps", "submap_links"]) {
      run[table] = unpack(folder[table]);
    }
    run.alone = folders.length === 1;
    run.label = byFilter ? run.summary.filter.toUpperCase() : run.name;
    run.title = byFilter && !run.alone ? `${run.label} (${run.name})` : run.name;
    run.end = run.states[run.states.length - 1].t;
    run.snapshots = d3.nest().key(f => f.t).entries(run.history)
        .map(({values}) => ({t: values[0].t, submap: values[0].submap, features: values}));
    run.hits = d3.nest().key(r => r.feature).map(run.returns.filter(r => r.feature !== ""));
    return run;
  });
}

/** How every run was made, and the figures that the program printed about it. */
function addRunTable(parent, runs) {
  const facts = [["Configuration", "config_name"], ["Filter", "filter"], ["Error", "error"], ["Map", "map"]]
      .filter(([, key]) => runs.some(run => known(run.summary[key])))
      .map(([name, key]) => [name, ...runs.map(run => run.summary[key]), ""]);
  const same = (a, b) => a[0] === b[0] && a[2] === b[2];
  const labels = runs.flatMap(run => run.summary.table)
      .filter((row, i, all) => all.findIndex(other => same(row, other)) === i);
  const figures = labels.map(row => [row[0], ...runs.map(run => {
    const own = run.summary.table.find(other => same(row, other));
    return own ? own[1] : null;
  }), row[2] || ""]);
  const header = ["", ...runs.map(run => ({text: run.name, color: run.color})), ""];
  addTable(parent, header, [...facts, ...figures])
      .selectAll("tbody tr").classed("fact", (_, i) => i < facts.length);
}

/** What the run found wrong with its sensors and labels. */
function addComplaints(parent, runs) {
  for (const {name, summary, alone} of runs) {
    for (const complaint of summary.complaints || []) {
      parent.append("p").attr("class", "note").text(alone ? `${complaint}.` : `${name}: ${complaint}.`);
    }
  }
}

function addMaps(parent, runs) {
  const words = section("Map", null, parent).append("p").attr("class", "screen")
      .text("Drag to move, Ctrl and wheel or the buttons to zoom, point at things for their numbers. ");
  if (runs.some(hasCircles)) addSubmapSwitch(words);
  const bounds = mapBounds(runs);
  const cells = runGrid(runs, parent).classed("maps", true);
  for (const run of runs) mapChart(cells, run, bounds);
}

const chartTitle = (run, alone) => run.alone ? alone : run.title;

/** Errors of the pose with the bounds of three standard deviations, a row of charts for each axis. */
function addErrors(runs) {
  section("Errors of the pose",
      "Estimate minus truth. Shaded: three standard deviations, as the filter has them.");
  const cells = runGrid(runs);
  const axes = [
    {key: "x", unit: "m", factor: 1, least: 0.01},
    {key: "y", unit: "m", factor: 1, least: 0.01},
    {key: "heading", unit: "deg", factor: 180 / Math.PI, least: 0.1},
  ];
  for (const {key, unit, factor, least} of axes) {
    const times = (value, by) => known(value) ? by * value : null;
    const error = row => times(row[`error_${key}`], factor);
    const bound = row => times(row[`sigma_${key}`], 3 * factor);
    const of = value => runs.flatMap(run => run.consistency.map(value)).filter(known);
    // The bounds of the first instants may be wide; they are cut off.
    const reach = room([...of(error), d3.quantile(of(bound).sort(d3.ascending), 0.98)], least);
    for (const run of runs) {
      timeChart(cells, {
        name: `error_${key}`, title: chartTitle(run, `Error of ${key}`), color: run.color,
        yName: `error of ${key} (${unit})`, yDomain: [-reach, reach],
        bands: [{rows: run.consistency, low: row => times(bound(row), -1), high: bound, color: run.color,
                 label: "3 sd", unit}],
        levels: [{value: 0}],
        lines: [{rows: run.consistency, value: error, color: run.color, label: "error", unit}],
      });
    }
  }
}

const neesBandOf = color =>
    ({rows: [{t: 0}, {t: clock.end}], low: () => neesBand.low, high: () => neesBand.high, color});

function addNees(runs) {
  section("Consistency of the pose: NEES",
      "The squared error in units of the filter's own covariance; 3 is expected. Shaded: where 95 % of an " +
      "honest filter's values lie. Above it the filter is overconfident, below it cautious.");
  const values = runs.flatMap(run => run.consistency.map(row => row.nees));
  const yDomain = neesDomain(values, neesBand.low, neesBand.high);
  const cells = runGrid(runs);
  for (const run of runs) {
    const rows = run.consistency.filter(row => known(row.nees));
    const mean = (run.summary.figures || {}).nees_mean;
    timeChart(cells, {
      name: "nees", title: chartTitle(run, "NEES of the pose"), color: run.color,
      yName: "NEES (log scale)", yDomain, scale: "log",
      bands: [neesBandOf(run.color)],
      lines: [{rows, value: row => row.nees, color: run.color, label: "NEES"}],
      levels: known(mean) ? [{value: mean, label: `mean ${show(mean)}`, color: "var(--ink)"}] : [],
    });
  }
}

/** Kind of the feature that a return matched, as the filter saw it then. */
function kindOf(run, match) {
  const i = d3.bisector(snapshot => snapshot.t).left(run.snapshots, match.t);
  const then = run.snapshots[i] ? run.snapshots[i].features : run.map;
  const feature = then.find(f => f.id === match.feature) || run.map.find(f => f.id === match.feature);
  return feature && feature.kind === "wall" ? "wall" : "point";
}

const withNis = run => run.returns.filter(r => r.decision === "matched" && known(r.gamma));

function addNis(runs) {
  section("Consistency of the returns: NIS",
      "The squared innovation of every matched return in units of its covariance. 19 of 20 should lie " +
      "below the line of their kind.");
  const rows = new Map(runs.map(run => [run, withNis(run).map(r => ({...r, kind: kindOf(run, r)}))]));
  const kinds = ["wall", "point"].filter(kind => runs.some(run => rows.get(run).some(r => r.kind === kind)));
  const highest = room(runs.flatMap(run => rows.get(run).map(r => r.gamma)), chiSquare95[2]);
  const cells = runGrid(runs);
  for (const run of runs) {
    timeChart(cells, {
      name: "nis", title: chartTitle(run, "NIS of the matched returns"), color: run.color,
      yName: "NIS (square-root scale)", yDomain: [0, highest], scale: "sqrt",
      legend: kinds.map(kind => ({label: kind, shape: "dot", className: "dots", color: kindColors[kind]})),
      dots: kinds.map(kind => ({rows: rows.get(run).filter(r => r.kind === kind), value: r => r.gamma,
                                color: kindColors[kind], label: `NIS, ${kind}`})),
      levels: kinds.map(kind => ({value: chiSquare95[degreesOfFreedom[kind]], color: kindColors[kind],
                                  label: `95 %, ${kind}`})),
    });
  }
}

function addWallErrors(runs) {
  section("Error of the walls",
      "At every return matched to a wall: how far the estimated wall lies from the true one abeam of the " +
      "true vehicle; the larger one where two walls are seen.");
  const withError = run => run.consistency.filter(row => known(row.wall_error));
  const yDomain = [0, room(runs.flatMap(run => withError(run).map(row => row.wall_error)), 0.01)];
  const cells = runGrid(runs);
  for (const run of runs) {
    timeChart(cells, {
      name: "wall_error", title: chartTitle(run, "Wall error"), color: run.color,
      yName: "wall error (m)", yDomain,
      lines: [{rows: withError(run), value: row => row.wall_error, color: run.color, label: "wall error",
               unit: "m"}],
    });
  }
}

/** Several runs in one chart for each figure. */
function addOverlays(runs) {
  section("The runs in one chart", "Magnitudes of the errors; NEES with its 95 % band.");
  const cells = grid(2);
  const overlays = [
    {name: "position_error", title: "Position error", yName: "position error (m)", unit: "m",
     value: row => known(row.error_x) && known(row.error_y) ? Math.hypot(row.error_x, row.error_y) : null},
    {name: "heading_error", title: "Heading error", yName: "heading error (deg)", unit: "deg",
     value: row => known(row.error_heading) ? Math.abs(degrees(row.error_heading)) : null},
    {name: "wall_error", title: "Wall error", yName: "wall error (m)", unit: "m",
     value: row => row.wall_error},
    {name: "nees", title: "NEES", yName: "NEES (log scale)", value: row => row.nees, scale: "log",
     bands: [neesBandOf("var(--ink)")]},
  ];
  for (const {name, value, unit, ...spec} of overlays) {
    const values = runs.flatMap(run => run.consistency.map(value)).filter(known);
    if (!values.length) continue;
    timeChart(cells, {
      ...spec, name: `all_${name}`, height: 260,
      yDomain: spec.scale ? neesDomain(values, neesBand.low, neesBand.high) : [0, room(values, 0.01)],
      legend: runs.map(run => lineKey(run.label, run)),
      lines: runs.map(run => ({rows: run.consistency.filter(row => known(value(row))), value, unit,
                               label: run.label, color: run.color, dash: run.dash})),
    });
  }
}

const changeReasons = {absent: "not there", displaced: "made room", joined: "joined"};

/** Every feature that a run removed or joined, folded away behind the number of each kind. */
function addChanges(runs) {
  section("Features removed and joined",
      "Not there: beams that should have met it did not. Made room: it was the least likely one where the map " +
      "was full. Joined: it stood for the same object as another.");
  for (const run of runs) {
    const counts = Object.entries(changeReasons)
        .map(([reason, words]) => `${run.changes.filter(c => c.reason === reason).length} ${words}`);
    const details = d3.select("#page").append("details");
    details.append("summary").text(`${run.alone ? "" : `${run.title}: `}${counts.join(", ")}`);
    addTable(details, ["at (s)", "feature", "status", "returns", "", "to"],
        run.changes.map(c => [c.t, c.feature, c.status, c.hits, changeReasons[c.reason], c.into]));
  }
}

function addConfigurations(runs) {
  const part = d3.select("#page").append("div").attr("class", "screen");
  part.append("h2").text("Configuration");
  for (const {name, summary} of runs) {
    const details = part.append("details");
    details.append("summary")
        .text(`${name}: every setting, defaults included (leadline ${show(summary.version)})`);
    details.append("pre").text(JSON.stringify(summary.config, null, 2));
  }
}

function addRuns(runs) {
  clock.end = d3.max(runs, run => run.end) || 1;
  clock.now = clock.end;

  // The figures stand beside the map of one run, and above the maps of several.
  addControls();
  const overview = d3.select("#page").append("div").attr("class", runs.length > 1 ? null : "overview");
  const figures = overview.append("div"), pictures = overview.append("div");
  addRunTable(figures, runs);
  addComplaints(figures, runs);
  addNotes(figures, runs);
  addMaps(pictures, runs);

  const addFor = (add, has) => {
    const some = runs.filter(has);
    if (some.length) add(some);
  };
  addFor(addSubmaps, run => run.submaps.length > 1);
  addFor(addChanges, run => run.changes.length);
  const hasColumn = name => run => run.consistency.some(row => known(row[name]));
  addFor(addErrors, hasColumn("error_x"));
  addFor(addNees, hasColumn("nees"));
  addFor(addNis, run => withNis(run).length);
  addFor(addWallErrors, hasColumn("wall_error"));
  if (runs.filter(hasColumn("error_x")).length > 1) addOverlays(runs.filter(hasColumn("error_x")));
}
