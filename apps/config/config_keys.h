/// @file
/// The declarations of all keys of the configuration.
#pragma once

#include "apps/config/config.h"
#include "leadline/core/options.h"

namespace leadline::app {

/// Visits all keys.
void declare(OptionVisitor& keys, Config& config);

/// Section simulation. The sensors are already there.
void declare_simulation(OptionVisitor& keys, Config& config);

}  // namespace leadline::app
