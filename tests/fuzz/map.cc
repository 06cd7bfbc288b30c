// A map, to which the right header is added: an estimator goes on with it, or says why not.
#include <boost/crc.hpp>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "apps/node/map_file.h"
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
  append(std::uint32_t{1}, bytes);  // version
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

}  // namespace
}  // namespace leadline::app

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace leadline::app;
  static const auto kOptions = estimator();
  try {
    const leadline::Slam slam(kOptions, decode_map(map_of({data, size})));
  } catch (const std::runtime_error&) {     // no map
  } catch (const std::invalid_argument&) {  // one of another estimator
  }
  return 0;
}
