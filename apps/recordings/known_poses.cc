#include "apps/recordings/known_poses.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>

#include "apps/recordings/csv_reader.h"
#include "apps/support/limits.h"
#include "leadline/core/angle.h"
#include "leadline/core/semidefinite.h"

namespace leadline::app {
namespace {

Eigen::Matrix3d covariance_of(const ReadingSigmas& sigmas) {
  return Eigen::Vector3d(sigmas.pose, sigmas.pose, sigmas.pose_heading).cwiseAbs2().asDiagonal();
}

/// The covariance of a row, if it has one.
std::optional<Eigen::Matrix3d> covariance(const CsvReader& csv) {
  constexpr std::size_t kFirst = 4;
  constexpr std::size_t kEntries[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
  Eigen::Matrix3d P, L;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const auto entry = csv.optional_number(kFirst + kEntries[i][j], limits::kCovariance);
      if (!entry) return std::nullopt;
      P(i, j) = *entry;
    }
  if (P.diagonal().minCoeff() < 0.0 || !semidefinite_cholesky(P, L))
    csv.refuse(kFirst, "with the others a covariance");
  return P;
}

/// Whether a file has no header, but numbers at once.
bool is_tum(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file)
    throw std::runtime_error(fmt::format("{}: cannot read: {}", path.string(), std::strerror(errno)));
  std::string line;
  while (std::getline(file, line))
    if (const auto first = line.find_first_not_of(" \t\r"); first != std::string::npos && line[first] != '#')
      return line.find(',') == std::string::npos && line.find_first_of("0123456789") <= first + 1;
  return false;
}

double number(std::string_view text, Limits limits, const std::string& place) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !limits.contain(value))
    throw std::runtime_error(
        fmt::format("{}: '{:.80}' must be a number from {} to {}", place, text, limits.min, limits.max));
  return value;
}

std::vector<std::string_view> words(std::string_view line) {
  constexpr std::string_view kBlanks = " \t\r";
  std::vector<std::string_view> words;
  for (auto begin = line.find_first_not_of(kBlanks); begin != std::string_view::npos;) {
    const auto end = std::min(line.find_first_of(kBlanks, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kBlanks, end);
  }
  return words;
}

/// The heading of a unit quaternion about any axis: that of its x axis, seen from above.
double heading_of(double x, double y, double z, double w) {
  return std::atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z);
}

}  // namespace

KnownPoses::KnownPoses(const std::filesystem::path& path, const ReadingSigmas& sigmas) {
  if (is_tum(path))
    read_tum(path, covariance_of(sigmas));
  else
    read_csv(path, covariance_of(sigmas));
  if (poses_.empty()) throw std::runtime_error(fmt::format("{}: holds no pose", path.string()));
}

KnownPoses::KnownPoses(const Spool<Truth>& truth, const ReadingSigmas& sigmas) {
  for (const Truth& t : truth)
    if (t.heading && (poses_.empty() || t.utime > poses_.back().utime))
      poses_.push_back({t.utime, {{t.x, t.y, *t.heading}, covariance_of(sigmas)}});
}

void KnownPoses::read_tum(const std::filesystem::path& path, const Eigen::Matrix3d& usual) {
  constexpr std::size_t kColumns = 8;
  constexpr Limits kUnit{-1.01, 1.01};
  std::ifstream file(path);
  std::string line;
  for (std::size_t n = 1; std::getline(file, line); ++n) {
    const std::vector<std::string_view> fields = words(line);
    if (fields.empty() || fields[0].starts_with('#')) continue;
    const std::string place = fmt::format("{}:{}", path.string(), n);
    if (fields.size() != kColumns)
      throw std::runtime_error(
          fmt::format("{}: {} numbers, must be the 8 of t x y z qx qy qz qw", place, fields.size()));
    const auto at = [&](std::size_t k, Limits limits) { return number(fields[k], limits, place); };
    const double t = at(0, {1e-6 * limits::kTime.min, 1e-6 * limits::kTime.max});
    const double heading = heading_of(at(4, kUnit), at(5, kUnit), at(6, kUnit), at(7, kUnit));
    add(std::llround(1e6 * t), {{at(1, limits::kPosition), at(2, limits::kPosition), heading}, usual}, place);
  }
}

void KnownPoses::read_csv(const std::filesystem::path& path, const Eigen::Matrix3d& usual) {
  CsvReader csv(path, "t,x,y,heading", "p_xx,p_xy,p_xh,p_yy,p_yh,p_hh,submap,speed");
  while (csv.next()) {
    const Pose2 X{csv.number(1, limits::kPosition), csv.number(2, limits::kPosition),
                  csv.number(3, limits::kHeading)};
    add(csv.utime(), {X, covariance(csv).value_or(usual)}, csv.place());
  }
}

void KnownPoses::add(std::int64_t utime, const UncertainPose& X_WB, const std::string& place) {
  if (!poses_.empty() && utime <= poses_.back().utime)
    throw std::runtime_error(fmt::format("{}: the time is not after that of the pose before", place));
  poses_.push_back({utime, X_WB});
}

std::optional<UncertainPose> KnownPoses::at(std::int64_t utime) const {
  const auto next = std::ranges::lower_bound(poses_, utime, {}, &Stamped::utime);
  if (next == poses_.end()) return std::nullopt;
  if (next->utime == utime) return next->X_WB;
  if (next == poses_.begin()) return std::nullopt;
  const Stamped& before = *std::prev(next);
  if (next->utime - before.utime > kMostGap) return std::nullopt;
  const double share =
      static_cast<double>(utime - before.utime) / static_cast<double>(next->utime - before.utime);
  const Pose2 &a = before.X_WB.X, &b = next->X_WB.X;
  const Eigen::Vector2d p = (1.0 - share) * a.position() + share * b.position();
  const double turn = angle_difference(b.heading, a.heading);
  // Between two the error is a mixture of theirs; it is taken for as large, for what lies between is guessed.
  const Eigen::Matrix3d P = (1.0 - share) * before.X_WB.P + share * next->X_WB.P;
  return UncertainPose{{p.x(), p.y(), wrap_angle(a.heading + share * turn)}, P};
}

}  // namespace leadline::app
