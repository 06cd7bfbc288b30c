#include "apps/results/results.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <sstream>
#include <utility>

#include "apps/config/health_words.h"
#include "apps/support/atomic_file.h"
#include "apps/support/version.h"

namespace leadline::app {
namespace {

using Json = nlohmann::ordered_json;

/// A text file of the folder in the making. Numbers are the shortest texts that read back to the same double.
class Text {
 public:
  Text(const ResultFolder& folder, std::string_view file, std::string_view header = {})
      : file_(folder.open(file)) {
    add("{}", header);
  }

  template <class... Args>
  void add(fmt::format_string<Args...> format, Args&&... args) {
    line_.clear();
    fmt::format_to(std::back_inserter(line_), format, std::forward<Args>(args)...);
    file_.write(std::as_bytes(std::span(line_)));
  }

  void commit() { file_.commit(); }

 private:
  AtomicFile file_;
  std::string line_;
};

/// Seconds, exact to the microsecond.
std::string seconds(std::int64_t utime) {
  const bool negative = utime < 0;
  const std::uint64_t us = negative ? -static_cast<std::uint64_t>(utime) : static_cast<std::uint64_t>(utime);
  return fmt::format("{}{}.{:06}", negative ? "-" : "", us / 1'000'000, us % 1'000'000);
}

template <class T>
std::string cell(const std::optional<T>& value) {
  return value ? fmt::format("{}", *value) : "";
}

Json number_or_null(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? Json(*value) : Json(nullptr);
}

std::string_view word(Shape shape) {
  switch (shape) {
    case Shape::point:
      return "point";
    case Shape::corner:
      return "corner";
    case Shape::edge:
      return "edge";
    case Shape::cylinder:
      return "cylinder";
    case Shape::wall:
      return "wall";
    case Shape::undecided:
      break;
  }
  return "undecided";
}

std::string_view word(Decision decision) {
  switch (decision) {
    case Decision::matched:
      return "matched";
    case Decision::fresh:
      return "new";
    case Decision::root:
      return "root";
    case Decision::waiting:
      return "waiting";
    case Decision::discarded:
      break;
  }
  return "discarded";
}

std::string_view word(MapChange::Reason reason) {
  switch (reason) {
    case MapChange::Reason::absent:
      return "absent";
    case MapChange::Reason::displaced:
      return "displaced";
    case MapChange::Reason::joined:
      break;
  }
  return "joined";
}

constexpr Standing kStandings[] = {Standing::ok, Standing::degraded, Standing::lost};

void add_tum_line(Text& text, std::int64_t utime, double x, double y, const std::optional<double>& heading) {
  if (heading)
    text.add("{} {} {} 0 0 0 {} {}\n", seconds(utime), x, y, std::sin(*heading / 2), std::cos(*heading / 2));
  else
    text.add("{} {} {} 0 nan nan nan nan\n", seconds(utime), x, y);
}

void write_trajectory_tum(const ResultFolder& folder, const RunTrace& trace) {
  Text text(folder, "trajectory.tum");
  for (const VehicleState& s : trace.states) add_tum_line(text, s.utime, s.pose.x, s.pose.y, s.pose.heading);
  text.commit();
}

void write_truth_tum(const ResultFolder& folder, const GroundTruth& truth) {
  Text text(folder, "truth.tum");
  for (const Truth& t : truth.track) add_tum_line(text, t.utime, t.x, t.y, t.heading);
  text.commit();
}

void write_states_csv(const ResultFolder& folder, const RunTrace& trace) {
  Text text(folder, "states.csv", "t,submap,x,y,heading,speed,p_xx,p_xy,p_xh,p_yy,p_yh,p_hh\n");
  for (const VehicleState& s : trace.states)
    text.add("{},{},{},{},{},{},{},{},{},{},{},{}\n", seconds(s.utime), s.submap, s.pose.x, s.pose.y,
             s.pose.heading, cell(s.speed), s.P(0, 0), s.P(0, 1), s.P(0, 2), s.P(1, 1), s.P(1, 2), s.P(2, 2));
  text.commit();
}

/// x,y,p_xx,p_xy,p_yy,rho,alpha,radius,sigma_radius,scale,sigma_scale of a feature.
std::string place_cells(const MapFeature& f) {
  if (f.feature.kind == FeatureKind::wall) {
    const Eigen::Matrix2d& P = f.line.P;
    return fmt::format(",,{},{},{},{},{},,,,", P(0, 0), P(0, 1), P(1, 1), f.line.rho, f.line.alpha);
  }
  const auto cells = [&](const Parameter& parameter, TargetShape shape) {
    return f.feature.point_shape == shape ? fmt::format("{},{}", parameter.value, parameter.sigma) : ",";
  };
  return fmt::format("{},{},{},{},{},,,{},{}", f.position.x(), f.position.y(), f.P(0, 0), f.P(0, 1),
                     f.P(1, 1), cells(f.radius, TargetShape::circle), cells(f.scale, TargetShape::scaled));
}

std::string id_cell(int id) { return id < 0 ? "" : fmt::format("{}", id); }

std::string_view status(bool confirmed) { return confirmed ? "confirmed" : "tentative"; }

void write_map_csv(const ResultFolder& folder, const RunTrace& trace) {
  Text text(folder, "map.csv",
            "id,kind,submap,status,hits,x,y,p_xx,p_xy,p_yy,rho,alpha,radius,sigma_radius,scale,sigma_scale,"
            "label\n");
  for (const MapFeature& f : trace.map)
    text.add("{},{},{},{},{},{},{}\n", f.feature.id, word(f.shape), f.submap, status(f.feature.confirmed),
             f.feature.hits, place_cells(f), id_cell(f.feature.label));
  text.commit();
}

void write_map_history_csv(const ResultFolder& folder, const RunTrace& trace) {
  Text text(folder, "map_history.csv",
            "t,submap,id,kind,status,x,y,p_xx,p_xy,p_yy,rho,alpha,radius,sigma_radius,scale,sigma_scale\n");
  for (const RunTrace::Snapshot& snapshot : trace.history) {
    const std::string t = seconds(snapshot.utime);
    for (const MapFeature& f : snapshot.map)
      text.add("{},{},{},{},{},{}\n", t, f.submap, f.feature.id, word(f.shape), status(f.feature.confirmed),
               place_cells(f));
  }
  text.commit();
}

void write_submaps_csv(const ResultFolder& folder, const RunTrace& trace) {
  Text text(
      folder, "submaps.csv",
      "id,parent,previous,root,center_x,center_y,radius,x,y,heading,p_xx,p_xy,p_xh,p_yy,p_yh,p_hh,features,"
      "shared,visits\n");
  for (const SubmapState& s : trace.submaps) {
    const Eigen::Vector2d centre = transform(s.pose.X, s.centre);
    const Eigen::Matrix3d& P = s.pose.P;
    text.add("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", s.id, id_cell(s.parent),
             id_cell(s.previous), id_cell(s.root), centre.x(), centre.y(), cell(s.radius), s.pose.X.x,
             s.pose.X.y, s.pose.X.heading, P(0, 0), P(0, 1), P(0, 2), P(1, 1), P(1, 2), P(2, 2), s.features,
             s.shared, s.visits);
  }
  text.commit();
}

void write_submap_links_csv(const ResultFolder& folder, const RunTrace& trace) {
  Text text(folder, "submap_links.csv", "a,b,sigma\n");
  for (const SubmapGraph::Link& link : trace.graph.links())
    text.add("{},{},{}\n", link.a, link.b, std::sqrt(uncertainty(link.X_ab.P)));
  text.commit();
}

std::string submaps_dot(const RunTrace& trace) {
  std::ostringstream out;
  out << std::setprecision(6);
  std::vector<SubmapGraph::Branch> tree;
  for (const SubmapState& submap : trace.submaps) tree.push_back({submap.parent, submap.shared});
  trace.graph.write_graphviz(out, tree);
  return out.str();
}

void write_associations_csv(const ResultFolder& folder, const RunTrace& trace,
                            std::span<const Sensor> sensors) {
  Text text(folder, "associations.csv", "t,channel,range,bearing,feature,gamma,decision,posterior\n");
  for (const Return& r : trace.returns) {
    const Sensor& sensor = sensors[static_cast<std::size_t>(r.sighting.sensor)];
    const bool judged = r.association.dof > 0;
    text.add("{},{},{},{},{},{},{},{}\n", seconds(trace.states[r.instant].utime), sensor.name,
             r.sighting.range, wrap_angle(sensor.X_BS.heading + r.sighting.bearing),
             r.association.feature >= 0 ? fmt::format("{}", r.association.feature) : "",
             judged ? fmt::format("{}", r.association.gamma) : "", word(r.association.decision),
             r.association.posterior);
  }
  text.commit();
}

void write_changes_csv(const ResultFolder& folder, const RunTrace& trace) {
  Text text(folder, "changes.csv", "t,feature,status,hits,reason,into\n");
  for (const auto& [instant, change] : trace.removals)
    text.add("{},{},{},{},{},{}\n", seconds(trace.states[instant].utime), change.feature,
             status(change.confirmed), change.hits, word(change.reason),
             change.into >= 0 ? fmt::format("{}", change.into) : "");
  text.commit();
}

/// When something was put there and taken away [s], empty where it was not.
std::string life_cells(const Lifetime& life) {
  const std::string from = life.from == Lifetime{}.from ? "" : fmt::format("{}", seconds(life.from));
  const std::string until = life.until == Lifetime{}.until ? "" : fmt::format("{}", seconds(life.until));
  return "," + from + "," + until;
}

void write_truth_map_csv(const ResultFolder& folder, const GroundTruth& truth) {
  const bool changes =
      std::ranges::any_of(truth.map, [](const TrueFeature& f) { return f.life != Lifetime{}; });
  Text text(folder, "truth_map.csv",
            changes ? "id,kind,x,y,rho,alpha,from,until\n" : "id,kind,x,y,rho,alpha\n");
  for (const TrueFeature& f : truth.map) {
    const std::string life = changes ? life_cells(f.life) : "";
    if (f.kind == TargetKind::wall)
      text.add("{},wall,,,{},{}{}\n", f.label, f.rho, f.alpha, life);
    else
      text.add("{},point,{},{},,{}\n", f.label, f.x, f.y, life);
  }
  text.commit();
}

void write_consistency_csv(const ResultFolder& folder, const Judgement& judgement) {
  Text text(folder, "consistency.csv",
            "t,nees,error_x,error_y,error_heading,sigma_x,sigma_y,sigma_heading,wall_error,wall\n");
  for (const Consistency& c : judgement.consistency)
    text.add("{},{},{},{},{},{},{},{},{},{}\n", seconds(c.utime), c.nees, c.error[0], c.error[1], c.error[2],
             c.sigma[0], c.sigma[1], c.sigma[2], cell(c.wall_error), cell(c.wall));
  text.commit();
}

Json step_time_json(std::vector<double> step_times) {
  std::ranges::sort(step_times);
  const auto quantile = [&](double q) {
    if (step_times.empty()) return Json(nullptr);
    return Json(step_times[static_cast<std::size_t>(q * static_cast<double>(step_times.size() - 1))]);
  };
  return {{"step_median_us", quantile(0.5)},
          {"step_p99_us", quantile(0.99)},
          {"step_max_us", quantile(1.0)},
          {"steps", step_times.size()}};
}

long peak_memory_kib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

std::string dump(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"; }

Json sensors_json(std::span<const Sensor> sensors) {
  Json list = Json::array();
  for (const Sensor& s : sensors)
    list.push_back({{"name", s.name},
                    {"mount", {s.X_BS.x, s.X_BS.y, s.X_BS.heading}},
                    {"beam_deg", to_degrees(s.beam_width)}});
  return list;
}

Json health_json(const Health& health) {
  return {{"time_backwards", health.time_backwards},       {"bad_values", health.bad_values},
          {"echoes_dropped", health.echoes_dropped},       {"map_full", health.map_full},
          {"numerical_trouble", health.numerical_trouble}, {"repairs", health.repairs},
          {"changes_untold", health.changes_untold},       {"unplaced", health.unplaced}};
}

/// Shares of the time, by standing.
std::array<double, 3> standing_shares(const RunTrace& trace) {
  std::array<double, 3> shares{};
  double whole = 0.0;
  std::optional<std::int64_t> before;
  for (const VehicleState& state : trace.states) {
    const double dt = 1e-6 * static_cast<double>(state.utime - before.value_or(state.utime));
    shares[static_cast<std::size_t>(state.standing)] += dt;
    whole += dt;
    before = state.utime;
  }
  for (double& share : shares) share = whole > 0.0 ? share / whole : 0.0;
  return shares;
}

Json status_json(const Config& config, const RunTrace& trace) {
  Json status;
  const auto shares = standing_shares(trace);
  for (const Standing standing : kStandings)
    status[std::string(name(standing))] = shares[static_cast<std::size_t>(standing)];
  status["channels"] = Json::array();
  for (const auto& [channel, figures, lag1, counts] : trace.channels)
    status["channels"].push_back(
        {{"channel", channel_name(channel, config.slam.sensors, config.channel_prefix)},
         {"judged", figures.judged},
         {"nis", number_or_null(figures.nis)},
         {"lag1", lag1},
         {"refused", counts.far},
         {"repeated", counts.stuck},
         {"believed_against_estimate", counts.believed}});
  return status;
}

Json refused_labels_json(std::span<const LabelRecord::Refusals> refused, std::span<const Sensor> sensors) {
  Json list = Json::array();
  for (const auto& [sensor, label, count] : refused)
    list.push_back(
        {{"sensor", sensors[static_cast<std::size_t>(sensor)].name}, {"label", label}, {"count", count}});
  return list;
}

Json run_summary(const Config& config, const RunTrace& trace, const Judgement& judgement) {
  Json summary{{"version", kVersion},           {"kind", "run"},
               {"seed", config.seed},           {"config_name", config.name},
               {"filter", name(config.filter)}, {"error", name(config.slam.error)},
               {"map", name(config.map)}};
  for (const Figure& figure : judgement.figures)
    summary["figures"][std::string(figure.key)] = number_or_null(figure.value);
  if (judgement.X_WT)
    summary["truth_alignment"] = {judgement.X_WT->x, judgement.X_WT->y, judgement.X_WT->heading};
  summary["health"] = health_json(trace.health);
  summary["status"] = status_json(config, trace);
  summary["complaints"] = trace.complaints;
  summary["refused_labels"] = refused_labels_json(trace.refused_labels, config.slam.sensors);
  summary["sensors"] = sensors_json(config.slam.sensors);
  summary["table"] = Json::array();
  for (const Figure& figure : judgement.figures)
    if (figure.value) summary["table"].push_back({figure.label, number_or_null(figure.value), figure.unit});
  summary["config"] = to_json(config);
  return summary;
}

Json group_json(const Group& group) {
  Json json{{"config", group.config}, {"filter", group.estimator}, {"figures", Json::object()}};
  for (const Figure& figure : group.trials.front().figures) {
    const std::vector<double> values = values_of(group, figure.key);
    Json& entry = json["figures"][std::string(figure.key)];
    if (values.empty()) continue;  // null
    const Estimate median = median_of(values), mean = mean_of(values);
    entry = {{"median", number_or_null(median.value)}, {"low", number_or_null(median.low)},
             {"high", number_or_null(median.high)},    {"mean", number_or_null(mean.value)},
             {"mean_low", number_or_null(mean.low)},   {"mean_high", number_or_null(mean.high)}};
  }
  return json;
}

void write_trials_csv(const ResultFolder& folder, std::span<const Group> groups) {
  Text text(folder, "trials.csv", "config,filter,trial,seed");
  for (const Figure& figure : groups.front().trials.front().figures) text.add(",{}", figure.key);
  text.add("\n");
  for (const Group& group : groups) {
    for (std::size_t k = 0; k < group.trials.size(); ++k) {
      text.add("{},{},{},{}", group.config, group.estimator, k, group.trials[k].seed);
      for (const Figure& figure : group.trials[k].figures) text.add(",{}", cell(figure.value));
      text.add("\n");
    }
  }
  text.commit();
}

void write_nees_csv(const ResultFolder& folder, std::span<const Group> groups) {
  Text text(folder, "nees.csv", "config,filter,t,nees_mean,band_low,band_high,wall_error_median\n");
  for (const Group& group : groups)
    for (const GroupInstant& i : over_time(group))
      text.add("{},{},{},{},{},{},{}\n", group.config, group.estimator, seconds(i.utime), i.nees_mean,
               i.band.low, i.band.high, cell(i.wall_error_median));
  text.commit();
}

}  // namespace

std::vector<std::vector<std::string>> health_table(const Config& config, const RunTrace& trace) {
  std::vector<std::vector<std::string>> rows;
  const auto shares = standing_shares(trace);
  for (const Standing standing : kStandings)
    rows.push_back({fmt::format("status {}", name(standing)),
                    fmt::format("{:.4g}", shares[static_cast<std::size_t>(standing)]), "of the time"});
  for (const auto& [channel, figures, lag1, counts] : trace.channels) {
    std::string rest;
    if (channel < static_cast<int>(kReadingChannels))
      rest = fmt::format(", lag-1 {:.2f}, {} far, {} repeated, {} against the estimate", lag1, counts.far,
                         counts.stuck, counts.believed);
    rows.push_back({channel_name(channel, config.slam.sensors, config.channel_prefix) + ": NIS (1 expected)",
                    fmt::format("{:.4g}", figures.nis), fmt::format("of {}{}", figures.judged, rest)});
  }
  return rows;
}

std::vector<std::string> health_complaints(const Config& config, const RunTrace& trace) {
  std::vector<std::string> complaints;
  for (const auto& [finding, from, until, time] : trace.troubles)
    complaints.push_back(fmt::format("{} (from {:.1f} s on, {:.1f} s until {:.1f} s)",
                                     sentence(finding, config.slam.sensors, config.channel_prefix), from,
                                     time, until));
  return complaints;
}

std::vector<std::vector<std::string>> run_table(const Judgement& judgement) {
  std::vector<std::vector<std::string>> rows;
  for (const Figure& figure : judgement.figures)
    if (figure.value)
      rows.push_back(
          {std::string(figure.label), fmt::format("{:.4g}", *figure.value), std::string(figure.unit)});
  return rows;
}

void write_run(const ResultFolder& folder, const Config& config, const GroundTruth& truth,
               const RunTrace& trace, const Judgement& judgement, std::span<const double> step_times) {
  write_trajectory_tum(folder, trace);
  write_states_csv(folder, trace);
  write_map_csv(folder, trace);
  write_map_history_csv(folder, trace);
  write_submaps_csv(folder, trace);
  write_submap_links_csv(folder, trace);
  folder.write("submaps.dot", submaps_dot(trace));
  write_associations_csv(folder, trace, config.slam.sensors);
  write_changes_csv(folder, trace);
  if (!truth.track.empty()) write_truth_tum(folder, truth);
  if (!truth.map.empty()) write_truth_map_csv(folder, truth);
  if (!judgement.consistency.empty()) write_consistency_csv(folder, judgement);
  folder.write("summary.json", dump(run_summary(config, trace, judgement)));

  const double cpu = 1e-6 * std::accumulate(step_times.begin(), step_times.end(), 0.0);
  Json timing = step_time_json({step_times.begin(), step_times.end()});
  timing["cpu_s"] = cpu;
  timing["recorded_seconds_per_cpu_second"] = number_or_null(*judgement.value("duration_s") / cpu);
  timing["peak_memory_kib"] = peak_memory_kib();
  folder.write("timing.json", dump(timing));
}

void write_comparison(const ResultFolder& folder, std::span<const Contest> contests,
                      std::span<const Group> groups, std::int64_t first_seed) {
  write_trials_csv(folder, groups);
  write_nees_csv(folder, groups);

  Json summary{{"version", kVersion},
               {"kind", "compare"},
               {"seed", first_seed},
               {"trials", groups.front().trials.size()},
               {"groups", Json::array()}};
  for (const Group& group : groups) summary["groups"].push_back(group_json(group));
  summary["table"] = comparison_table(groups);
  for (const Contest& contest : contests)
    summary["configs"][contest.name] = to_json(contest.contenders.front().config);
  folder.write("summary.json", dump(summary));

  Json timing = Json::array();
  for (const Group& group : groups) {
    std::vector<double> times;
    for (const Trial& trial : group.trials)
      times.insert(times.end(), trial.step_times.begin(), trial.step_times.end());
    Json entry{{"config", group.config}, {"filter", group.estimator}};
    entry.update(step_time_json(std::move(times)));
    timing.push_back(std::move(entry));
  }
  folder.write("timing.json", dump({{"groups", timing}, {"peak_memory_kib", peak_memory_kib()}}));
}

}  // namespace leadline::app
