#include "apps/recordings/import.h"

#include <utility>

#include "apps/recordings/import_car_park.h"
#include "apps/recordings/import_csv.h"

namespace leadline::app {
namespace {

/// A source that was read as a whole.
class WholeSource : public ImportSource {
 public:
  explicit WholeSource(Import import)
      : import_(std::move(import)), source_(import_.recording, import_.sensors) {}

  std::optional<Instant> next_instant() override { return source_.next_instant(); }
  std::optional<Truth> next_truth() override { return source_.next_truth(); }
  std::span<const TrueFeature> map() const override { return source_.map(); }
  std::span<const Sensor> sensors() const override { return source_.sensors(); }
  std::vector<std::string> notes() const override { return {}; }

 private:
  Import import_;
  RecordedSource source_;
};

std::unique_ptr<ImportSource> open_car_park(const std::filesystem::path& folder, const ImportOptions&) {
  return std::make_unique<WholeSource>(import_car_park(folder));
}

}  // namespace

std::span<const Importer> importers() {
  static constexpr Importer kImporters[] = {
      {"car-park", "folder with data_set.mat and beac_juan3.mat (Guivant and Nebot, University of Sydney)",
       false, open_car_park},
      {"csv", "folder of CSV files, one per sensor, times in seconds, SI units, radians", true, open_csv},
  };
  return kImporters;
}

}  // namespace leadline::app
