// What labels that the map contradicts say of the objects that have them.
#include "leadline/submap/label_record.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/random.h"

namespace leadline {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Not;
using LabelFinding = LabelRecord::Finding;

constexpr LabelFinding kTwoPlaces{LabelFinding::Kind::two_places, 17};
constexpr LabelFinding kOnePlace{LabelFinding::Kind::one_place, 3, 17};

TEST(LabelRecord, CountsRefusalsByChannelAndLabel) {
  LabelRecord record;
  record.refuse(0, 17);
  record.refuse(1, 17);
  record.refuse(0, 17);
  EXPECT_THAT(record.refusals(),
              ElementsAre(LabelRecord::Refusals{0, 17, 2}, LabelRecord::Refusals{1, 17, 1}));
}

TEST(LabelRecord, TheLeastCountedMakesRoom) {
  LabelRecord record;
  for (int label = 0; label < LabelRecord::kMost; ++label)
    for (int k = 0; k < (label == 30 ? 1 : 2); ++k) record.refuse(0, label);
  record.refuse(0, 1000);
  EXPECT_EQ(record.refusals().size(), std::size_t{LabelRecord::kMost});
  EXPECT_THAT(record.refusals(), Not(Contains(LabelRecord::Refusals{0, 30, 1})));
  EXPECT_THAT(record.refusals(), Contains(LabelRecord::Refusals{0, 1000, 1}));
}

TEST(LabelRecord, ALabelThatIsOftenElsewhereNamesTwoPlaces) {
  LabelRecord record;
  for (int k = 0; k < 4; ++k) record.count({7, 17, 17, true});
  EXPECT_THAT(record.findings(), IsEmpty());
  record.count({7, 17, 17, true});
  EXPECT_THAT(record.findings(), ElementsAre(kTwoPlaces));
  record.count({8, 17, 5, true});
  EXPECT_THAT(record.findings(), ElementsAre(kTwoPlaces)) << "said once";
  record.forget(7);
  EXPECT_THAT(record.findings(), IsEmpty()) << "the place was none";
}

TEST(LabelRecord, AFeatureOfTwoLabelsIsOnePlace) {
  LabelRecord record;
  for (int k = 0; k < 4; ++k) record.count({7, 17, 3, false});
  for (int k = 0; k < 9; ++k) record.count({7, 3, 3, false});
  EXPECT_THAT(record.findings(), IsEmpty()) << "four are too few";
  record.count({7, 17, 3, false});
  EXPECT_THAT(record.findings(), ElementsAre(kOnePlace));
}

TEST(LabelRecord, AShareOfAFifthIsAnError) {
  LabelRecord record;
  for (int k = 0; k < 20; ++k) {
    record.count({7, 17, 3, true});
    for (int other = 0; other < 4; ++other) record.count({7, 3, 3, false});
  }
  EXPECT_THAT(record.findings(), IsEmpty());
  record.count({7, 17, 3, true});
  EXPECT_THAT(record.findings(), ElementsAre(kTwoPlaces));
}

TEST(LabelRecord, TheFirstLabelOfAFeatureIsNotStrange) {
  LabelRecord record;
  for (int k = 0; k < 10; ++k) record.count({7, 17, Sighting::kUnknown, false});
  for (int k = 0; k < 10; ++k) record.count({7, 17, 17, false});
  EXPECT_THAT(record.findings(), IsEmpty());
}

// Labels that are wrong at random fill the table; one that is wrong of itself stays in it.
TEST(LabelRecord, WhatIsFoundOutlivesManyRandomErrors) {
  LabelRecord record;
  Random random(1);
  for (int k = 0; k < 40; ++k) {
    record.count({7, k % 2 == 0 ? 17 : 3, 3, false});
    for (int other = 0; other < 10; ++other)
      record.count({100 + static_cast<int>(random.uniform(0.0, 50.0)),
                    1000 + static_cast<int>(random.uniform(0.0, 80.0)), 1, true});
  }
  EXPECT_THAT(record.findings(), Contains(kOnePlace));
}

}  // namespace
}  // namespace leadline
