// What runs and comparisons share: unpacking, colours, sections, grids of charts, tables.

const palette = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00"];
const dashes = [null, "7 3", "2 2", "9 3 2 3"];

/** The rows of a table that the program packed by columns. */
function unpack(columns) {
  const names = Object.keys(columns || {});
  const values = names.map(name => columns[name])
      .map(column => column.index ? column.index.map(i => column.names[i]) : column);
  return d3.range(names.length ? values[0].length : 0)
      .map(i => Object.fromEntries(names.map((name, k) => [name, values[k][i]])));
}

/** A colour and a dash for every name; a filter has the same ones on every page. */
function stylesOf(names) {
  const filters = ["ukf", "ekf", "iplf", "ukf_paper"];
  const ordered = [...new Set([...filters.filter(name => names.includes(name)), ...names])];
  return new Map(ordered.map((name, i) =>
      [name, {color: palette[i % palette.length], dash: dashes[i % dashes.length]}]));
}

function section(title, text, parent = d3.select("#page")) {
  parent.append("h2").text(title);
  if (text) parent.append("p").text(text);
  return parent;
}

/** A grid of charts: so many columns on a wide window (of five and more, three); 0 for as many as fit. */
function grid(columns, parent = d3.select("#page")) {
  const cells = parent.append("div").attr("class", "grid");
  return columns ? cells.classed("fixed", true).style("--columns", columns > 4 ? 3 : columns) : cells;
}

/** A column for every run; of one run's charts as many as fit. */
const runGrid = (runs, parent) => grid(runs.length > 1 ? runs.length : 0, parent);

/** An HTML table; numbers stand right. header: [text or {text, color}], rows: [[text or number]]. */
function addTable(parent, header, rows) {
  const numeric = header.map((_, k) => rows.some(row => typeof row[k] === "number"));
  const table = parent.append("div").attr("class", "scroll").append("table");
  const heads = table.append("thead").append("tr").selectAll("th").data(header).join("th")
      .classed("number", (_, k) => numeric[k]);
  heads.filter(cell => cell && cell.color)
      .append("span").attr("class", "swatch").style("background", cell => cell.color);
  heads.append("span").text(cell => cell && cell.color ? cell.text : show(cell));
  table.append("tbody").selectAll("tr").data(rows).join("tr").selectAll("td").data(row => row).join("td")
      .classed("number", (_, k) => numeric[k]).text(show);
  return table;
}

function addNotes(parent, folders) {
  for (const {name, notes} of folders.filter(folder => folder.notes.length)) {
    parent.append("p").attr("class", "note")
        .text(`${name}: long tables are drawn in part, ${notes.join(", ")}.`);
  }
}

/** The largest magnitude, and room above it; at least `least`. */
const room = (values, least) => 1.08 * Math.max(least, d3.max(values.filter(known), Math.abs) || 0);

/** Domain of a logarithmic axis for NEES values and the band from low to high. */
function neesDomain(values, low, high) {
  const sorted = values.filter(known).sort(d3.ascending);
  const lowest = Math.min(low / 1.5, d3.quantile(sorted, 0.02));
  return [Math.max(0.03, lowest), 1.3 * Math.max(high, d3.max(sorted))];
}

const lineKey = (label, {color, dash}) => ({label, shape: "line", className: "line", color, dash});
