// A file as a configuration.
#include <cstdint>
#include <stdexcept>

#include "apps/config/config.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace leadline::app;
  static const MemoryFile kFile;
  kFile.write({data, size});
  try {
    read_config(kFile.path());
  } catch (const std::runtime_error&) {
  }
  return 0;
}
