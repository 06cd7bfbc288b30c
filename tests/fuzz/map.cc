// A map, to which the right header is added: an estimator says why it cannot go on with it, or goes on,
// across the borders of submaps, and gives a map that can be gone on with as well.
#include <boost/crc.hpp>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "apps/maps/map_file.h"
#include "leadline/submap/slam.h"

namespace leadline::app {
namespace {

template <class Unsigned>
void append(Unsigned value, std::vector<std::byte>& bytes) {
  for (std::size_t i = 0; i < sizeof value; ++i) bytes.push_back(static_cast<std::byte>(value >> 8 * i));
}

std::vector<std::byte> map_of(std::span<const std::uint8_t> body) {
  boost::crc_32_type crc;
  crc.process_bytes(body.data(), body.size());
  std::vector<std::byte> bytes;
  for (const char c : std::string_view("leadline map\n")) bytes.push_back(static_cast<std::byte>(c));
  append(kMapVersion, bytes);
  append(std::uint64_t{body.size()}, bytes);
  append(std::uint32_t{crc.checksum()}, bytes);
  const auto rest = std::as_bytes(body);
  bytes.insert(bytes.end(), rest.begin(), rest.end());
  return bytes;
}

SlamOptions estimator() {
  SlamOptions options;
  options.sensors.resize(1);
  options.submaps.radius = 3.0;
  options.features.capacity = 20;
  return options;
}

/// Swims out of whatever circle it is in, and is then put back to where it began.
void go_on(Slam& slam) {
  const UncertainPose begin = slam.pose();
  for (int i = 1; i <= 8; ++i) {
    Instant instant;
    instant.utime = slam.utime() < std::numeric_limits<std::int64_t>::max() - 1'000'000
                        ? slam.utime() + 1'000'000
                        : slam.utime();
    instant.speed = Reading{2.0, 0.1};
    instant.sightings = {{0, 1.0 + 0.3 * i, 0.0, i}};
    slam.step(instant);
    if (i % 2 == 0) slam.set_pose({oplus(begin.X, {2.0 * i, 0.0, 0.0}), Eigen::Matrix3d::Identity() * 0.01});
  }
  slam.set_pose({begin.X, Eigen::Matrix3d::Identity() * 0.01});
}

}  // namespace
}  // namespace leadline::app

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace leadline::app;
  static const auto kOptions = estimator();
  try {
    leadline::Slam slam(kOptions, decode_map(map_of({data, size})));
    go_on(slam);
    // What it gives is read, taken and gone on with, or has lost its numbers to overflow and says so.
    leadline::Slam other(kOptions, decode_map(encode_map(slam.snapshot())));
    go_on(other);
  } catch (const std::runtime_error&) {     // no map
  } catch (const std::invalid_argument&) {  // one of another estimator
  }
  return 0;
}
