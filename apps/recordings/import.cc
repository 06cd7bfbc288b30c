#include "apps/recordings/import.h"

#include "apps/recordings/import_car_park.h"
#include "apps/recordings/import_csv.h"

namespace leadline::app {

std::span<const Importer> importers() {
  static constexpr Importer kImporters[] = {
      {"car-park", "folder with data_set.mat and beac_juan3.mat (Guivant and Nebot, University of Sydney)",
       import_car_park},
      {"csv", "folder of CSV files, one per sensor, times in seconds, SI units, radians", import_csv},
  };
  return kImporters;
}

}  // namespace leadline::app
