/// @file
/// The car-park recording of Guivant and Nebot (Australian Centre for Field Robotics, University of Sydney).
#pragma once

#include <filesystem>

#include "apps/recordings/import.h"

namespace leadline::app {

/// Reads data_set.mat and beac_juan3.mat in @p folder: a utility car with a scanning laser at its front,
/// wheel and steering encoders, GPS; poles with reflective tape, surveyed.
///
/// The body's origin is the laser. Velocity is that of the left rear wheel in the file and of the axle's
/// centre in the result. Sightings are the reflective targets of each scan (sensor "laser"), without
/// identity. The truth is GPS, without heading; the map the surveyed poles.
/// @throws std::runtime_error naming file, variable, what was found and what is allowed.
Import import_car_park(const std::filesystem::path& folder);

}  // namespace leadline::app
