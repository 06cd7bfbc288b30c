#include "leadline/submap/place_agreement.h"

#include <cmath>

#include "leadline/core/angle.h"

namespace leadline {

bool is_at(const Place& place, const UncertainPose& X_WB, const RelocalizerOptions& search) {
  constexpr double kSigmas = 3.0;
  const auto within = [](double off, double variance, double same) {
    return std::abs(off) < kSigmas * std::sqrt(variance + same * same);
  };
  const Pose2 &X = place.X_WV.X, &Y = X_WB.X;
  const Eigen::Matrix3d P = place.X_WV.P + X_WB.P;
  return within((X.position() - Y.position()).norm(), P(0, 0) + P(1, 1), search.same_place) &&
         within(angle_difference(X.heading, Y.heading), P(2, 2), search.same_heading);
}

void PlaceAgreement::note(const PlaceAnswer& answer, const UncertainPose& X_LV) {
  if (answer.verdict != PlaceAnswer::Verdict::found) {
    agreed_ = 0;
    return;
  }
  const Place& place = answer.places.front();
  const bool is_same = agreed_ > 0 && is_at(place, oplus(*X_WL_, X_LV), options_.search);
  agreed_ = is_same ? agreed_ + 1 : 1;
  X_WL_ = place.X_WL;
}

}  // namespace leadline
