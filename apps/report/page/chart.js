// The pieces that every chart is made of, and the two general charts: a quantity over time, and the
// spread of a quantity over trials. A chart is drawn again, whole, when the width of its column changes.

const charts = [];  // every chart of the page: {name, svg, draw, setTime}
const clock = {now: Infinity, end: 0};

const swatch = {
  line: "M0,6H22",
  band: "M0,1H22V11H0Z",
  dot: "M11,6h0",
  ring: "M7.5,6a3.5,3.5 0 1,0 7,0a3.5,3.5 0 1,0 -7,0Z",
  cross: "M8,3l6,6m0,-6l-6,6",
  plus: "M11,2v8m-4,-4h8",
  corner: "M6,9h8v-7",
  edge: "M6,9l5,-6l5,6",
  square: "M8,3h6v6h-6Z",
};

/** A value as a reader wants it: three digits, whole numbers as they are. */
function show(value) {
  if (value === null || value === undefined) return "–";
  if (typeof value !== "number") return String(value);
  if (Number.isInteger(value)) return String(value);
  return Math.abs(value) >= 1000 ? value.toFixed(0) : d3.format(".3r")(value);
}

const degrees = angle => angle === null ? null : angle * 180 / Math.PI;
const known = value => value !== null && value !== undefined;

/** Index of the row whose time is nearest to t; rows are sorted by time and not empty. */
function nearest(rows, t) {
  const i = d3.bisector(row => row.t).left(rows, t);
  if (i === 0) return 0;
  return i === rows.length || t - rows[i - 1].t < rows[i].t - t ? i - 1 : i;
}

/** The rows up to and with time t. */
const until = (rows, t) => t >= clock.end ? rows : rows.slice(0, d3.bisector(row => row.t).right(rows, t));

function showTip(event, text) {
  const tip = d3.select("#tip").attr("hidden", text ? null : true).text(text || "");
  if (!text) return;
  const {width, height} = tip.node().getBoundingClientRect();
  const beside = (pointer, size, end) =>
      `${Math.max(4, pointer + 14 + size < end ? pointer + 14 : pointer - 14 - size)}px`;
  tip.style("left", beside(event.clientX, width, window.innerWidth))
      .style("top", beside(event.clientY, height, window.innerHeight));
}

/**
 * Adds a chart to the page.
 * about: {name, title, color, kind, legend: [{label, shape, className, color, dash}]}
 * draw(svg, width) draws it and may return a function that is told the time of the slider.
 */
function addChart(parent, about, draw) {
  const figure = parent.append("figure")
      .attr("class", about.kind || null).style("--run", about.color || null);
  const caption = figure.append("figcaption");
  caption.append("span").attr("class", "title").text(about.title);
  const items = caption.append("span").attr("class", "legend")
      .selectAll("span").data(about.legend || []).join("span");
  items.append("svg").attr("viewBox", "0 0 22 12").append("path")
      .attr("d", item => swatch[item.shape])
      .attr("class", item => item.className)
      .style("stroke", item => item.shape === "band" ? null : item.color)
      .style("fill", item => item.shape === "band" ? item.color : null)
      .style("stroke-dasharray", item => item.dash);
  items.append("span").text(item => item.label);

  const svg = figure.append("svg").attr("role", "img").attr("aria-label", about.title);
  charts.push({name: about.name, svg, draw: () => draw(svg, figure.node().clientWidth), setTime: null});
  return figure;
}

function drawCharts() {
  for (const chart of charts) {
    chart.svg.selectAll("*").remove();
    chart.setTime = chart.draw();
  }
  setTime(clock.now);
}

function setTime(t) {
  clock.now = Math.min(t, clock.end);
  for (const chart of charts) {
    if (chart.setTime) chart.setTime(clock.now);
  }
}

/** Pixel edges of the plot inside an SVG of this size, with room for tick labels and axis names. */
const plotBox = (width, height, left = 48) =>
    ({width, height, left, right: width - 14, top: 20, bottom: height - 36});

/** Axes with grid lines; ticks: {x, y} lists of values or undefined. */
function addAxes(group, box, x, y, ticks = {}) {
  const across = d3.axisBottom(x).ticks(Math.max(3, Math.round((box.right - box.left) / 90)))
      .tickSizeInner(box.top - box.bottom).tickSizeOuter(0).tickPadding(6);
  group.append("g").attr("class", "axis").attr("transform", `translate(0,${box.bottom})`)
      .call(ticks.x ? across.tickValues(ticks.x).tickFormat(d3.format("~r")) : across);
  if (y) {
    const up = d3.axisLeft(y).ticks(Math.max(3, Math.round((box.bottom - box.top) / 40)))
        .tickSizeInner(box.left - box.right).tickSizeOuter(0).tickPadding(6);
    group.append("g").attr("class", "axis").attr("transform", `translate(${box.left},0)`)
        .call(ticks.y ? up.tickValues(ticks.y).tickFormat(d3.format("~r")) : up);
  }
  group.append("rect").attr("class", "frame").attr("x", box.left).attr("y", box.top)
      .attr("width", box.right - box.left).attr("height", box.bottom - box.top);
}

function addAxisNames(svg, box, xName, yName) {
  svg.attr("viewBox", `0 0 ${box.width} ${box.height}`);
  svg.append("text").attr("class", "label").attr("x", box.right).attr("y", box.height - 4)
      .attr("text-anchor", "end").text(xName);
  if (yName) svg.append("text").attr("class", "label").attr("x", 2).attr("y", 11).text(yName);
}

/** A group that shows nothing outside the plot. */
function addPlot(svg, box) {
  const id = `clip-${charts.findIndex(chart => chart.svg === svg)}`;
  svg.append("clipPath").attr("id", id).append("rect").attr("x", box.left).attr("y", box.top)
      .attr("width", box.right - box.left).attr("height", box.bottom - box.top);
  return svg.append("g").attr("clip-path", `url(#${id})`);
}

/** Round values inside a domain, two or three to a power of ten. */
function logTicks([low, high]) {
  const digits = high > 100 * low ? [1, 3] : [1, 2, 5];
  const powers = d3.range(Math.floor(Math.log10(low)), Math.ceil(Math.log10(high)) + 1);
  return powers.flatMap(power => digits.map(digit => +`${digit}e${power}`))
      .filter(value => value >= low && value <= high);
}

/** Dots as one path of many points: thousands of them stay quick. */
const dotsPath = (rows, x, y) => rows.map(row => `M${x(row).toFixed(1)},${y(row).toFixed(1)}h0`).join("");

/**
 * One quantity over time.
 * spec: {name, title, color, legend, height, yName, yDomain, yTicks, scale: "linear" | "log" | "sqrt",
 *        end: last time, for a chart that the slider does not concern,
 *        bands: [{rows, low, high, color, label, unit}],
 *        lines and dots: [{rows, value, color, dash, label, unit}],
 *        levels: [{value, label, color}], labelled in the legend};
 * low, high and value are functions of a row that return null where there is nothing to draw.
 */
function timeChart(parent, spec) {
  const {bands = [], lines = [], dots = [], levels = [], scale = "linear", end = clock.end} = spec;
  const marked = levels.filter(level => level.label)
      .map(level => ({...level, shape: "line", className: "level-line"}));
  const told = [...lines, ...dots,
                ...bands.filter(band => band.label).map(band => ({...band, value: band.high}))];
  addChart(parent, {...spec, legend: [...(spec.legend || []), ...marked]}, (svg, width) => {
    const box = plotBox(width, spec.height || 215);
    const x = d3.scaleLinear([0, end], [box.left, box.right]);
    const y = {linear: d3.scaleLinear, log: d3.scaleLog, sqrt: d3.scaleSqrt}[scale]()
        .domain(spec.yDomain).range([box.bottom, box.top]);
    if (scale === "log") y.clamp(true);
    addAxes(svg.append("g"), box, x, y, {y: scale === "log" ? logTicks(spec.yDomain) : spec.yTicks});
    addAxisNames(svg, box, "time (s)", spec.yName);

    const plot = addPlot(svg, box);
    for (const band of bands) {
      plot.append("path").attr("class", "band").style("fill", band.color)
          .attr("d", d3.area().defined(row => known(band.low(row)) && known(band.high(row)))
              .x(row => x(row.t)).y0(row => y(band.low(row))).y1(row => y(band.high(row)))(band.rows));
    }
    for (const level of levels) {
      plot.append("line").attr("class", "level-line").attr("x1", box.left).attr("x2", box.right)
          .attr("y1", y(level.value)).attr("y2", y(level.value)).style("stroke", level.color);
    }
    for (const line of lines) {
      plot.append("path").attr("class", "line mark")
          .style("stroke", line.color).style("stroke-dasharray", line.dash)
          .attr("d", d3.line().defined(row => known(line.value(row)))
              .x(row => x(row.t)).y(row => y(line.value(row)))(line.rows));
    }
    for (const series of dots) {
      plot.append("path").attr("class", "dots mark").style("stroke", series.color)
          .attr("d", dotsPath(series.rows, row => x(row.t), row => y(series.value(row))));
    }

    const hit = svg.append("rect").attr("class", "hit").attr("x", box.left).attr("y", box.top)
        .attr("width", box.right - box.left).attr("height", box.bottom - box.top).node();
    const timeOf = event => x.invert(box.left + (event.clientX - hit.getBoundingClientRect().left)
        * (box.right - box.left) / hit.getBoundingClientRect().width);
    hit.addEventListener("mousemove", event => showTip(event, timeTip(told, timeOf(event), end / 50)));
    hit.addEventListener("mouseleave", event => showTip(event, null));
    if (spec.end) return null;
    const cursor = plot.append("line").attr("class", "cursor").attr("y1", box.top).attr("y2", box.bottom);
    hit.addEventListener("click", event =>
        document.dispatchEvent(new CustomEvent("seek", {detail: timeOf(event)})));
    return t => cursor.attr("x1", x(t)).attr("x2", x(t));
  });
}

/** The values of all series at time t, if they have one within `reach` of it. */
function timeTip(series, t, reach) {
  const words = [`${show(Math.round(t * 100) / 100)} s`];
  for (const {rows, value, label, unit} of series.filter(each => each.rows.length)) {
    const row = rows[nearest(rows, t)];
    if (known(value(row)) && Math.abs(row.t - t) < reach) {
      words.push(`${label} ${show(value(row))}${unit ? ` ${unit}` : ""}`);
    }
  }
  return words.join("\n");
}

/**
 * The spread of a quantity over trials: one row a group with every trial, quartiles and median.
 * spec: {name, title, xName, groups: [{label, color, values}], level: {value, label} or undefined}
 */
function spreadChart(parent, spec) {
  const all = spec.groups.flatMap(group => group.values);
  const low = d3.min(all), high = d3.max(all);
  const logarithmic = low > 0 && high > 30 * low;
  const rowHeight = 50;
  addChart(parent, spec, (svg, width) => {
    const box = plotBox(width, 56 + rowHeight * spec.groups.length, 10);
    const x = logarithmic ? d3.scaleLog([low / 1.1, high * 1.1], [box.left, box.right])
                          : d3.scaleLinear([Math.min(0, low), high * 1.05 || 1], [box.left, box.right]);
    addAxes(svg.append("g"), box, x, null, logarithmic ? {x: logTicks(x.domain())} : {});
    addAxisNames(svg, box, spec.xName);
    if (spec.level && spec.level.value < x.domain()[1]) {
      svg.append("line").attr("class", "level-line").attr("y1", box.top).attr("y2", box.bottom)
          .attr("x1", x(spec.level.value)).attr("x2", x(spec.level.value));
      svg.append("text").attr("x", x(spec.level.value)).attr("y", box.top - 5).attr("text-anchor", "middle")
          .text(spec.level.label);
    }
    spec.groups.forEach((group, i) => {
      const sorted = group.values.slice().sort(d3.ascending);
      const [q1, median, q3] = [0.25, 0.5, 0.75].map(part => d3.quantile(sorted, part));
      const top = box.top + i * rowHeight;
      const row = svg.append("g").style("stroke", group.color);
      row.append("rect").attr("class", "box").style("fill", group.color)
          .attr("x", x(q1)).attr("width", x(q3) - x(q1)).attr("y", top + 22).attr("height", 20);
      const scatter = trial => top + 25 + 14 * (trial * 0.618034 % 1);  // spread evenly, the same each time
      row.append("path").attr("class", "dots mark")
          .attr("d", dotsPath(group.values.map((value, trial) => ({value, trial})),
              dot => x(dot.value), dot => scatter(dot.trial)));
      row.append("line").attr("x1", x(median)).attr("x2", x(median)).attr("y1", top + 19).attr("y2", top + 45)
          .style("stroke", "var(--ink)").style("stroke-width", 2.5);
      svg.append("text").attr("class", "label halo").attr("x", box.left + 6).attr("y", top + 14)
          .text(`${group.label}: ${show(median)} (${show(q1)} to ${show(q3)})`);
    });
  });
}
