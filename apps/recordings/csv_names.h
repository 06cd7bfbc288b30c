/// @file
/// The files of a folder that is imported, by their names.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace leadline::app {

/// What says how the vehicle moves: without any reading of that, what is seen from it.
enum class Moves : std::int8_t { no, measured, as_input };

/// What may be in a folder.
struct KnownFile {
  std::string_view name;
  Moves moves = Moves::no;
};
inline constexpr KnownFile kKnownFiles[] = {{"heading.csv"},
                                            {"speed.csv", Moves::measured},
                                            {"body_velocity.csv", Moves::measured},
                                            {"yaw_rate.csv"},
                                            {"velocity.csv", Moves::as_input},
                                            {"ackermann.csv", Moves::as_input},
                                            {"odometry.csv", Moves::as_input},
                                            {"range_sonar.csv", Moves::measured},
                                            {"range_bearing.csv", Moves::measured},
                                            {"truth.csv"},
                                            {"landmarks.csv"}};

bool is_known(std::string_view name);

/// All that are known, for people.
std::string known_names();

/// The known name that is most like another one; empty if none is.
std::string_view known_name_like(const std::string& name);

/// Whether a file may be meant for one of ours.
bool may_be_table(const std::string& name);

/// Files of a folder, but for hidden ones, in the order of their names.
std::vector<std::string> files_of(const std::filesystem::path& folder);

}  // namespace leadline::app
