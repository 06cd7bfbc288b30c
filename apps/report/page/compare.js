// The part of the page about a comparison over many trials.

const trialFigures = [
  {key: "wall_error_max_m", title: "Largest wall error", xName: "largest wall error (m)"},
  {key: "rmse_position_m", title: "Position RMSE", xName: "RMSE (m)"},
  {key: "rmse_heading_deg", title: "Heading RMSE", xName: "RMSE (deg)"},
  {key: "nees_mean", title: "Mean NEES of the pose", xName: "mean NEES",
   level: {value: 3, label: "3 expected"}},
];

const timeFigures = [
  {name: "trials_nees", value: row => row.nees_mean, scale: "log", title: "Consistency over time",
   yName: "NEES, mean of the trials (log scale)",
   text: "Mean NEES of the pose over the trials. Shaded: where 95 % of an honest estimator's means lie."},
  {name: "trials_wall_error", value: row => row.wall_error_median, title: "Wall error over time",
   yName: "wall error, median of the trials (m)",
   text: "Median over the trials of the wall error at each instant."},
];

/** "UKF global" of "ukf global". */
const estimatorName = name => name.replace(/^\S+/, linearizer => linearizer.toUpperCase());

const rowsOf = (rows, config, estimator) =>
    rows.filter(row => row.config === config && row.filter === estimator);

/** A Monte Carlo comparison: table, spread over the trials, figures over time. */
function addComparison(folder, title) {
  const trials = unpack(folder.trials);
  const configs = [...new Set(trials.map(row => row.config))];
  const estimators = [...stylesOf(trials.map(row => row.filter))];

  const page = section(title, `${show(folder.summary.trials)} trials of every configuration and estimator.`);
  addNotes(page, [folder]);
  addTable(page, folder.summary.table[0], folder.summary.table.slice(1));
  addSpreads(trials, configs, estimators);
  addTimeFigures(unpack(folder.nees), configs, estimators);
}

function addSpreads(trials, configs, estimators) {
  section("Spread over the trials",
      "A dot is a trial, the bar is the median, the box holds the middle half; " +
      "in numbers: median (quartiles).");
  const cells = grid(2);
  for (const {key, ...figure} of trialFigures) {
    const groups = configs.flatMap(config => estimators.map(([estimator, {color}]) => ({
      label: `${configs.length > 1 ? `${config}, ` : ""}${estimatorName(estimator)}`,
      color,
      values: rowsOf(trials, config, estimator).map(row => row[key]).filter(known),
    }))).filter(group => group.values.length);
    if (groups.length) spreadChart(cells, {...figure, name: `trials_${key}`, groups});
  }
}

/** The estimators in one chart for each figure and configuration. */
function addTimeFigures(instants, configs, estimators) {
  const band = [d3.min(instants, row => row.band_low), d3.max(instants, row => row.band_high)];
  for (const {text, value, ...figure} of timeFigures) {
    const values = instants.map(value).filter(known);
    if (!values.length) continue;
    section(figure.title, text);
    const cells = grid(configs.length);
    for (const config of configs) {
      const own = instants.filter(row => row.config === config);
      const bandRows = own.length ? rowsOf(own, config, own[0].filter) : [];
      timeChart(cells, {
        ...figure, title: config, height: 260, end: d3.max(instants, row => row.t),
        yDomain: figure.scale ? neesDomain(values, ...band) : [0, room(values, 0.01)],
        legend: estimators.map(([estimator, style]) => lineKey(estimatorName(estimator), style)),
        bands: !figure.scale ? []
            : [{rows: bandRows, low: row => row.band_low, high: row => row.band_high, color: "var(--ink)"}],
        lines: estimators.map(([estimator, style]) => ({
          ...style, rows: rowsOf(own, config, estimator).filter(row => known(value(row))), value,
          label: estimatorName(estimator),
        })),
      });
    }
  }
}
