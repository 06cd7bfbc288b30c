/// @file
/// What is less sure than was believed.
#pragma once

#include "leadline/core/belief.h"

namespace leadline {

/// The vehicle is where it was believed to be, but less surely: adds to each of its entries an error that is
/// independent of all else. A heading that may be any becomes no wider. @param sigma of them all, in ordinary
/// coordinates.
Status widen(Belief& belief, const Belief::VehicleVector& sigma);

}  // namespace leadline
