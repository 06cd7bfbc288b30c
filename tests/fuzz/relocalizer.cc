// A map, a picture and a prior of any numbers: a search says that it cannot, or answers with probabilities
// that sum to one and poses that are finite, however small the pieces it works in.
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>
#include <stdexcept>
#include <vector>

#include "leadline/submap/relocalizer.h"

namespace leadline {
namespace {

/// Takes the input apart; zeros follow its end.
class Bytes {
 public:
  explicit Bytes(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  std::uint8_t byte() {
    if (bytes_.empty()) return 0;
    const std::uint8_t first = bytes_.front();
    bytes_ = bytes_.subspan(1);
    return first;
  }
  /// A number of a map for the most part, or any eight bytes.
  double number() {
    const std::uint8_t kind = byte();
    if (kind < 0xf0) return (byte() - 128) / 4.0;
    std::array<std::uint8_t, 8> any{};
    for (std::uint8_t& b : any) b = byte();
    double value = 0.0;
    std::memcpy(&value, any.data(), sizeof value);
    return value;
  }
  Eigen::MatrixXd covariance(int n) {
    Eigen::MatrixXd root(n, n);
    for (Eigen::Index k = 0; k < root.size(); ++k) root.data()[k] = 0.05 * number();
    Eigen::MatrixXd P = root * root.transpose();
    if (byte() == 1 && n > 1) P(0, 1) = number();  // none
    return P;
  }

 private:
  std::span<const std::uint8_t> bytes_;
};

std::vector<Landmark> some_map(Bytes& bytes) {
  std::vector<Landmark> map(bytes.byte() % 24);
  for (Landmark& landmark : map) {
    landmark.id = bytes.byte();
    landmark.kind = bytes.byte() % 3 == 0 ? TargetKind::wall : TargetKind::point;
    landmark.label = bytes.byte() % 8 - 1;
    for (double& value : landmark.value) value = bytes.number();
    landmark.P = bytes.covariance(3);
    if (landmark.is_wall()) landmark.seen = {bytes.number(), bytes.number()};
  }
  return map;
}

LocalPicture some_picture(Bytes& bytes) {
  LocalPicture picture;
  std::vector<Joint::Part> parts;
  int rows = 0;
  const auto add = [&](const Key& key, int size) {
    for (const Joint::Part& part : parts)
      if (part.key == key) return;
    Joint::Part part{.key = key, .value = Belief::VehicleVector(size)};
    for (double& value : part.value) value = bytes.number();
    parts.push_back(part);
    rows += size;
  };
  if (bytes.byte() != 1) add(kVehicle, 3 + bytes.byte() % 3);
  for (int left = bytes.byte() % 12; left > 0; --left) {
    Feature feature;
    feature.id = bytes.byte() % 16;
    feature.kind = static_cast<FeatureKind>(bytes.byte() % 3);
    feature.label = bytes.byte() % 8 - 1;
    feature.seen = {bytes.number(), bytes.number()};
    const bool is_wall = feature.kind == FeatureKind::wall;
    if (bytes.byte() % 8 != 1)
      add({is_wall ? Key::Kind::wall : Key::Kind::point, feature.id}, is_wall ? 3 : 2);
    picture.features.push_back(feature);
  }
  Eigen::MatrixXd P = bytes.covariance(rows);
  picture.joint = Joint(std::move(parts), std::move(P));
  for (int left = bytes.byte() % 3; left > 0; --left)
    picture.heard.push_back({{bytes.number(), bytes.number()}, bytes.number()});
  return picture;
}

PlacePrior some_prior(Bytes& bytes) {
  PlacePrior prior;
  prior.in_map = bytes.byte() / 255.0;
  if (bytes.byte() % 2 == 1) prior.heading = Reading{bytes.number(), bytes.number()};
  if (bytes.byte() % 2 == 1)
    prior.X_WV = UncertainPose{{bytes.number(), bytes.number(), bytes.number()}, bytes.covariance(3)};
  return prior;
}

void require(bool holds) {
  if (!holds) std::abort();
}

void check(const PlaceAnswer& answer) {
  double sum = answer.elsewhere + answer.others;
  for (const Place& place : answer.places) {
    sum += place.probability;
    require(std::isfinite(place.X_WV.X.x) && std::isfinite(place.X_WV.X.y) &&
            std::isfinite(place.X_WV.X.heading));
    require(place.X_WV.P.allFinite() && place.X_WL.P.allFinite());
  }
  require(std::abs(sum - 1.0) < 1e-6);
}

}  // namespace
}  // namespace leadline

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace leadline;
  Bytes bytes({data, size});
  try {
    Relocalizer relocalizer({.seeds = 500, .checks = 20}, some_map(bytes));
    const LocalPicture picture = some_picture(bytes);
    relocalizer.begin(picture, some_prior(bytes));
    while (relocalizer.advance(7)) {
    }
    check(relocalizer.result());
  } catch (const std::invalid_argument&) {  // no map
  }
  return 0;
}
