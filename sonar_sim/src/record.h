/// @file
/// A simulator run to its end.
#pragma once

#include <utility>
#include <vector>

#include "leadline/vehicle/recording.h"

namespace leadline::internal {

template <class Simulator>
Recording record(Simulator& simulator, std::vector<TrueFeature> map) {
  Recording recording;
  recording.map = std::move(map);
  while (auto step = simulator.next()) {
    recording.instants.push_back(std::move(step->instant));
    recording.truth.push_back(step->truth);
  }
  return recording;
}

}  // namespace leadline::internal
