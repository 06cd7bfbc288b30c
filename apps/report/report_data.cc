#include "apps/report/report_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "apps/report/csv_table.h"

namespace leadline::app {
namespace {

using namespace std::string_view_literals;
using nlohmann::json;
using std::filesystem::path;

// The page stays below a few megabytes and quick to replay with this many rows of a table.
constexpr std::size_t kMaxStates = 4000;
constexpr std::size_t kMaxReturns = 6000;
constexpr std::size_t kMaxMapRows = 10'000;
constexpr std::size_t kMaxFeatures = 4000;
constexpr std::size_t kMaxSubmaps = 12'000;
constexpr std::size_t kMaxLinks = 30'000;
constexpr std::size_t kMaxChanges = 2000;
constexpr std::size_t kMaxNeesRows = 16'000;

constexpr std::array<std::string_view, 6> kKinds{"point", "corner", "edge", "cylinder", "wall", "undecided"};
constexpr std::array<std::string_view, 2> kTruthKinds{"point", "wall"};
constexpr std::array<std::string_view, 2> kStatuses{"tentative", "confirmed"};
constexpr std::array<std::string_view, 5> kDecisions{"matched", "new", "discarded", "root", "waiting"};

constexpr std::array<std::string_view, 3> kReasons{"absent", "displaced", "joined"};

using RowList = std::vector<std::size_t>;

RowList all_rows(std::size_t rows) {
  RowList kept(rows);
  std::iota(kept.begin(), kept.end(), std::size_t{0});
  return kept;
}

/// A thinning is noted. @param what is left out: rows or instants.
void note_thinning(const CsvTable& table, std::string_view what, json& notes) {
  if (table.stride() > 1) {
    notes.push_back(fmt::format("1 of {} {} of {}", table.stride(), what, table.file().filename().string()));
  }
}

// NaN becomes null in JSON.
json rounded(double value, double scale) { return std::round(value * scale) / scale; }

/// Lengths and angles: 5 decimals.
json decimals(const std::vector<double>& values, const RowList& rows) {
  json packed = json::array();
  for (const std::size_t row : rows) {
    packed.push_back(rounded(values[row], 1e5));
  }
  return packed;
}

/// Variances and ratios: 5 digits; what is below the square of a micrometre is zero.
json digits(const std::vector<double>& values, const RowList& rows) {
  json packed = json::array();
  for (const std::size_t row : rows) {
    const double magnitude = std::abs(values[row]);
    packed.push_back(magnitude < 1e-12
                         ? json(0.0)
                         : rounded(values[row], std::pow(10.0, 4.0 - std::floor(std::log10(magnitude)))));
  }
  return packed;
}

json dictionary(const std::vector<std::string>& values, const RowList& rows) {
  json names = json::array();
  json indices = json::array();
  std::map<std::string, std::size_t> known;
  for (const std::size_t row : rows) {
    const auto [entry, is_new] = known.try_emplace(values[row], known.size());
    if (is_new) {
      names.push_back(values[row]);
    }
    indices.push_back(entry->second);
  }
  return {{"names", std::move(names)}, {"index", std::move(indices)}};
}

std::vector<double> since(double start, std::vector<double> times) {
  for (double& t : times) {
    t -= start;
  }
  return times;
}

struct PoseTrack {
  std::vector<double> t;
  std::vector<double> x;
  std::vector<double> y;
  std::vector<double> heading;
};

/// All states, however many, for what is between them.
PoseTrack read_track(const path& file) {
  std::vector<std::vector<double>> columns = read_columns(file, std::array{"t"sv, "x"sv, "y"sv, "heading"sv});
  if (columns.front().empty()) {
    throw std::runtime_error(fmt::format("{}: there are no states", file.string()));
  }
  return {std::move(columns[0]), std::move(columns[1]), std::move(columns[2]), std::move(columns[3])};
}

struct Pose {
  double x;
  double y;
  double heading;
};

/// The pose at time t between two states; before the first and after the last their own.
Pose pose_at(const PoseTrack& track, double t) {
  const auto next = static_cast<std::size_t>(std::ranges::upper_bound(track.t, t) - track.t.begin());
  if (next == 0 || next == track.t.size()) {
    const std::size_t end = next == 0 ? 0 : next - 1;
    return {track.x[end], track.y[end], track.heading[end]};
  }
  const std::size_t i = next - 1;
  const double part = (t - track.t[i]) / (track.t[next] - track.t[i]);
  const double turn = std::remainder(track.heading[next] - track.heading[i], 2.0 * std::numbers::pi);
  return {std::lerp(track.x[i], track.x[next], part), std::lerp(track.y[i], track.y[next], part),
          track.heading[i] + part * turn};
}

json read_json(const path& file) {
  std::ifstream in(file);
  if (!in) {
    throw std::runtime_error(fmt::format("{}: {}", file.string(), std::strerror(errno)));
  }
  try {
    json parsed = json::parse(in);
    if (!parsed.is_object()) {
      throw std::runtime_error(fmt::format("{}: a JSON object is expected", file.string()));
    }
    return parsed;
  } catch (const json::exception& error) {
    throw std::runtime_error(fmt::format("{}: {}", file.string(), error.what()));
  }
}

/// The printed table: rows of texts, numbers and nulls, `width` of them in each row if it is not 0.
void check_table(const json& summary, std::size_t width, const path& file) {
  const auto table = summary.find("table");
  const bool sound =
      table != summary.end() && table->is_array() && std::ranges::all_of(*table, [&](const json& row) {
        return row.is_array() && !row.empty() && (width == 0 || row.size() == width) &&
               std::ranges::all_of(row, [](const json& cell) {
                 return cell.is_string() || cell.is_number() || cell.is_null();
               });
      });
  if (!sound) {
    throw std::runtime_error(
        fmt::format("{}: key 'table': an array of rows is expected, each an array of {}texts, "
                    "numbers or nulls",
                    file.string(), width == 0 ? "" : fmt::format("{} ", width)));
  }
}

/// What the page says below its table; runs of before have none.
void check_complaints(const json& summary, const path& file) {
  const json complaints = summary.value("complaints", json::array());
  const auto is_text = [](const json& complaint) { return complaint.is_string(); };
  if (!complaints.is_array() || !std::ranges::all_of(complaints, is_text))
    throw std::runtime_error(fmt::format("{}: key 'complaints': texts are expected", file.string()));
}

struct Mount {
  std::string sensor;
  double x;
  double y;
};

std::vector<Mount> read_mounts(const json& summary, const path& file) {
  std::vector<Mount> mounts;
  try {
    for (const json& sensor : summary.value("sensors", json::array())) {
      const json& mount = sensor.at("mount");
      mounts.push_back(
          {sensor.at("name").get<std::string>(), mount.at(0).get<double>(), mount.at(1).get<double>()});
    }
  } catch (const json::exception& error) {
    throw std::runtime_error(fmt::format("{}: key 'sensors': each needs a name and a mount [x, y, yaw]; {}",
                                         file.string(), error.what()));
  }
  return mounts;
}

bool has_column(const CsvTable& table, std::string_view column) {
  return std::ranges::find(table.columns(), column) != table.columns().end();
}

/// Features in W of map.csv, map_history.csv or truth_map.csv, each kind with the numbers it needs.
json pack_features(const CsvTable& table, const RowList& rows, std::span<const std::string_view> kinds,
                   bool with_covariance) {
  const std::vector<std::string> kind = table.texts("kind", kinds);
  json packed{{"id", dictionary(table.texts("id"), rows)}, {"kind", dictionary(kind, rows)}};

  const auto add = [&](const char* column, auto pack, auto applies) {
    const std::vector<double> values = table.numbers(column);
    for (std::size_t row = 0; row < values.size(); ++row) {
      if (applies(kind[row]) && std::isnan(values[row])) {
        table.fail(row, fmt::format("column '{}': a {} needs it", column, kind[row]));
      }
    }
    packed[column] = pack(values, rows);
  };
  const auto wall = [](const std::string& name) { return name == "wall"; };
  const auto point = [](const std::string& name) { return name != "wall"; };
  const auto any = [](const std::string&) { return true; };
  const auto none = [](const std::string&) { return false; };
  add("x", decimals, point);
  add("y", decimals, point);
  add("rho", decimals, wall);
  add("alpha", decimals, wall);
  if (with_covariance) {
    add("p_xx", digits, any);
    add("p_xy", digits, any);
    add("p_yy", digits, any);
    packed["status"] = dictionary(table.texts("status", kStatuses), rows);
  }
  const auto cylinder = [](const std::string& name) { return name == "cylinder"; };
  if (has_column(table, "radius")) {
    add("radius", decimals, cylinder);
    add("sigma_radius", digits, cylinder);
  }
  if (has_column(table, "scale")) {
    add("scale", digits, none);
    add("sigma_scale", digits, none);
  }
  if (has_column(table, "submap")) {
    packed["submap"] = decimals(table.finite_numbers("submap"), rows);
  }
  return packed;
}

json pack_states(const path& file, double start, json& notes) {
  const CsvTable table = CsvTable::with_header(file, {kMaxStates});
  note_thinning(table, "rows", notes);
  const RowList rows = all_rows(table.rows());
  json packed{{"t", decimals(since(start, table.times("t")), rows)},
              {"x", decimals(table.finite_numbers("x"), rows)},
              {"y", decimals(table.finite_numbers("y"), rows)},
              {"heading", decimals(table.finite_numbers("heading"), rows)},
              {"speed", decimals(table.numbers("speed"), rows)}};
  for (const char* column : {"p_xx", "p_xy", "p_yy", "p_hh"}) {
    packed[column] = digits(table.finite_numbers(column), rows);
  }
  if (has_column(table, "submap")) {
    packed["submap"] = decimals(table.finite_numbers("submap"), rows);
  }
  return packed;
}

json pack_map(const path& file, json& notes) {
  const CsvTable table = CsvTable::with_header(file, {kMaxFeatures});
  note_thinning(table, "rows", notes);
  const RowList rows = all_rows(table.rows());
  json packed = pack_features(table, rows, kKinds, true);
  packed["hits"] = decimals(table.finite_numbers("hits"), rows);
  return packed;
}

json pack_history(const path& file, double start, json& notes) {
  const CsvTable table = CsvTable::with_header(file, {kMaxMapRows, "t"});
  note_thinning(table, "instants", notes);
  const RowList rows = all_rows(table.rows());
  json packed = pack_features(table, rows, kKinds, true);
  packed["t"] = decimals(since(start, table.times("t")), rows);
  return packed;
}

json pack_truth_map(const path& file, json& notes) {
  const CsvTable table = CsvTable::with_header(file, {kMaxFeatures});
  note_thinning(table, "rows", notes);
  return pack_features(table, all_rows(table.rows()), kTruthKinds, false);
}

bool is_submap(double value, std::size_t count) {
  return value >= 0.0 && value < static_cast<double>(count) && value == std::floor(value);
}

std::string no_submap(double value, std::size_t count) {
  return fmt::format("{} is not one of the {} submaps", value, count);
}

/// Fails unless every value is the number of one of `count` submaps; NaN stands for none.
void check_submap_numbers(const CsvTable& table, const char* column, const std::vector<double>& values,
                          std::size_t count) {
  for (std::size_t row = 0; row < values.size(); ++row) {
    if (!is_submap(values[row], count) && !std::isnan(values[row])) {
      table.fail(row, fmt::format("column '{}': {}", column, no_submap(values[row], count)));
    }
  }
}

/// When each submap was first in use; NaN: never.
std::vector<double> first_uses(const path& states, double start, std::size_t submaps) {
  const std::vector<std::vector<double>> columns = read_columns(states, std::array{"t"sv, "submap"sv});
  const std::vector<double>&t = columns[0], &in_use = columns[1];
  std::vector<double> first(submaps, std::numeric_limits<double>::quiet_NaN());
  for (std::size_t row = 0; row < t.size(); ++row) {
    if (!is_submap(in_use[row], submaps)) {
      throw std::runtime_error(fmt::format("{}:{}: column 'submap': {}", states.string(), row + 2,
                                           no_submap(in_use[row], submaps)));
    }
    double& own = first[static_cast<std::size_t>(in_use[row])];
    own = std::isnan(own) ? t[row] - start : own;
  }
  return first;
}

/// Submaps as they were at the end; the row of a submap is its number.
json pack_submaps(const CsvTable& table, const std::vector<double>& first, json& notes) {
  const std::vector<double> id = table.finite_numbers("id");
  for (std::size_t row = 0; row < id.size(); ++row) {
    if (id[row] != static_cast<double>(row)) {
      table.fail(row, fmt::format("column 'id': {} where {} is expected", id[row], row));
    }
  }
  const std::vector<double> previous = table.numbers("previous");
  check_submap_numbers(table, "previous", previous, table.rows());

  const RowList rows = all_rows(std::min(table.rows(), kMaxSubmaps));
  if (rows.size() < table.rows()) {
    notes.push_back(fmt::format("the first {} of {} submaps", rows.size(), table.rows()));
  }
  json packed{{"id", decimals(id, rows)},
              {"previous", decimals(previous, rows)},
              {"root", decimals(table.numbers("root"), rows)},
              {"radius", decimals(table.numbers("radius"), rows)},
              {"first", decimals(first, rows)}};
  for (const char* column : {"center_x", "center_y", "x", "y", "features", "visits"}) {
    packed[column] = decimals(table.finite_numbers(column), rows);
  }
  for (const char* column : {"p_xx", "p_xy", "p_yy", "p_hh"}) {
    packed[column] = digits(table.finite_numbers(column), rows);
  }
  if (std::ranges::find(table.columns(), "shared") != table.columns().end()) {
    const std::vector<double> parent = table.numbers("parent");
    check_submap_numbers(table, "parent", parent, table.rows());
    packed["parent"] = decimals(parent, rows);
    packed["shared"] = decimals(table.finite_numbers("shared"), rows);
  }
  return packed;
}

/// Links of the submaps that are drawn.
json pack_submap_links(const path& file, std::size_t submaps, json& notes) {
  const CsvTable table = CsvTable::with_header(file, {kMaxLinks});
  note_thinning(table, "rows", notes);
  const std::vector<double> a = table.finite_numbers("a");
  const std::vector<double> b = table.finite_numbers("b");
  check_submap_numbers(table, "a", a, submaps);
  check_submap_numbers(table, "b", b, submaps);
  RowList rows = all_rows(table.rows());
  std::erase_if(rows, [&](std::size_t row) { return std::max(a[row], b[row]) >= kMaxSubmaps; });
  return {{"a", decimals(a, rows)},
          {"b", decimals(b, rows)},
          {"sigma", digits(table.finite_numbers("sigma"), rows)}};
}

json pack_truth(const path& file, double start, json& notes) {
  const CsvTable table = CsvTable::tum(file, {kMaxStates});
  note_thinning(table, "rows", notes);
  const RowList rows = all_rows(table.rows());
  const std::vector<double> qx = table.numbers("qx");
  const std::vector<double> qy = table.numbers("qy");
  const std::vector<double> qz = table.numbers("qz");
  const std::vector<double> qw = table.numbers("qw");
  std::vector<double> heading(table.rows());
  for (std::size_t i = 0; i < heading.size(); ++i) {
    heading[i] =
        std::atan2(2.0 * (qw[i] * qz[i] + qx[i] * qy[i]), 1.0 - 2.0 * (qy[i] * qy[i] + qz[i] * qz[i]));
  }
  return {{"t", decimals(since(start, table.times("t")), rows)},
          {"x", decimals(table.finite_numbers("x"), rows)},
          {"y", decimals(table.finite_numbers("y"), rows)},
          {"heading", decimals(heading, rows)}};
}

/// Returns with the place of their sensor (from_x, from_y) and of the target (x, y) in W, both as
/// the estimated pose of their instant has them.
json pack_returns(const path& file, const PoseTrack& track, const std::vector<Mount>& mounts, double start,
                  json& notes) {
  const CsvTable table = CsvTable::with_header(file, {kMaxReturns, "t"});
  note_thinning(table, "instants", notes);
  const std::vector<double> t = table.times("t");
  const std::vector<std::string> channel = table.texts("channel");
  const std::vector<double> range = table.finite_numbers("range");
  const std::vector<double> bearing = table.finite_numbers("bearing");

  std::vector<double> from_x(table.rows());
  std::vector<double> from_y(table.rows());
  std::vector<double> x(table.rows());
  std::vector<double> y(table.rows());
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const auto found = std::ranges::find(mounts, channel[i], &Mount::sensor);
    const Mount mount = found != mounts.end() ? *found : Mount{channel[i], 0.0, 0.0};
    const Pose pose = pose_at(track, t[i]);
    const double c = std::cos(pose.heading);
    const double s = std::sin(pose.heading);
    from_x[i] = pose.x + c * mount.x - s * mount.y;
    from_y[i] = pose.y + s * mount.x + c * mount.y;
    x[i] = from_x[i] + range[i] * std::cos(pose.heading + bearing[i]);
    y[i] = from_y[i] + range[i] * std::sin(pose.heading + bearing[i]);
  }

  const RowList rows = all_rows(table.rows());
  return {{"t", decimals(since(start, t), rows)},
          {"channel", dictionary(channel, rows)},
          {"range", decimals(range, rows)},
          {"bearing", decimals(bearing, rows)},
          {"feature", dictionary(table.texts("feature"), rows)},
          {"gamma", digits(table.numbers("gamma"), rows)},
          {"decision", dictionary(table.texts("decision", kDecisions), rows)},
          {"from_x", decimals(from_x, rows)},
          {"from_y", decimals(from_y, rows)},
          {"x", decimals(x, rows)},
          {"y", decimals(y, rows)}};
}

/// Features removed and joined; of very many, the last.
json pack_changes(const path& file, double start, json& notes) {
  const CsvTable table = CsvTable::with_header(file);
  RowList rows = all_rows(table.rows());
  if (rows.size() > kMaxChanges) {
    rows.erase(rows.begin(), rows.end() - kMaxChanges);
    notes.push_back(fmt::format("the last {} of {} rows of {}", rows.size(), table.rows(),
                                table.file().filename().string()));
  }
  return {{"t", decimals(since(start, table.times("t")), rows)},
          {"feature", dictionary(table.texts("feature"), rows)},
          {"status", dictionary(table.texts("status", kStatuses), rows)},
          {"hits", decimals(table.finite_numbers("hits"), rows)},
          {"reason", dictionary(table.texts("reason", kReasons), rows)},
          {"into", dictionary(table.texts("into"), rows)}};
}

json pack_consistency(const path& file, double start, json& notes) {
  const CsvTable table = CsvTable::with_header(file, {kMaxStates});
  note_thinning(table, "rows", notes);
  const RowList rows = all_rows(table.rows());
  json packed{{"t", decimals(since(start, table.times("t")), rows)}};
  for (const char* column :
       {"nees", "error_x", "error_y", "error_heading", "sigma_x", "sigma_y", "sigma_heading", "wall_error"}) {
    packed[column] = digits(table.numbers(column), rows);
  }
  return packed;
}

json pack_run(const path& folder, json summary) {
  const path summary_file = folder / "summary.json";
  check_table(summary, 3, summary_file);
  check_complaints(summary, summary_file);
  const std::vector<Mount> mounts = read_mounts(summary, summary_file);

  const path states = folder / "states.csv";
  const PoseTrack track = read_track(states);
  const double start = track.t.front();

  json notes = json::array();
  json run{{"summary", std::move(summary)},
           {"states", pack_states(states, start, notes)},
           {"map", pack_map(folder / "map.csv", notes)},
           {"returns", pack_returns(folder / "associations.csv", track, mounts, start, notes)}};
  if (const path file = folder / "changes.csv"; exists(file)) {
    run["changes"] = pack_changes(file, start, notes);
  }
  if (const path file = folder / "map_history.csv"; exists(file)) {
    run["history"] = pack_history(file, start, notes);
  }
  if (const path file = folder / "submaps.csv"; exists(file)) {
    const CsvTable submaps = CsvTable::with_header(file);
    const std::vector<double> first = first_uses(states, start, submaps.rows());
    run["submaps"] = pack_submaps(submaps, first, notes);
    run["submap_links"] = pack_submap_links(folder / "submap_links.csv", submaps.rows(), notes);
  }
  if (const path file = folder / "truth.tum"; exists(file)) {
    run["truth"] = pack_truth(file, start, notes);
  }
  if (const path file = folder / "truth_map.csv"; exists(file)) {
    run["truth_map"] = pack_truth_map(file, notes);
  }
  if (const path file = folder / "consistency.csv"; exists(file)) {
    run["consistency"] = pack_consistency(file, start, notes);
  }
  run["notes"] = std::move(notes);
  return run;
}

/// Configuration and estimator of every row, and all other columns as numbers.
json pack_groups(const CsvTable& table, const RowList& rows) {
  json packed = json::object();
  for (const std::string& column : table.columns()) {
    packed[column] = column == "config" || column == "filter" ? dictionary(table.texts(column), rows)
                                                              : digits(table.numbers(column), rows);
  }
  return packed;
}

json pack_comparison(const path& folder, json summary) {
  check_table(summary, 0, folder / "summary.json");
  const CsvTable trials = CsvTable::with_header(folder / "trials.csv");
  const CsvTable nees = CsvTable::with_header(folder / "nees.csv", {kMaxNeesRows});
  json notes = json::array();
  note_thinning(nees, "rows", notes);
  json packed_nees = pack_groups(nees, all_rows(nees.rows()));
  return {{"summary", std::move(summary)},
          {"trials", pack_groups(trials, all_rows(trials.rows()))},
          {"nees", std::move(packed_nees)},
          {"notes", std::move(notes)}};
}

/// The last part of the folder's name, also of "results/ukf/" and of ".".
std::string folder_name(const path& folder) {
  const path whole = std::filesystem::weakly_canonical(folder);
  return whole.has_filename() ? whole.filename().string() : whole.parent_path().filename().string();
}

}  // namespace

json read_result_folder(const path& folder) {
  if (!is_directory(folder)) {
    throw std::runtime_error(fmt::format("{}: no such folder", folder.string()));
  }
  json summary = read_json(folder / "summary.json");
  const json kind = summary.value("kind", json("run"));
  json data;
  if (kind == "run") {
    data = pack_run(folder, std::move(summary));
  } else if (kind == "compare") {
    data = pack_comparison(folder, std::move(summary));
  } else {
    throw std::runtime_error(fmt::format("{}: key 'kind': {} is neither \"run\" nor \"compare\"",
                                         (folder / "summary.json").string(), kind.dump()));
  }
  data["kind"] = kind;
  data["name"] = folder_name(folder);
  return data;
}

}  // namespace leadline::app
