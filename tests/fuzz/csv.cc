// A file as one of those that are imported, which the first byte of the input chooses, or as any table.
#include <stdlib.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "apps/recordings/import_csv.h"
#include "apps/report/csv_table.h"
#include "tests/fuzz/memory_file.h"

namespace leadline::app {
namespace {

namespace fs = std::filesystem;

constexpr std::array kNames = {"heading.csv",   "speed.csv",         "velocity.csv",      "ackermann.csv",
                               "odometry.csv",  "range_sonar.csv",   "range_bearing.csv", "truth.csv",
                               "landmarks.csv", "body_velocity.csv", "yaw_rate.csv"};

// For every name a folder in which that file is the input, and something else moves the vehicle.
class Folders {
 public:
  Folders() {
    std::string name = (fs::temp_directory_path() / "leadline_fuzz_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) std::abort();
    root_ = name;
    for (const char* file : kNames) {
      fs::create_directory(root_ / file);
      std::ofstream(root_ / file / "speed.csv") << "t,speed,sigma\n1,0.1,\n";
      fs::remove(root_ / file / file);
      fs::create_symlink(input.path(), root_ / file / file);
    }
  }
  ~Folders() { fs::remove_all(root_); }
  Folders(const Folders&) = delete;
  Folders& operator=(const Folders&) = delete;

  fs::path of(const char* file) const { return root_ / file; }

  const MemoryFile input;

 private:
  fs::path root_;
};

void read_table(const CsvTable& table) {
  for (const std::string& column : table.columns()) {
    static_cast<void>(table.texts(column));
    static_cast<void>(table.times(column));
  }
}

}  // namespace
}  // namespace leadline::app

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace leadline::app;
  static const Folders kFolders;
  if (size == 0) return 0;
  const std::size_t kind = static_cast<std::uint8_t>(data[0] - '0') % (kNames.size() + 2);
  kFolders.input.write({data + 1, size - 1});
  try {
    if (kind < kNames.size()) {
      import_csv(kFolders.of(kNames[kind]));
      std::vector<std::string> faults;
      survey_csv(kFolders.of(kNames[kind]), {.skip_bad = true}, faults);
    } else {
      read_table(kind == kNames.size() ? CsvTable::with_header(kFolders.input.path())
                                       : CsvTable::tum(kFolders.input.path()));
    }
  } catch (const std::runtime_error&) {
  }
  return 0;
}
