/// @file
/// What was heard of late, as the search for its place reads it: in the frame V of the vehicle.
#pragma once

#include <optional>
#include <vector>

#include "landmark_index.h"
#include "leadline/submap/joint.h"
#include "leadline/submap/landmark.h"
#include "leadline/submap/relocalizer.h"

namespace leadline {

/// The frame L in the joint of a HeardPicture.
inline constexpr Key kPictureFrame{Key::Kind::frame, 1};

struct HeardPicture {
  std::vector<Landmark> landmarks;  ///< in V, those known best, the best first
  std::vector<Spread> spreads;
  std::vector<Eigen::Vector2d> middles;   ///< Landmark::middle() of each
  std::vector<LocalPicture::Disc> heard;  ///< in V
  Joint joint;                            ///< in V: kPictureFrame and the landmarks, in this order

  int size() const { return static_cast<int>(landmarks.size()); }
  const Landmark& operator[](int number) const { return landmarks[static_cast<std::size_t>(number)]; }
  const Spread& spread(int number) const { return spreads[static_cast<std::size_t>(number)]; }
  const Joint::Part& part(int number) const { return joint.parts()[static_cast<std::size_t>(number) + 1]; }

  /// What two of them are to each other, of a point and a wall the point first, and its variance.
  struct Relation {
    double size = 0.0;
    double variance = 0.0;
  };
  Relation relation(PairKind kind, int first, int second) const;
};

/// @param most landmarks. @return nothing if there is no vehicle or no landmark to be used.
std::optional<HeardPicture> heard_picture(const LocalPicture& picture, int most);

}  // namespace leadline
