#include "leadline/submap/submap.h"

#include <algorithm>

namespace leadline {

void Submap::freeze(const Joint& joint, const std::vector<Feature>& features) {
  features_.assign(features.begin(), features.end());
  const Key own{Key::Kind::frame, id_};
  parts_.clear();
  P_.clear();
  parts_.reserve(joint.parts().size());
  std::vector<int> rows;
  for (const Joint::Part& part : joint.parts()) {
    if (part.key == own || part.key.kind == Key::Kind::vehicle) continue;
    Part& kept = parts_.emplace_back(Part{.key = part.key, .size = part.size()});
    std::ranges::copy(part.value, kept.value.begin());
    for (int k = 0; k < part.size(); ++k) rows.push_back(part.row + k);
  }
  P_.reserve(rows.size() * (rows.size() + 1) / 2);
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t j = 0; j <= i; ++j) P_.push_back(joint.covariance()(rows[i], rows[j]));
  if (joint.contains(kWorld) && id_ != 0) pose_ = inverse(joint.pose(kWorld));
}

void Submap::shift_clock(std::int64_t shift) {
  for (Feature& feature : features_) feature.shift_clock(shift);
}

Joint Submap::thaw() const {
  std::vector<Joint::Part> parts;
  Eigen::Index n = 0;
  for (const Part& part : parts_) {
    parts.push_back({part.key, Eigen::Map<const Eigen::VectorXd>(part.value.data(), part.size)});
    n += part.size;
  }
  Eigen::MatrixXd P(n, n);
  auto next = P_.begin();
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) P(i, j) = P(j, i) = *next++;
  Joint joint(std::move(parts), std::move(P));
  joint.add_origin({Key::Kind::frame, id_});
  return joint;
}

int Submap::opening(int parent, const std::vector<Gate>& gates) {
  int first = kNone;
  for (const auto& [gate, neighbour] : gates)
    if (neighbour == parent && (first == kNone || gate < first)) first = gate;
  return first;
}

std::optional<Eigen::Vector3d> Submap::value(const Key& key) const {
  const auto part = std::ranges::find(parts_, key, &Part::key);
  if (part == parts_.end()) return std::nullopt;
  return Eigen::Map<const Eigen::Vector3d>(part->value.data());
}

std::size_t Submap::memory() const {
  return sizeof(*this) + features_.capacity() * sizeof(Feature) + gates_.capacity() * sizeof(Gate) +
         parts_.capacity() * sizeof(Part) + P_.capacity() * sizeof(double);
}

}  // namespace leadline
