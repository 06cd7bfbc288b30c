/// @file
/// What of a recording is of use, to whom.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "apps/recordings/survey.h"
#include "leadline/submap/options.h"

namespace leadline::app {

/// Which models and sensors a channel is for.
std::string users_of(const Channel& channel);

/// Whether a vehicle of these options uses what a channel says.
bool is_used(const Channel& channel, const SlamOptions& options);

/// What drives the model, and everything that was recorded, is there and of use.
/// @param prefix of the channels that are read.
/// @throws std::runtime_error naming what is missing or of no use, and what is there.
void check_use(const std::filesystem::path& log, const Survey& survey, const SlamOptions& options,
               std::string_view prefix);

/// What was recorded, as a table for people.
std::vector<std::vector<std::string>> table_of(const Survey& survey);

}  // namespace leadline::app
