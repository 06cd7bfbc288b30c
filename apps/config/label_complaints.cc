#include "apps/config/label_complaints.h"

#include <fmt/format.h>

namespace leadline::app {

std::vector<std::string> label_complaints(const Slam& slam) {
  using Finding = LabelRecord::Finding;
  std::vector<std::string> complaints;
  for (const auto& [kind, label, other] : slam.labels().findings())
    complaints.push_back(kind == Finding::Kind::two_places
                             ? fmt::format("label {} names two places", label)
                             : fmt::format("labels {} and {} are one place", label, other));
  return complaints;
}

}  // namespace leadline::app
