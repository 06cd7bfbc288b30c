// Builds the page from the data of the result folders.

function main() {
  const folders = JSON.parse(document.getElementById("data").textContent);
  const runs = folders.filter(folder => folder.kind === "run");
  const comparisons = folders.filter(folder => folder.kind === "compare");
  document.title = `leadline: ${folders.map(folder => folder.name).join(", ")}`;
  const title = folders.length > 1 ? "Results side by side" : folders[0].name;
  d3.select("#page").html("").append("h1").text(title);
  if (runs.length) addRuns(readRuns(runs));
  for (const folder of comparisons) addComparison(folder, folders.length > 1 ? folder.name : "Figures");
  if (runs.length) addConfigurations(runs);
  drawCharts();

  let width = window.innerWidth;
  window.addEventListener("resize", () => {
    if (width === window.innerWidth) return;
    width = window.innerWidth;
    window.requestAnimationFrame(drawCharts);
  });
  const print = on => () => {
    document.body.classList.toggle("printing", on);
    drawCharts();
  };
  window.addEventListener("beforeprint", print(true));
  window.addEventListener("afterprint", print(false));
  writeJournal(charts);
}

main();
