// The time slider.

/** Play button, slider and clock; arrows move the slider, the space bar plays. */
function addControls() {
  const bar = d3.select("#page").append("div").attr("id", "controls");
  const play = bar.append("button").attr("type", "button").attr("id", "play").text("▶ Play");
  const slider = bar.append("input").attr("type", "range").attr("min", 0).attr("max", clock.end)
      .attr("step", clock.end / 1000).attr("aria-label", "Time").property("value", clock.end);
  const output = bar.append("output");
  let timer = null;

  const go = t => {
    setTime(t);
    slider.property("value", clock.now);
    output.text(`${clock.now.toFixed(1)} of ${clock.end.toFixed(1)} s`);
  };
  const stop = () => {
    if (timer) timer.stop();
    timer = null;
    play.text("▶ Play");
  };
  const start = () => {
    const from = clock.now < clock.end ? clock.now : 0;
    play.text("❚❚ Pause");
    timer = d3.timer(elapsed => {
      go(from + elapsed / 20000 * clock.end);  // the whole run in 20 seconds
      if (clock.now >= clock.end) stop();
    });
  };
  const toggle = () => timer ? stop() : start();

  play.on("click", toggle);
  slider.on("input", function() { stop(); go(+this.value); });
  document.addEventListener("seek", event => { stop(); go(event.detail); });
  document.addEventListener("keydown", event => {
    if (event.key === " " && !event.target.closest("button, summary, a")) {
      event.preventDefault();
      toggle();
    } else if (["ArrowLeft", "ArrowRight"].includes(event.key) && event.target === document.body) {
      stop();
      go(Math.max(0, clock.now + (event.key === "ArrowRight" ? 1 : -1) * clock.end / 200));
    }
  });
  go(clock.end);
}
