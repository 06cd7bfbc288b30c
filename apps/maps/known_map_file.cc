#include "apps/maps/known_map_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <stdexcept>
#include <string>
#include <string_view>

#include "apps/maps/map_file.h"
#include "apps/recordings/csv_reader.h"
#include "apps/support/limits.h"
#include "leadline/submap/slam.h"

namespace leadline::app {
namespace {

namespace fs = std::filesystem;

/// Columns that a map may have beside its ids, as they are numbered below.
constexpr std::size_t kId = 0, kX = 1, kY = 2, kKind = 3, kStatus = 4, kHits = 5, kPxx = 6, kPxy = 7,
                      kPyy = 8, kRho = 9, kAlpha = 10, kLabel = 11, kSigma = 12;
constexpr std::string_view kMore =
    "kind,status,hits,p_xx,p_xy,p_yy,rho,alpha,label,sigma,submap,radius,sigma_radius,scale,sigma_scale";

double number_or_zero(const CsvReader& csv, std::size_t column, Limits limits) {
  return csv.optional_number(column, limits).value_or(0.0);
}

Eigen::Matrix2d covariance(const CsvReader& csv) {
  const double sigma = number_or_zero(csv, kSigma, limits::kSigma);
  Eigen::Matrix2d P = sigma * sigma * Eigen::Matrix2d::Identity();
  const double xy = number_or_zero(csv, kPxy, limits::kCovariance);
  P(0, 0) += number_or_zero(csv, kPxx, limits::kCovariance);
  P(1, 1) += number_or_zero(csv, kPyy, limits::kCovariance);
  P(0, 1) = P(1, 0) = xy;
  return P;
}

MapFeature feature(const CsvReader& csv) {
  MapFeature known;
  const std::optional<int> id = csv.optional_label(kId);
  if (!id) csv.refuse(kId, "a whole number from 0 on");
  known.feature.id = *id;
  known.feature.hits = static_cast<int>(number_or_zero(csv, kHits, limits::kQuantity));
  // Landmarks are their labels; of the features of a run the labels stand beside their numbers.
  const bool is_landmark = csv.text(kKind).empty();
  known.feature.label = csv.optional_label(kLabel).value_or(is_landmark ? *id : Sighting::kUnknown);
  const bool is_wall = csv.text(kKind) == "wall";
  known.feature.kind = is_wall ? FeatureKind::wall : FeatureKind::point;
  known.feature.confirmed = true;
  known.feature.existence.add(Existence::kConfirmed);
  if (is_wall) {
    known.line = {csv.number(kRho, limits::kPosition), csv.number(kAlpha, limits::kHeading), covariance(csv)};
    known.position = known.line.rho * Eigen::Vector2d(std::cos(known.line.alpha), std::sin(known.line.alpha));
  } else {
    known.position = {csv.number(kX, limits::kPosition), csv.number(kY, limits::kPosition)};
    known.P = covariance(csv);
  }
  return known;
}

/// Where walls end is not told: as far off as anything else.
void end_walls(FeatureMap& map) {
  for (MapFeature& wall : map) {
    if (wall.feature.kind != FeatureKind::wall) continue;
    double farthest = 1.0;  // [m]
    for (const MapFeature& other : map)
      farthest = std::max(farthest, (other.position - wall.position).norm());
    wall.feature.seen = {-farthest, farthest};
  }
}

FeatureMap read_features(const fs::path& path) {
  CsvReader csv(path, "id,x,y", kMore);
  FeatureMap map;
  while (csv.next()) {
    const std::string_view status = csv.text(kStatus);
    if (status.empty() || status == "confirmed") map.push_back(feature(csv));
  }
  end_walls(map);
  if (map.empty())
    throw std::runtime_error(fmt::format("{}: holds no feature that is confirmed", path.string()));
  return map;
}

std::variant<Snapshot, FeatureMap> read(const fs::path& path) {
  if (!is_map_file(path)) return read_features(path);
  return read_map(path);
}

}  // namespace

KnownMapFile::KnownMapFile(const fs::path& path)
    : path_(fs::is_directory(path) ? path / "map.csv" : path), map_(read(path_)) {}

Snapshot KnownMapFile::begin(const SlamOptions& options, std::int64_t utime) const {
  try {
    return std::visit([&](const auto& map) { return known_map(options, map, utime); }, map_);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(fmt::format("{}: {}", path_.string(), error.what()));
  }
}

FeatureMap KnownMapFile::features(const SlamOptions& options) const {
  if (const auto* features = std::get_if<FeatureMap>(&map_)) return *features;
  try {
    return world_map(Slam(options, std::get<Snapshot>(map_)));
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(fmt::format("{}: {}", path_.string(), error.what()));
  }
}

}  // namespace leadline::app
