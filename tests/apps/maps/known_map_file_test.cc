#include "apps/maps/known_map_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "apps/maps/map_file.h"
#include "leadline/submap/slam.h"
#include "tests/support/matchers.h"
#include "tests/support/scratch_folder.h"

namespace leadline::app {
namespace {

using ::testing::HasSubstr;

SlamOptions localizer() {
  SlamOptions options;
  options.problem = Problem::localization;
  options.motion = OdometryMotion::Options{};
  options.sensors.emplace_back();
  return options;
}

Slam begun(const KnownMapFile& file) { return {localizer(), file.begin(localizer(), 5)}; }

TEST(KnownMapFile, OfLandmarks) {
  const ScratchFolder folder;
  const Slam slam =
      begun(KnownMapFile(folder.write("landmarks.csv", "id,x,y,sigma\n6,1.5,-2,\n9,3,4,0.1\n")));
  ASSERT_EQ(slam.features().size(), 2U);
  EXPECT_EQ(slam.features()[0].label, 6);
  EXPECT_THAT(slam.belief().position(slam.features()[0].point_slot), IsNear(Eigen::Vector2d(1.5, -2.0), 0.0));
  EXPECT_TRUE(slam.belief().position_covariance(slam.features()[0].point_slot).isZero(1e-15)) << "exact";
  EXPECT_NEAR(slam.belief().position_covariance(slam.features()[1].point_slot)(0, 0), 0.01, 1e-12);
  EXPECT_EQ(slam.utime(), 5);
}

// The columns of a result folder: what is not confirmed is not known, walls are told by their lines.
TEST(KnownMapFile, OfAResultFolder) {
  const ScratchFolder folder;
  folder.write(
      "map.csv",
      "id,kind,submap,status,hits,x,y,p_xx,p_xy,p_yy,rho,alpha,radius,sigma_radius,scale,sigma_scale,label\n"
      "0,wall,0,confirmed,30,,,0.04,0,0.01,5,1.5,,,,,\n"
      "1,undecided,0,tentative,1,1,1,1,0,1,,,,,,,\n"
      "2,edge,0,confirmed,9,3,4,0.25,0.1,0.5,,,,,,,17\n");
  const Slam slam = begun(KnownMapFile(folder.path()));
  ASSERT_EQ(slam.features().size(), 2U);
  EXPECT_EQ(slam.features()[0].kind, FeatureKind::wall);
  EXPECT_NEAR(slam.belief().line(slam.features()[0].wall_slot).rho, 5.0, 1e-12);
  EXPECT_NEAR(slam.belief().line(slam.features()[0].wall_slot).P(0, 0), 0.04, 1e-12);
  EXPECT_EQ(slam.features()[0].label, Sighting::kUnknown);
  EXPECT_EQ(slam.features()[1].label, 17);
  EXPECT_NEAR(slam.belief().position_covariance(slam.features()[1].point_slot)(0, 1), 0.1, 1e-12);
}

// What is not confirmed in it is left out.
TEST(KnownMapFile, OfANodeThatHasSavedIt) {
  const ScratchFolder folder;
  const KnownMapFile landmarks(folder.write("landmarks.csv", "id,x,y,sigma\n6,1.5,-2,0.5\n9,3,4,0.1\n"));
  Snapshot saved = landmarks.begin(localizer(), 5);
  saved.features[1].confirmed = false;
  const std::vector<std::byte> bytes = encode_map(saved);
  const KnownMapFile file(folder.write("a.map", {reinterpret_cast<const char*>(bytes.data()), bytes.size()}));
  const Slam slam(localizer(), file.begin(localizer(), 77));
  EXPECT_EQ(slam.utime(), 77);
  ASSERT_EQ(slam.features().size(), 1U) << "of the confirmed ones";
  EXPECT_TRUE(slam.map().is_known(slam.features()[0]));
  EXPECT_EQ(file.features(localizer()).size(), 1U);
}

TEST(KnownMapFile, SaysWhatIsWrong) {
  const ScratchFolder folder;
  const auto error = [&](std::string_view content) {
    const auto path = folder.write("f", content);
    return error_of<std::runtime_error>([&] { begun(KnownMapFile(path)); });
  };
  EXPECT_THAT(error("id,x\n1,2\n"), HasSubstr("y"));
  EXPECT_THAT(error("id,x,y\n"), HasSubstr("holds no feature that is confirmed"));
  EXPECT_THAT(error("id,x,y\n-3,1,2\n"), HasSubstr("f:2"));
  EXPECT_THAT(error("id,x,y\n1,1,2\n1,3,4\n"), HasSubstr("feature 1 is there twice"));
  EXPECT_THAT(error("id,x,y,p_xx,p_xy,p_yy\n1,1,2,1,5,1\n"), HasSubstr("feature 1 has no place"));
  EXPECT_THAT(error("id,x,y,kind,status\n1,,,wall,confirmed\n"), HasSubstr("rho"));
  EXPECT_THAT(error("leadline map\ngarbage"), HasSubstr("f"));
  EXPECT_THAT(error_of<std::runtime_error>([&] { KnownMapFile(folder / "none"); }), HasSubstr("none"));
}

}  // namespace
}  // namespace leadline::app
