#include "apps/config/sensor_complaints.h"

#include <fmt/format.h>

namespace leadline::app {

std::vector<std::string> sensor_complaints(const Slam& slam) {
  const SlamOptions& configured = slam.options();
  const double overlook = configured.features.overlook_probability;
  std::vector<std::string> complaints;
  for (std::size_t i = 0; i < configured.sensors.size(); ++i) {
    const Sensor& told = configured.sensors[i];
    const Sensor& learnt = slam.map().sensors()[i];
    const std::string name = told.name.empty() ? fmt::format("{}", i) : told.name;
    if (slam.map().channels()[i].misses_more(overlook))
      complaints.push_back(fmt::format(
          "sensor {} misses {:.0f} % of what it should meet, not {:.0f} % (features.overlook_probability)",
          name, 100.0 * slam.map().channels().miss_rate(i).mean(), 100.0 * overlook));
    if (learnt.wall_roughness > told.wall_roughness)
      complaints.push_back(
          fmt::format("echoes of walls scatter by {:.2g} m at sensor {}, not {:.2g} m (wall_roughness_m)",
                      learnt.wall_roughness, name, told.wall_roughness));
  }
  return complaints;
}

}  // namespace leadline::app
