#include "apps/recordings/import_car_park.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <matio.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "apps/recordings/log.h"
#include "leadline/core/angle.h"
#include "tests/apps/recordings/recording_matcher.h"
#include "tests/support/public_recording.h"
#include "tests/support/scratch_folder.h"

namespace leadline::app {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::size_t kBeams = 361;
constexpr double kNoReturn = 81.91;

// Column-major, as MATLAB stores it.
struct Matrix {
  std::size_t rows = 0, cols = 0;
  std::vector<double> values;

  Matrix() = default;
  Matrix(std::size_t r, std::size_t c, double value) : rows(r), cols(c), values(r * c, value) {}
  double& operator()(std::size_t row, std::size_t col) { return values[col * rows + row]; }
};

Matrix row(std::vector<double> values) {
  Matrix row(1, values.size(), 0.0);
  row.values = std::move(values);
  return row;
}

using Variables = std::map<std::string, Matrix>;

void write_mat(const std::filesystem::path& path, const Variables& variables,
               matio_compression compression = MAT_COMPRESSION_NONE) {
  mat_t* file = Mat_CreateVer(path.c_str(), nullptr, MAT_FT_MAT5);
  ASSERT_NE(file, nullptr);
  for (auto [name, matrix] : variables) {
    std::size_t size[2] = {matrix.rows, matrix.cols};
    matvar_t* variable = Mat_VarCreate(name.c_str(), MAT_C_DOUBLE, MAT_T_DOUBLE, 2, size,
                                       matrix.values.data(), MAT_F_DONT_COPY_DATA);
    Mat_VarWrite(file, variable, compression);
    Mat_VarFree(variable);
  }
  Mat_Close(file);
}

// Three scans, four encoder rows, two GPS fixes.
Variables small_data() {
  Variables data;
  data["Time_VS"] = row({10.0, 10.025, 10.05, 10.075});
  data["Velocity"] = row({1.0, 1.0, 2.0, 0.0});
  data["Steering"] = row({0.0, 0.3, -0.3, 0.0});
  data["TimeLaser"] = row({10.01, 10.05, 10.2});
  data["Laser"] = Matrix(3, kBeams, kNoReturn);
  data["Intensity"] = Matrix(3, kBeams, 0.0);
  data["TimeGPS"] = row({10.0, 10.2});
  data["GPSLon"] = row({5.0, 5.1});
  data["GPSLat"] = row({4.0, 4.1});
  const auto lit = [&](std::size_t scan, std::size_t beam, double range) {
    data["Laser"](scan, beam) = range;
    data["Intensity"](scan, beam) = 8192.0;
  };
  data["Laser"](0, 100) = 7.0;  // a wall: not lit
  lit(0, 180, 5.0);             // straight ahead
  lit(0, 270, 3.02);            // 45 degrees to port: four beams, one of them missed
  lit(0, 271, 3.00);
  lit(0, 273, 3.01);
  lit(0, 274, 9.0);        // behind it
  lit(0, 360, kNoReturn);  // lit, yet no return
  lit(1, 0, 2.0);          // 90 degrees to starboard
  lit(1, 3, 2.0);          // beside it by three beams, which are 5 cm so near
  lit(1, 9, 2.0);          // 11 cm off: another
  return data;
}

Variables small_survey() {
  Variables survey;
  survey["estbeac"] = Matrix(2, 2, 0.0);
  survey["estbeac"].values = {1.0, 2.0, -3.0, -4.0};
  return survey;
}

class ImportCarPark : public ::testing::Test {
 protected:
  Import read(const Variables& data, const Variables& survey = small_survey()) {
    write_mat(folder_ / "data_set.mat", data);
    write_mat(folder_ / "beac_juan3.mat", survey);
    return import_car_park(folder_.path());
  }

  std::string error(const std::function<void(Variables&)>& change) {
    Variables data = small_data();
    change(data);
    return error_of<std::runtime_error>([&] { read(data); });
  }

  ScratchFolder folder_;
};

TEST_F(ImportCarPark, FindsThePoles) {
  const auto [recording, sensors] = read(small_data());
  ASSERT_THAT(sensors, SizeIs(1));
  EXPECT_EQ(sensors[0].name, "laser");
  EXPECT_EQ(sensors[0].kind, Sensor::Kind::range_bearing);

  ASSERT_THAT(recording.instants, SizeIs(6));  // one scan comes with an encoder row
  const Instant& first = recording.instants[1];
  EXPECT_EQ(first.utime, 10'010'000);
  ASSERT_THAT(first.sightings, SizeIs(3));
  EXPECT_EQ(first.sightings[0].range, 5.0);
  EXPECT_NEAR(first.sightings[0].bearing, 0.0, 1e-12);
  EXPECT_EQ(first.sightings[0].label, Sighting::kUnknown);
  EXPECT_EQ(first.sightings[1].range, 3.01);
  EXPECT_NEAR(first.sightings[1].bearing, from_degrees(45.75), 1e-12);
  EXPECT_EQ(first.sightings[2].range, 9.0);
  EXPECT_NEAR(first.sightings[2].bearing, from_degrees(47.0), 1e-12);

  const Instant& second = recording.instants[3];
  EXPECT_EQ(second.utime, 10'050'000);
  EXPECT_TRUE(std::holds_alternative<AckermannInput>(second.input));
  ASSERT_THAT(second.sightings, SizeIs(2));
  EXPECT_NEAR(second.sightings[0].bearing, from_degrees(-89.25), 1e-12);
  EXPECT_NEAR(second.sightings[1].bearing, from_degrees(-85.5), 1e-12);

  EXPECT_THAT(recording.instants[5].sightings, IsEmpty());
  EXPECT_THAT(recording.instants[5].silent, ::testing::ElementsAre(0));
}

TEST_F(ImportCarPark, GivesTheSpeedOfTheAxlesCentre) {
  const Recording recording = read(small_data()).recording;
  EXPECT_EQ(std::get<AckermannInput>(recording.instants[0].input).speed, 1.0);
  const auto& left = std::get<AckermannInput>(recording.instants[2].input);
  EXPECT_EQ(left.steering, 0.3);
  // In a turn to port the wheel on that side is slower: H / R less, with R = L / tan(steering).
  EXPECT_NEAR(left.speed * (1.0 - 0.76 / (2.83 / std::tan(0.3))), 1.0, 1e-12);
  EXPECT_LT(std::get<AckermannInput>(recording.instants[3].input).speed, 2.0);
}

TEST_F(ImportCarPark, TakesGpsAndSurveyAsTruth) {
  const Recording recording = read(small_data()).recording;
  ASSERT_THAT(recording.truth, SizeIs(2));
  EXPECT_EQ(recording.truth[1].utime, 10'200'000);
  EXPECT_EQ(recording.truth[1].x, 5.1);
  EXPECT_EQ(recording.truth[1].y, 4.1);
  EXPECT_FALSE(recording.truth[1].heading);
  ASSERT_THAT(recording.map, SizeIs(2));
  EXPECT_EQ(recording.map[1].label, 1);
  EXPECT_EQ(recording.map[1].x, 2.0);
  EXPECT_EQ(recording.map[1].y, -4.0);
}

TEST_F(ImportCarPark, ReadsCompressedFiles) {
  const Recording plain = read(small_data()).recording;
  write_mat(folder_ / "data_set.mat", small_data(), MAT_COMPRESSION_ZLIB);
  EXPECT_THAT(import_car_park(folder_.path()).recording, IsRecording(plain));
}

TEST_F(ImportCarPark, SaysWhatIsWrong) {
  EXPECT_THAT(error([](Variables& data) { data.erase("Laser"); }),
              HasSubstr("data_set.mat: variable Laser is missing or damaged"));
  EXPECT_THAT(error([](Variables& data) { data["Laser"] = Matrix(3, 360, 1.0); }),
              HasSubstr("variable Laser is 3 x 360, must be 3 x 361"));
  EXPECT_THAT(error([](Variables& data) { data["Intensity"] = Matrix(2, kBeams, 0.0); }),
              HasSubstr("variable Intensity is 2 x 361, must be 3 x 361"));
  EXPECT_THAT(error([](Variables& data) { data["Velocity"] = Matrix(3, 1, 0.0); }),
              HasSubstr("variable Velocity is 3 x 1, must be a vector of 4 elements"));
  EXPECT_THAT(error([](Variables& data) { data["Time_VS"] = Matrix(2, 2, 0.0); }),
              HasSubstr("variable Time_VS is 2 x 2, must be a vector of any elements"));
  EXPECT_THAT(error([](Variables& data) { data["Laser"](1, 2) = std::nan(""); }),
              HasSubstr("variable Laser has nan in row 2, column 3, must be from 0 to 100000"));
  EXPECT_THAT(error([](Variables& data) { data["Steering"].values[1] = 1.5; }),
              HasSubstr("variable Steering has 1.5 in row 1, column 2, must be from -1 to 1"));
  EXPECT_THAT(error([](Variables& data) { data["TimeGPS"].values[1] = 10.0; }),
              HasSubstr("variable TimeGPS: 10 is followed by 10, must increase"));

  std::filesystem::remove(folder_ / "beac_juan3.mat");
  EXPECT_THAT(error_of<std::runtime_error>([&] { import_car_park(folder_.path()); }),
              HasSubstr("beac_juan3.mat: cannot read: No such file"));
}

TEST_F(ImportCarPark, RefusesOtherTypes) {
  read(small_data());
  mat_t* file = Mat_CreateVer((folder_ / "beac_juan3.mat").c_str(), nullptr, MAT_FT_MAT5);
  std::vector<float> values(4, 1.0F);
  std::size_t size[2] = {2, 2};
  matvar_t* variable = Mat_VarCreate("estbeac", MAT_C_SINGLE, MAT_T_SINGLE, 2, size, values.data(), 0);
  Mat_VarWrite(file, variable, MAT_COMPRESSION_NONE);
  Mat_VarFree(variable);
  Mat_Close(file);
  EXPECT_THAT(error_of<std::runtime_error>([&] { import_car_park(folder_.path()); }),
              HasSubstr("beac_juan3.mat: variable estbeac must be a matrix of real doubles"));
}

TEST_F(ImportCarPark, RefusesFilesThatAreNotMatlabs) {
  read(small_data());
  const auto message = [&](std::string_view content) {
    folder_.write("data_set.mat", content);
    return error_of<std::runtime_error>([&] { import_car_park(folder_.path()); });
  };
  EXPECT_THAT(message(""), HasSubstr("data_set.mat: must be a MATLAB file of version 5 to 7"));
  EXPECT_THAT(message("t,heading,sigma\n"), HasSubstr("must be a MATLAB file"));
  EXPECT_THAT(message(std::string(1000, '\xff')), HasSubstr("must be a MATLAB file"));
}

// Whatever the bytes: an error or a recording, in bounded time and memory.
TEST_F(ImportCarPark, SurvivesCutsAndMutation) {
  read(small_data());
  for (const auto compression : {MAT_COMPRESSION_NONE, MAT_COMPRESSION_ZLIB}) {
    write_mat(folder_ / "data_set.mat", small_data(), compression);
    const std::string sound = read_bytes(folder_ / "data_set.mat");
    std::mt19937 random(4);
    for (int trial = 0; trial < 1000; ++trial) {
      std::string bytes = sound;
      if (trial % 4 == 0) bytes.resize(random() % bytes.size());
      for (auto changes = random() % 4; changes > 0 && !bytes.empty(); --changes) {
        // Headers of variables stand near the small ones; the matrices of beams are mostly values.
        const std::size_t span = random() % 2 == 0 ? std::min<std::size_t>(bytes.size(), 700) : bytes.size();
        bytes[random() % span] = static_cast<char>(random() % 3 == 0 ? 0xff : random());
      }
      folder_.write("data_set.mat", bytes);
      try {
        import_car_park(folder_.path());
      } catch (const std::runtime_error& error) {
        EXPECT_THAT(error.what(), HasSubstr("data_set.mat: "));
      }
    }
  }
}

TEST(ImportCarParkRecording, AgreesWithGpsAndSurvey) {
  const auto source = public_recording("car_park");
  if (!source) GTEST_SKIP() << kNoRecordings;
  const auto [recording, sensors] = import_car_park(*source);
  EXPECT_THAT(recording.truth, SizeIs(626));
  EXPECT_THAT(recording.map, SizeIs(15));

  // Where each sighting lies, with GPS as position and its course, less the slip of the laser ahead of the
  // axle, as heading: near a surveyed pole if all signs and frames are right.
  constexpr double kWheelBase = 2.83, kForward = 3.78, kToPort = 0.5;
  std::size_t inputs = 0, scans = 0, empty_scans = 0, sightings = 0;
  double steering = 0.0;
  std::vector<double> distances;
  for (const Instant& instant : recording.instants) {
    if (const auto* input = std::get_if<AckermannInput>(&instant.input)) {
      steering = input->steering;
      ++inputs;
    }
    scans += !instant.sightings.empty();
    empty_scans += !instant.silent.empty();
    sightings += instant.sightings.size();
    const auto after = std::ranges::lower_bound(recording.truth, instant.utime, {}, &Truth::utime);
    if (after - recording.truth.begin() < 2 || recording.truth.end() - after < 2) continue;
    const Truth &a = after[-1], &b = after[0], &before = after[-2], &beyond = after[1];
    const double share =
        static_cast<double>(instant.utime - a.utime) / static_cast<double>(b.utime - a.utime);
    const double turn = std::tan(steering) / kWheelBase;
    const double slip = std::atan2(kForward * turn, 1.0 - kToPort * turn);
    const double heading = std::atan2(beyond.y - before.y, beyond.x - before.x) - slip;
    for (const Sighting& s : instant.sightings) {
      const double x = std::lerp(a.x, b.x, share) + s.range * std::cos(heading + s.bearing);
      const double y = std::lerp(a.y, b.y, share) + s.range * std::sin(heading + s.bearing);
      double nearest = 1e9;
      for (const TrueFeature& pole : recording.map)
        nearest = std::min(nearest, std::hypot(x - pole.x, y - pole.y));
      distances.push_back(nearest);
    }
  }
  EXPECT_EQ(inputs, 5001U);
  EXPECT_EQ(scans, 506U);
  EXPECT_EQ(empty_scans, 80U);
  EXPECT_EQ(sightings, 892U);
  std::ranges::sort(distances);
  EXPECT_LT(distances[distances.size() / 2], 0.16);  // [m]; 0.14

  const ScratchFolder folder;
  write_log(recording, sensors, folder / "run.lcmlog");
  LogReport report;
  EXPECT_THAT(read_log(folder / "run.lcmlog", sensors, report), IsRecording(recording));
}

}  // namespace
}  // namespace leadline::app
