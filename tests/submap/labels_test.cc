// Labels that name no object of their own are found out by the estimator.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "leadline/submap/slam.h"
#include "tests/submap/points_only.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr LabelRecord::Finding kNamesTwo{LabelRecord::Finding::Kind::two_places, 17};
constexpr LabelRecord::Finding kAreOne{LabelRecord::Finding::Kind::one_place, 3, 17};

/// A vehicle at rest that sees points by a scan or a sonar.
class Labels {
 public:
  explicit Labels(Sensor::Kind kind = Sensor::Kind::range_bearing,
                  AssociationMethod method = AssociationMethod::known)
      : slam_(points_only(kind, 0.05, from_degrees(1.0), method)) {}

  /// A return of each.
  void see(std::vector<Sighting> sightings) {
    for (Sighting& sighting : sightings) sighting.range += random_.normal(0.05);
    Instant instant;
    instant.utime = utime_ += 200'000;
    instant.sightings = std::move(sightings);
    slam_.step(instant);
  }
  const Slam& slam() const { return slam_; }
  std::vector<LabelRecord::Finding> findings() const { return slam_.labels().findings(); }

 private:
  Slam slam_;
  Random random_{3};
  std::int64_t utime_ = 0;
};

TEST(Labels, OneLabelOnTwoObjectsNamesTwoPlaces) {
  for (const auto kind : {Sensor::Kind::range_bearing, Sensor::Kind::range_sonar}) {
    Labels labels(kind);
    for (int k = 0; k < 20; ++k) labels.see({{0, 4.0, 0.0, 17}});
    EXPECT_THAT(labels.findings(), IsEmpty());
    for (int k = 0; k < 20; ++k) labels.see({{0, 8.0, 0.0, 17}});
    EXPECT_THAT(labels.findings(), ElementsAre(kNamesTwo));
  }
}

TEST(Labels, OneObjectOfTwoLabelsIsOnePlace) {
  for (const auto kind : {Sensor::Kind::range_bearing, Sensor::Kind::range_sonar}) {
    Labels labels(kind);
    for (int k = 0; k < 40; ++k) labels.see({{0, 4.0, 0.0, k % 2 == 0 ? 3 : 17}, {0, 8.0, 0.0, 5}});
    EXPECT_THAT(labels.findings(), ElementsAre(kAreOne));
  }
}

TEST(Labels, TwoObjectsOfTwoLabelsAreInOrder) {
  Labels labels;
  for (int k = 0; k < 40; ++k) labels.see({{0, 4.0, 0.0, 3}, {0, 5.0, 0.0, 17}});
  EXPECT_THAT(labels.findings(), IsEmpty());
  EXPECT_THAT(labels.slam().labels().refusals(), IsEmpty());
  EXPECT_EQ(labels.slam().health().labels_refused, 0);
}

TEST(Labels, ALabelIsRefusedOfAnotherFeatureAndWhereItIsDropped) {
  Labels labels;
  for (int k = 0; k < 10; ++k) labels.see({{0, 4.0, 0.0, 3}, {0, 8.0, 0.5, 17}});
  labels.see({{0, 4.0, 0.0, 17}});
  ASSERT_EQ(labels.slam().associations()[0].decision, Decision::matched) << "a wrong label";
  labels.see({{0, 8.0, 0.5, 17}, {0, 9.0, -0.5, 17}});
  ASSERT_EQ(labels.slam().associations()[1].decision, Decision::discarded) << "one too many";
  labels.see({{0, 4.0, 0.0, Sighting::kUnknown}, {0, 12.0, 1.0, 99}});
  EXPECT_THAT(labels.slam().labels().refusals(), ElementsAre(LabelRecord::Refusals{0, 17, 2}));
  EXPECT_EQ(labels.slam().health().labels_refused, 2);
}

TEST(Labels, AreNotAskedForUnlessTheyAreKnown) {
  Labels labels(Sensor::Kind::range_bearing, AssociationMethod::joint);
  for (int k = 0; k < 40; ++k) labels.see({{0, 4.0, 0.0, k % 2 == 0 ? 3 : 17}, {0, 8.0, 0.0, k % 3}});
  EXPECT_THAT(labels.findings(), IsEmpty());
  EXPECT_THAT(labels.slam().labels().refusals(), IsEmpty());
}

}  // namespace
}  // namespace leadline
