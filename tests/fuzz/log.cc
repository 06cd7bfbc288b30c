// A file as an event log.
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "apps/recordings/log.h"
#include "apps/recordings/usage.h"
#include "tests/fuzz/memory_file.h"

namespace {

std::vector<leadline::Sensor> sensors() {
  std::vector<leadline::Sensor> sensors(4);
  sensors[0].name = "port";
  sensors[1].name = "ahead";
  sensors[2].name = "starboard";
  sensors[3].name = "laser";
  sensors[3].kind = leadline::Sensor::Kind::range_bearing;
  return sensors;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace leadline::app;
  static const MemoryFile kFile;
  static const auto kSensors = sensors();
  kFile.write({data, size});
  try {
    LogReport report;
    read_log(kFile.path(), kSensors, report);
  } catch (const std::runtime_error&) {
  }
  try {
    LogDamage damage;
    const Survey survey = survey_log(kFile.path(), damage);
    static_cast<void>(survey.complaints());
    static_cast<void>(table_of(survey));
  } catch (const std::runtime_error&) {
  }
  return 0;
}
