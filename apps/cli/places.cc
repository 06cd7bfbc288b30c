#include "apps/cli/places.h"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "apps/support/text_table.h"
#include "leadline/core/angle.h"

namespace leadline::app {

std::string table_of(const PlaceAnswer& answer) {
  std::vector<std::vector<std::string>> rows{
      {"x [m]", "y [m]", "heading [deg]", "sd [m]", "sd [deg]", "of heard", "probability"}};
  for (const Place& place : answer.places) {
    const auto& [X, P] = place.X_WV;
    rows.push_back({fmt::format("{:.2f}", X.x), fmt::format("{:.2f}", X.y),
                    fmt::format("{:.1f}", to_degrees(X.heading)),
                    fmt::format("{:.2f}", std::sqrt(0.5 * (P(0, 0) + P(1, 1)))),
                    fmt::format("{:.1f}", to_degrees(std::sqrt(P(2, 2)))),
                    fmt::format("{}", place.matches.size()), fmt::format("{:.4f}", place.probability)});
  }
  rows.push_back({"elsewhere", "", "", "", "", "", fmt::format("{:.4f}", answer.elsewhere)});
  return format_table(rows);
}

}  // namespace leadline::app
