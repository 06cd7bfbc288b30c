/// @file
/// The declarations of all keys of the configuration.
#pragma once

#include "apps/config/config.h"
#include "apps/keys/keys.h"

namespace leadline::app {

/// Visits all keys.
void declare(Keys& keys, Config& config);

/// Section simulation. The sensors are already there.
void declare_simulation(Keys& keys, Config& config);

}  // namespace leadline::app
